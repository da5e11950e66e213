"""Runs gprodom-replay, the estimator driven by a log, with progress."""

from __future__ import annotations

import contextlib
import os
import shutil
import subprocess
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path

import gprodom
from gprodom.errors import Error

PROGRAM = "gprodom-replay"
POLL_S = 0.2


def find_program(name: str = PROGRAM) -> Path:
    """The program of this checkout's build, else the one on the path."""
    build = gprodom._build_folder()
    if build is not None and (build / "bin" / name).is_file():
        return build / "bin" / name
    found = shutil.which(name)
    if found is None:
        raise Error(
            f"{name} is not built or not installed: run scripts/setup (in a checkout), then "
            "`. scripts/env`"
        )
    return Path(found)


def default_config() -> Path:
    """gprodom.yaml of this checkout, else the installed one."""
    checkout = Path(gprodom.__file__).resolve().parents[2]
    for path in (checkout / "config" / "gprodom.yaml", Path("/etc/gprodom/gprodom.yaml")):
        if path.is_file():
            return path
    raise Error("no default configuration found: give one with -c")


def run_replay(
    log: Path,
    output: Path,
    config: Path | None = None,
    overrides: Sequence[str] = (),
    on_progress: Callable[[float], None] | None = None,
) -> None:
    """Replays `log` into `output`; raises `Error` with the program's own last line where it fails.

    `config` is the default configuration where None.
    `on_progress` is told the share of the log that is read, from 0 to 1.
    """
    command = [
        str(find_program()),
        "-c",
        str(config or default_config()),
        str(log),
        "-o",
        str(output),
    ]
    for override in overrides:
        command += ["--set", override]
    with tempfile.TemporaryFile() as said:
        process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=said)
        try:
            while True:
                with contextlib.suppress(subprocess.TimeoutExpired):
                    process.wait(POLL_S)
                    break
                if on_progress is not None:
                    on_progress(_share_read(process.pid, log))
        finally:
            if process.poll() is None:
                process.terminate()
                process.wait()
        if process.returncode != 0:
            said.seek(0)
            raise Error(_failure(said.read(), process.returncode))


def _failure(said: bytes, code: int) -> str:
    lines = [line for line in said.decode("utf-8", errors="replace").splitlines() if line.strip()]
    last = lines[-1].strip() if lines else "it said nothing"
    return f"{PROGRAM} ended with {f'signal {-code}' if code < 0 else f'code {code}'}: {last}"


def _share_read(pid: int, log: Path) -> float:
    """How far into `log` the process has read: the kernel tells the position of its open file."""
    with contextlib.suppress(OSError, ValueError):
        target = log.resolve()
        for link in Path(f"/proc/{pid}/fd").iterdir():
            if Path(os.readlink(link)) == target:
                info = Path(f"/proc/{pid}/fdinfo/{link.name}").read_text()
                position = int(info.split("pos:", 1)[1].split(None, 1)[0])
                return position / max(target.stat().st_size, 1)
    return 0.0
