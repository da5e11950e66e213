"""What a power cut leaves of a folder, from the system calls of a program that writes in it.

strace records the calls. A cut after some of them leaves what was synchronised to disk by then. Of
what was not, chance decides: of changes of names a part of their order, of the contents of a file
nothing, a part or all.
"""

from __future__ import annotations

import random
import re
import subprocess
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

CALLS = (
    "openat,write,writev,pwrite64,fsync,fdatasync,rename,renameat,renameat2,link,linkat,unlink,"
    "unlinkat"
)
WRITES = ("write", "writev", "pwrite64")
LINE = re.compile(r"^(\d+\.\d+) (\w+)\((.*)\) += (-?\d+)", re.S)
STRING = re.compile(r'"((?:\\x[0-9a-f]{2})*)"')
DESCRIPTOR = re.compile(r"^\d+<((?:\\x[0-9a-f]{2}|[^>])*)>")


@dataclass(frozen=True)
class Call:
    """A call that succeeded: its name, the paths it names and the bytes that it writes."""

    name: str
    paths: tuple[Path, ...]
    data: bytes = b""
    creates: bool = False
    truncates: bool = False


def record(command: Sequence[str], folder: Path, into: Path) -> list[Call]:
    """Runs a command, and returns its calls on files of the folder, in order."""
    into.mkdir()
    options = ["-ff", "-ttt", "-y", "-xx", "-s", "100000000", "-e", f"trace={CALLS}"]
    subprocess.run(["strace", *options, "-o", str(into / "calls"), *command], check=True)
    found = []
    for path in into.iterdir():  # one of each thread
        for line in path.read_text().splitlines():
            match = LINE.match(line)
            if match and int(match[4]) >= 0:
                found.append((float(match[1]), _call(match[2], match[3])))
    calls = [call for _, call in sorted(found, key=lambda each: each[0])]
    return [c for c in calls if c.paths and all(p.parent == folder or p == folder for p in c.paths)]


def _bytes(escaped: str) -> bytes:
    return bytes.fromhex(escaped.replace("\\x", "")) if "\\x" in escaped else escaped.encode()


def _call(name: str, arguments: str) -> Call:
    strings = [_bytes(text) for text in STRING.findall(arguments)]
    if name in (*WRITES, "fsync", "fdatasync"):
        opened = DESCRIPTOR.match(arguments)
        path = Path(_bytes(opened[1]).decode()) if opened else Path()
        return Call(name, (path,), b"".join(strings))
    paths = tuple(Path(text.decode()) for text in strings)
    return Call(name, paths, b"", "O_CREAT" in arguments, "O_TRUNC" in arguments)


@dataclass
class _File:
    now: bytes = b""
    on_disk: bytes = b""


@dataclass
class _Disk:
    """A folder: what programs see, and what is safe."""

    names: dict[str, _File]
    safe: dict[str, _File] = field(default_factory=dict)
    pending: list[tuple[Call, _File]] = field(default_factory=list)  # changes of names

    def do(self, call: Call, folder: Path) -> None:
        """Carries out a call."""
        first = call.paths[0]
        file = self.names.get(first.name)
        if call.name in ("fsync", "fdatasync"):
            if first == folder:
                self.safe, self.pending = dict(self.names), []
            elif file:
                file.on_disk = file.now
        elif call.name in WRITES:
            if file:
                file.now += call.data
        elif call.name == "openat" and file:
            file.now = b"" if call.truncates else file.now
        elif call.name != "openat" or call.creates:
            meant = file or _File()
            _change(self.names, call, meant)
            self.pending.append((call, meant))

    def after_cut(self, chance: random.Random) -> dict[str, bytes]:
        """What is there when the power is back."""
        names = dict(self.safe)
        for call, file in self.pending[: chance.randint(0, len(self.pending))]:
            _change(names, call, file)
        return {name: _left(file, chance) for name, file in names.items()}


def _left(file: _File, chance: random.Random) -> bytes:
    if file.now == file.on_disk:
        return file.on_disk
    return chance.choice([file.on_disk, b"", file.now[: chance.randint(0, len(file.now))]])


def _change(names: dict[str, _File], call: Call, file: _File) -> None:
    """Of a call that gives a file a name, another one, or takes it away."""
    first, last = call.paths[0].name, call.paths[-1].name
    if call.name.startswith(("rename", "unlink")):
        names.pop(first, None)
    if not call.name.startswith("unlink"):
        names[last] = file


def cut(
    before: dict[str, bytes], calls: list[Call], at: int, folder: Path, chance: random.Random
) -> dict[str, bytes]:
    """The files of the folder after a power cut behind so many of the calls.

    before: its files when the calls began, on disk."""
    files = {name: _File(data, data) for name, data in before.items()}
    disk = _Disk(files, dict(files))
    for call in calls[:at]:
        disk.do(call, folder)
    return disk.after_cut(chance)
