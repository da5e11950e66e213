#!/usr/bin/env python3
"""The google-benchmark programs: processor time of each kernel, microseconds.

Each is repeated; told are the least time, as what else the machine does only adds to it, and by how
much the repetitions differ.

    bench/kernels.py [--only gpr_sfm] [--repetitions 3] [--json]
"""

from __future__ import annotations

import json
import subprocess
from pathlib import Path
from statistics import pstdev

import gprodom
from gprodom.errors import Error
from program import exit_with, one_by_one, parser_of, print_rows

PROGRAMS = ("message", "gpr_filter", "gpr_peaks", "gpr_sfm", "gpr_revisit", "estimation", "map")
TO_MICROSECONDS = {"ns": 1e-3, "us": 1.0, "ms": 1e3, "s": 1e6}


def measure(program: Path, repetitions: int, min_time: float) -> list[dict[str, float | str]]:
    """A row for each benchmark of a program."""
    command = [str(program), "--benchmark_format=json", f"--benchmark_min_time={min_time}"]
    done = subprocess.run(
        [*command, f"--benchmark_repetitions={repetitions}"], stdout=subprocess.PIPE, text=True
    )
    if done.returncode != 0:
        raise Error(f"{program}: exit code {done.returncode}")
    times: dict[str, list[float]] = {}
    for each in json.loads(done.stdout)["benchmarks"]:
        if each.get("run_type") == "iteration":
            microseconds = each["cpu_time"] * TO_MICROSECONDS[each["time_unit"]]
            times.setdefault(each["run_name"], []).append(microseconds)
    label = program.name.removeprefix("bench_")
    return [
        {"name": f"{label}: {name}", "us": min(found), "spread_us": pstdev(found)}
        for name, found in times.items()
    ]


def main() -> None:
    """Runs the command line."""
    parser = parser_of(__doc__)
    parser.add_argument("--only", choices=PROGRAMS, action="append", default=[])
    parser.add_argument("--repetitions", type=int, default=3, help="default: %(default)s")
    parser.add_argument("--min-time", type=float, default=0.05, help="s each (%(default)s)")
    args = parser.parse_args()
    if gprodom._build is None:
        raise Error("not run from a checkout that is built")
    rows: list[dict[str, float | str]] = []
    for name in one_by_one("kernels", args.only or PROGRAMS):
        program = gprodom._build / "bench" / f"bench_{name}"
        if not program.is_file():
            raise Error(f"{program}: not built")
        rows += measure(program, args.repetitions, args.min_time)
    print_rows(args, rows, ["kernel", "us", "+-"])


if __name__ == "__main__":
    exit_with(main)
