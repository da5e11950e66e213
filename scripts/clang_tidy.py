"""Runs clang-tidy over src/ in parallel, leaving out what passed before unchanged.

Each file is compiled for itself here (build-tidy/), so that an include that it lacks is seen. A
file's key is its content, that of every header of the project that it includes, .clang-tidy, and
clang-tidy's version. Keys that passed are kept in the user's cache folder, so that another checkout
of the same state is quick too.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import os
import re
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
BUILD = ROOT / "build-tidy"
INCLUDED_FROM = (ROOT / "src", ROOT / "include", BUILD / "generated")
CACHE = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "gprodom" / "clang-tidy"
# That of the virtual environment, three times as quick as that of Debian 12, which goes through the
# headers of every library.
CLANG_TIDY = Path(sys.executable).parent / "clang-tidy"


def output_of(*command: str) -> str:
    """What the command prints; it must succeed."""
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def compiled_sources() -> list[Path]:
    """Sources in src/, with how each is compiled in BUILD/compile_commands.json."""
    output_of(
        *("cmake", "-S", str(ROOT), "-B", str(BUILD), "-G", "Ninja"),
        *("-DCMAKE_UNITY_BUILD=OFF", "-DBUILD_TESTING=OFF", "-DGPRODOM_BENCHMARKS=OFF"),
    )
    output_of("cmake", "--build", str(BUILD), "--target", "gprodom_lcmtypes_generated")
    commands = json.loads((BUILD / "compile_commands.json").read_text())
    files = {Path(command["file"]) for command in commands}  # some belong to several targets
    return sorted(file for file in files if file.is_relative_to(ROOT / "src"))


def headers_of(path: Path, known: dict[Path, set[Path]]) -> set[Path]:
    """The project's headers that a file includes, directly or not; `known` keeps what was found."""
    if path not in known:
        known[path] = set()  # a header that is included in a circle ends here
        for name in re.findall(r'^#include [<"]([^>"]+)[>"]', path.read_text(), re.MULTILINE):
            for folder in INCLUDED_FROM:
                if (header := folder / name).is_file():
                    known[path] |= {header} | headers_of(header, known)
    return known[path]


def key_of(source: Path, headers: set[Path], common: bytes) -> str:
    """Changes whenever clang-tidy could say something new about a file."""
    digest = hashlib.sha256(common)
    for path in [source, *sorted(headers)]:
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
    CACHE.mkdir(parents=True, exist_ok=True)
    sources = compiled_sources()
    known: dict[Path, set[Path]] = {}
    pending: list[tuple[Path, Path]] = []
    for source in sources:
        stamp = CACHE / key_of(source, headers_of(source, known), common)
        if stamp.exists():
            stamp.touch()
        else:
            pending.append((source, stamp))
    print(f"{len(sources)} files, {len(pending)} to check", flush=True)

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
