#!/usr/bin/env python3
"""Compares the daemon, live on sequences, with a replay of the same logs.

Each log is played to gprodomd over LCM in a network namespace of its own (scripts/live) at --speed
times real time, and replayed. The logger's record tells what the daemon heard and said. Printed are
messages of IMU, wheel and radar that the daemon may have missed (those that the logger, listening
beside it, did not hear), results of the radar, the window and the map that were not there at their
data time, the poses compared, and the largest distance between the two in ODOMETRY at one stamp.
Exit code 1 where that is over a centimetre in a run that lost nothing and was never late.

    bench/live_against_replay.py LOG.lcmlog... --speed 2 -j 2
"""

from __future__ import annotations

import subprocess
import tempfile
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from gprodom.config import Configs, config_arguments
from gprodom.errors import Error
from gprodom.lcm import logs
from gprodom.odometry.replay import find_program, run_replay
from gprodom.options import add_config_option
from program import exit_with, in_processes, parser_of, print_rows

LIVE = Path(__file__).resolve().parents[1] / "scripts" / "live"
INPUTS = ["IMU", "WHEEL", "GPR_TRACE"]
LIMIT_M = 0.01
LATE = ("not answered within", "not ready after")  # in the names of what STATUS counts


def positions(log: Path) -> tuple[np.ndarray, np.ndarray]:
    """Stamps and positions (n, 3) of ODOMETRY."""
    odometry = logs.read(log, ["ODOMETRY"])["ODOMETRY"]
    return odometry["utime"], odometry["position"]


def count(log: Path) -> int:
    """Messages of the sensors in a log."""
    return sum(len(channel["utime"]) for channel in logs.read(log, INPUTS).values())


def late(log: Path) -> int:
    """Results that were not there at their data time, by the last STATUS."""
    status = logs.read(log, ["STATUS"])["STATUS"]["messages"][-1]
    told = zip(status.names, status.values, strict=True)
    return int(sum(value for name, value in told if any(words in name for words in LATE)))


def compare(log: Path, configs: Configs, speed: float) -> dict[str, Any]:
    """One log both ways."""
    with tempfile.TemporaryDirectory(prefix="gprodom-") as name:
        live, replayed = Path(name) / "live.lcmlog", Path(name) / "replay.lcmlog"
        # scripts/live takes one file.
        config = Path(name) / "config.yaml"
        merge = [str(find_program("gprodomd")), *config_arguments(configs), "--print-config"]
        config.write_bytes(subprocess.run(merge, check=True, capture_output=True).stdout)
        command = [str(LIVE), str(config), str(log), str(live), str(speed)]
        ran = subprocess.run(command, capture_output=True, text=True)
        if ran.returncode != 0:
            raise Error(f"{log.name}: scripts/live: {ran.stderr.strip()}")
        run_replay(log, replayed, configs)
        stamps_live, live_m = positions(live)
        stamps_replay, replay_m = positions(replayed)
        _, i, j = np.intersect1d(stamps_live, stamps_replay, return_indices=True)
        if len(i) == 0:
            raise Error(f"{log.name}: no pose in common")
        apart = np.linalg.norm(live_m[i] - replay_m[j], axis=1)
        return {
            "log": log.name,
            "lost": count(log) - count(live),
            "late": late(live),
            "poses": len(stamps_replay),
            "compared": len(i),
            "max_m": float(apart.max()),
            "equal_share": float((apart < 1e-9).mean()),
        }


def main() -> int:
    """Runs the command line."""
    parser = parser_of(__doc__, jobs=1)
    parser.add_argument("logs", nargs="+", type=Path, metavar="LOG.lcmlog")
    add_config_option(parser)
    parser.add_argument("--speed", type=float, default=2.0, help="times real time (default: 2)")
    args = parser.parse_args()
    work = partial(compare, configs=args.configs, speed=args.speed)
    results = in_processes(args.jobs, "logs", work, args.logs)
    header = ["log", "lost", "late", "poses", "compared", "apart at most (m)", "share equal"]
    print_rows(args, results, header)
    wrong = [r for r in results if r["lost"] == r["late"] == 0 and r["max_m"] > LIMIT_M]
    return 1 if wrong else 0


if __name__ == "__main__":
    exit_with(main)
