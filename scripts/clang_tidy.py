"""Runs clang-tidy over src/ in parallel, leaving out what passed before unchanged.

A file's key is the content of the file, of every header of the project that its object was built
from (as ninja recorded it), of .clang-tidy, and clang-tidy's version. Keys that passed are kept in
the user's cache folder, so that another checkout of the same state is quick too.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import os
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
BUILD = ROOT / "build"
CACHE = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "gprodom" / "clang-tidy"
# That of the virtual environment, three times as quick as that of Debian 12, which goes through the
# headers of every library.
CLANG_TIDY = Path(sys.executable).parent / "clang-tidy"
OURS = ("src/", "include/", "lcmtypes/")


def output_of(*command: str) -> str:
    """What the command prints; it must succeed."""
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def recorded_dependencies() -> dict[str, list[Path]]:
    """Files that each object was built from, by the object's path in the build folder."""
    dependencies: dict[str, list[Path]] = {}
    current: list[Path] = []
    for line in output_of("ninja", "-C", str(BUILD), "-t", "deps").splitlines():
        if line and not line.startswith((" ", "ninja:")):
            current = dependencies.setdefault(line.split(":", 1)[0], [])
        elif line.strip():
            current.append((BUILD / line.strip()).resolve())
    return dependencies


def key_of(dependencies: list[Path], common: bytes) -> str:
    """Changes whenever clang-tidy could say something new about a file."""
    digest = hashlib.sha256(common)
    for path in sorted(dependencies):
        if path.is_relative_to(ROOT) and str(path.relative_to(ROOT)).startswith(OURS):
            digest.update(str(path.relative_to(ROOT)).encode() + b"\0" + path.read_bytes())
    return digest.hexdigest()


def check(source: Path, stamp: Path) -> tuple[Path, str, float]:
    """Runs clang-tidy on one file: the file, what is wrong with it, seconds taken."""
    started = time.monotonic()
    result = subprocess.run(
        [str(CLANG_TIDY), "-p", str(BUILD), "--quiet", str(source)],
        capture_output=True,
        text=True,
        cwd=ROOT,
    )
    problems = "" if result.returncode == 0 else result.stdout + result.stderr
    if not problems:
        stamp.touch()
    return source, problems, time.monotonic() - started


def main() -> int:
    """Exit code 0 where every file is clean."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--jobs", type=int, default=2, help="how many at once (2)")
    jobs: int = parser.parse_args().jobs

    common = (ROOT / ".clang-tidy").read_bytes() + output_of(str(CLANG_TIDY), "--version").encode()
    dependencies = recorded_dependencies()
    CACHE.mkdir(parents=True, exist_ok=True)
    pending: list[tuple[Path, Path]] = []
    total = 0
    for entry in json.loads((BUILD / "compile_commands.json").read_text()):
        source = Path(entry["file"])
        if not source.is_relative_to(ROOT / "src"):
            continue
        total += 1
        target = entry["command"].split(" -o ", 1)[1].split(" ", 1)[0]
        stamp = CACHE / key_of([source, *dependencies.get(target, [])], common)
        if stamp.exists():
            stamp.touch()
        else:
            pending.append((source, stamp))
    print(f"{total} files, {len(pending)} to check", flush=True)

    failures = 0
    with ThreadPoolExecutor(jobs) as pool:
        results = pool.map(lambda work: check(*work), pending)
        for number, (source, problems, seconds) in enumerate(results, start=1):
            name = source.relative_to(ROOT)
            print(f"[{number}/{len(pending)}] {name} {seconds:.1f} s", flush=True)
            if problems:
                failures += 1
                print(problems, flush=True)
    remove_old_stamps()
    return 1 if failures else 0


def remove_old_stamps(days: float = 60.0) -> None:
    """Forgets what has not been asked for in a long while."""
    for stamp in CACHE.iterdir():
        if time.time() - stamp.stat().st_mtime > days * 86400:
            stamp.unlink(missing_ok=True)


if __name__ == "__main__":
    sys.exit(main())
