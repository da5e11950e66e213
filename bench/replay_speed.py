#!/usr/bin/env python3
"""How fast gprodom-replay is, and what a solve costs: IMU, wheel and radar standstills.

Each log is replayed with the default configuration and with 10 states/s and 5 s of lag. Printed are
the times real time, by wall clock and by processor time (which other work on the machine does not
change much), and the mean time of a solve with the newest state's covariance. The best of --repeats
runs counts. One core: the program has one thread.

    bench/replay_speed.py SEQ...
    bench/replay_speed.py SEQ --set gpr.enabled=false --json
"""

from __future__ import annotations

import json
import subprocess
from itertools import product
from pathlib import Path
from typing import Any

from gprodom.config import Configs, config_arguments
from gprodom.errors import Error
from gprodom.files import temporary_folder
from gprodom.odometry.replay import find_program
from gprodom.options import add_config_options
from processes import children_seconds
from program import exit_with, one_by_one, parser_of, print_rows
from zips import log_of

CASES = {
    "default": [],
    "10 states/s, lag 5 s": ["smoother.state_rate=10", "smoother.lag=5.0"],
}


def replay(log: Path, configs: Configs, overrides: list[str], folder: Path) -> dict[str, float]:
    """One replay's figures."""
    stats = folder / "stats.json"
    command = [str(find_program()), *config_arguments(configs), str(log)]
    command += ["-o", str(folder / "out.lcmlog"), "--stats", str(stats)]
    for override in overrides:
        command += ["--set", override]
    before = children_seconds()
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode != 0:
        raise Error(done.stderr.strip().splitlines()[-1])
    spent = children_seconds() - before
    said: dict[str, Any] = json.loads(stats.read_text())
    return {
        "times_real_time": said["times_real_time"],
        "times_real_time_cpu": said["log_seconds"] / spent,
        "solve_ms": said["solver"]["mean_ms"],
        "steps_per_solve": said["values"]["solver.steps"] / said["values"]["states"],
    }


def main() -> None:
    """Runs the command line."""
    parser = parser_of(__doc__)
    parser.add_argument("logs", nargs="+", type=Path, metavar="SEQ", help="zip or log")
    add_config_options(parser)
    parser.add_argument("--repeats", type=int, default=3, help="default: 3")
    args = parser.parse_args()
    results: list[dict[str, Any]] = []
    with temporary_folder() as folder:
        logs = [log_of(source, folder) for source in args.logs]
        for log, (case, overrides) in one_by_one("replays", list(product(logs, CASES.items()))):
            given = [*overrides, *args.overrides]
            runs = [replay(log, args.configs, given, folder) for _ in range(args.repeats)]
            best = max(runs, key=lambda run: run["times_real_time_cpu"])  # the least disturbed
            results.append({"log": log.name, "case": case, **best})
    header = ["log", "case", "x real time", "x, processor", "ms a solve", "steps a solve"]
    print_rows(args, results, header)


if __name__ == "__main__":
    exit_with(main)
