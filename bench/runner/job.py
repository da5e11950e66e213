"""A bench, its jobs, and by which program and data they are known again."""

from __future__ import annotations

import ast
import hashlib
import os
import subprocess
import sys
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from figures import Read
from gprodom.errors import Error
from gprodom.own_code import digest_of_code

CHECKOUT = Path(__file__).resolve().parents[2]
BENCH = CHECKOUT / "bench"
# Of the C++ programs and their settings; the Python package has a digest of its own.
SOURCES = ("CMakeLists.txt", "cmake", "config", "include", "lcmtypes", "src")
MOST_S = 3600.0  # of a job: more is a job that hangs


@dataclass(frozen=True)
class Job:
    """One call of a bench program. name: within its bench. arguments: of the program; {data} stands
    for the folder of recorded data, {checkout} for the present checkout. data: the files and
    folders that it reads, likewise; those among its arguments where none are given. short: also run
    by --short, with these arguments where given."""

    name: str
    arguments: tuple[str, ...]
    data: tuple[str, ...] = ()
    short: bool | tuple[str, ...] = False
    prefix: str = ""

    def __post_init__(self) -> None:
        named = (word for word in self.arguments if word.startswith("{") and "/config/" not in word)
        object.__setattr__(self, "data", self.data or tuple(named))

    def command(self, short: bool) -> tuple[str, ...]:
        """Its arguments in this form."""
        return self.short if short and isinstance(self.short, tuple) else self.arguments


@dataclass(frozen=True)
class Bench:
    """name: as `bench/run` takes it. title: what it measures, for people. read: makes figures of
    what the program prints with --json. program: in bench/; NAME.py where none is given. alone:
    measures times, so that nothing runs beside it. settable: takes --set. compiled: uses bench
    programs in C++."""

    name: str
    title: str
    read: Read
    jobs: tuple[Job, ...]
    program: str = ""
    alone: bool = False
    settable: bool = True
    compiled: bool = False

    def __post_init__(self) -> None:
        object.__setattr__(self, "program", self.program or f"{self.name}.py")


@dataclass(frozen=True)
class Program:
    """A built checkout that benches measure: this one, or that of another commit. The benches
    themselves are always the present ones."""

    root: Path = CHECKOUT
    commit: str = ""

    def environment(self) -> dict[str, str]:
        """That makes a bench use it."""
        paths = [str(self.root / "scripts"), os.environ.get("PYTHONPATH", "")]
        build = str(self.root / "build")
        return {"PYTHONPATH": os.pathsep.join(filter(None, paths)), "GPRODOM_BUILD": build}

    @cache  # noqa: B019 - one or two of them live, as long as the process
    def digest(self) -> str:
        """Of the sources that figures depend on."""
        digest = hashlib.sha256(digest_of_code(self.root / "scripts" / "gprodom").encode())
        for path in sorted(_files(self.root / name for name in SOURCES)):
            digest.update(f"{path.relative_to(self.root)}\n".encode() + path.read_bytes() + b"\0")
        return digest.hexdigest()


def commit_of(folder: Path) -> str:
    """The commit that is checked out, with + where files differ from it."""
    command = ["git", "-C", str(folder), "describe", "--always", "--abbrev=10", "--exclude=*"]
    done = subprocess.run([*command, "--dirty=+"], capture_output=True, text=True)
    return done.stdout.strip() or "unknown"


def _files(paths: Iterable[Path]) -> Iterable[Path]:
    for path in paths:
        if path.is_dir():
            yield from (each for each in path.rglob("*") if each.is_file())
        elif path.is_file():
            yield path


@cache
def digest_of_bench(program: str) -> str:
    """Of a bench program and of what it imports from beside it."""
    found: dict[Path, bytes] = {}
    open_paths = [BENCH / program]
    while open_paths:
        path = open_paths.pop()
        if path in found:
            continue
        if path.is_dir():
            open_paths += path.glob("*.py")
            continue
        found[path] = path.read_bytes()
        if path.suffix == ".py":
            open_paths += [
                near
                for name in _imports(found[path].decode())
                for folder in (path.parent, BENCH)
                if (near := folder / f"{name}.py").is_file()
            ]
    digest = hashlib.sha256()
    for path, content in sorted(found.items()):
        digest.update(f"{path.relative_to(BENCH)}\n".encode() + content + b"\0")
    return digest.hexdigest()


def _imports(source: str) -> set[str]:
    names: set[str] = set()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            names.add(node.module)
    return names


@cache
def _digest_of_file(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


def filled(text: str, data: Path) -> str:
    """With the folders that {data} and {checkout} stand for."""
    return text.replace("{data}", str(data)).replace("{checkout}", str(CHECKOUT))


def digests_of_data(job: Job, data: Path) -> dict[str, str]:
    """SHA-256 of each file that the job reads, by its path in data folder or checkout; of a
    sequence's zip also the files of the same name beside it."""
    found: dict[str, str] = {}
    for name in job.data:
        path = Path(filled(name, data))
        if not path.exists():
            raise Error(f"{path}: not there")
        root = data if path.is_relative_to(data) else CHECKOUT
        beside = path.parent.glob(f"{path.stem}.*") if path.suffix == ".zip" else []
        for file in sorted({*_files([path]), *beside}):
            found[file.relative_to(root).as_posix()] = _digest_of_file(file)
    return found


def key_of(program: Program, bench: Bench, command: tuple[str, ...], data: dict[str, str]) -> str:
    """By which the result of a job is kept: of program, bench, arguments and data."""
    sources = BENCH / bench.program
    facts = [program.digest(), digest_of_bench(bench.program), sources.name, command, data]
    return hashlib.sha256(repr(facts).encode()).hexdigest()


def command_line(bench: Bench, command: tuple[str, ...], data: Path) -> tuple[str, ...]:
    """What is called for a job."""
    path = BENCH / bench.program
    return (sys.executable, str(path), "--json", *(filled(word, data) for word in command))
