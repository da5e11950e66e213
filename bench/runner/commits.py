"""The program of another commit, to measure beside the present one."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

from job import CHECKOUT, Program

from gprodom.errors import Error, UsageError

SOURCES_DONE = ".sources-are-whole"


def sources_of(revision: str, folder: Path) -> Program:
    """Its sources, kept in `folder`; to be built by `build`."""
    name = f"{revision}^{{commit}}"
    try:
        commit = _call("git", "-C", str(CHECKOUT), "rev-parse", "--verify", name).strip()
    except Error:
        raise UsageError(f"{revision}: no such commit, and no folder of figures") from None
    root = folder / commit[:12]
    if not (root / SOURCES_DONE).is_file():
        root.mkdir(parents=True, exist_ok=True)
        archive = root / "sources.tar"
        _call("git", "-C", str(CHECKOUT), "archive", "-o", str(archive), commit)
        _call("tar", "-xf", str(archive), "-C", str(root))
        archive.unlink()
        (root / SOURCES_DONE).touch()
    return Program(root, commit[:10])


def build(program: Program, targets: Sequence[str]) -> None:
    """Builds these of it where they are not built."""
    print(f"building {program.commit}", file=sys.stderr, flush=True)
    folder = program.root / "build"  # as in other checkouts, so that a compiler cache knows it
    options = [f"-DGPRODOM_PYTHON={sys.executable}", f"-DCMAKE_BUILD_TYPE={_build_type()}"]
    _call("cmake", "-S", str(program.root), "-B", str(folder), "-G", "Ninja", *options)
    at_once = str(os.cpu_count() or 1)
    _call("cmake", "--build", str(folder), "-j", at_once, "--target", *targets)


def _call(*command: str) -> str:
    """What a command prints; raises `Error` with the end of what it says where it fails."""
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode != 0:
        said = (done.stdout + done.stderr).strip()[-2000:]
        raise Error(f"{' '.join(command)}: {said or f'exit code {done.returncode}'}")
    return done.stdout


def _build_type() -> str:
    """How the present program is built: with other optimisation the last digits may differ."""
    found = re.search(
        r"^CMAKE_BUILD_TYPE:\w+=(\w+)$", (CHECKOUT / "build" / "CMakeCache.txt").read_text(), re.M
    )
    return found.group(1) if found else "RelWithDebInfo"
