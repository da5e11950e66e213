#!/usr/bin/env python3
"""The same 400 m of a yard, driven again and again: cost, memory, map and covariance by day.

Runs bench_yard (bench/yard.cpp says what it does and tells). Days of data in one run, or in
--pieces that go on from each other's state directory; with a shorter --rest before each round, a
day's rounds are had in fewer hours.

    bench/yard.py 48
    bench/yard.py 168 --pieces 7
    bench/yard.py 14 --pieces 7 --rest 60
"""

from __future__ import annotations

import json
import subprocess
from pathlib import Path
from typing import Any

import gprodom
from gprodom.errors import Error
from gprodom.files import temporary_folder
from program import exit_with, parser_of, print_figures, table_of

BY_DAY = ("day", "rounds", "cpu_ms_per_s", "yardsticks_per_s", "resident_mb", "map_mb")
BY_DAY += ("nees_xy", "nees_yaw", "rmse_m", "rmse_in_map_m", "revisits", "restarts")


def run(program: Path, words: list[str]) -> dict[str, Any]:
    """What it tells; it shows its own progress."""
    if not program.is_file():
        raise Error(f"{program}: not built: run scripts/setup")
    with temporary_folder() as folder:
        told = folder / "told.json"
        done = subprocess.run([program, *words, "--json", told])
        if done.returncode != 0:
            raise Error(f"{program.name}: exit code {done.returncode}")
        found: dict[str, Any] = json.loads(told.read_text(encoding="utf-8"))
        return found


def main() -> None:
    """Runs the command line."""
    parser = parser_of(__doc__, overrides=True)
    parser.add_argument("hours", type=float, metavar="HOURS", help="of data")
    parser.add_argument("--pieces", type=int, default=1, help="runs (default: %(default)s)")
    parser.add_argument("--rest", type=float, default=1600.0, help="s (default: %(default)s)")
    parser.add_argument("--seed", type=int, default=1, help="default: %(default)s")
    args = parser.parse_args()
    options = {"pieces": args.pieces, "rest": args.rest, "seed": args.seed}
    words = [str(args.hours), *args.overrides]
    for name, value in options.items():
        words += [f"--{name}", str(value)]
    found = run((gprodom._build or Path("build")) / "bench" / "bench_yard", words)
    rows = [{key: day[key] for key in BY_DAY} for day in found["days"]]
    print_figures(args, found, table_of(rows))


if __name__ == "__main__":
    exit_with(main)
