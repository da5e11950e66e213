#!/usr/bin/env python3
"""The window solved by Ceres and by the chain (smoother.solver): do they publish the same?

Each log is replayed with both. Printed are, over all poses of ODOMETRY, the largest distance
between the two and the largest difference of their position covariances over the variance there,
whether a second replay by Ceres gives the same bytes, and for each solver the mean time of a solve
and the times real time by processor time. Exit code 1 where positions are further apart than
--max-m, or bytes differ.

    bench/window_solvers.py SEQ... -c config/cmu_gpr.yaml
"""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import Any

import numpy as np

from gprodom.config import Configs
from gprodom.console import format_table
from gprodom.errors import Error
from gprodom.files import temporary_folder
from gprodom.lcm import logs
from gprodom.options import add_config_options
from program import exit_with, one_by_one, parser_of, print_figures
from replay_speed import replay
from zips import log_of

SOLVERS = ("ceres", "chain")


def published(folder: Path) -> tuple[np.ndarray, np.ndarray]:
    """Positions (n, 3) and their covariances (n, 3, 3) of ODOMETRY."""
    odometry = logs.read(folder / "out.lcmlog", ["ODOMETRY"])["ODOMETRY"]
    covariance = odometry["pose_covariance"].reshape(-1, 6, 6)[:, :3, :3]
    return odometry["position"], covariance


def relative(a: np.ndarray, b: np.ndarray) -> float:
    """The largest difference of covariances in units of the standard deviations of `b`."""
    sigma = np.sqrt(np.einsum("nii->ni", b))
    return float((np.abs(a - b) / (sigma[:, :, None] * sigma[:, None, :])).max())


def compare(log: Path, configs: Configs, overrides: list[str]) -> dict[str, Any]:
    """One log by both solvers."""
    figures: dict[str, Any] = {}
    said: dict[str, tuple[np.ndarray, np.ndarray]] = {}
    digests = []
    with temporary_folder() as folder:
        for solver in ("ceres", *SOLVERS):
            run = replay(log, configs, [*overrides, f"smoother.solver={solver}"], folder)
            said[solver] = published(folder)
            if solver == "ceres":
                digests.append(hashlib.sha256((folder / "out.lcmlog").read_bytes()).hexdigest())
            figures[f"{solver}_ms"] = run["solve_ms"]
            figures[f"{solver}_x"] = run["times_real_time_cpu"]
    by_ceres, by_chain = said["ceres"], said["chain"]
    if len(by_ceres[0]) != len(by_chain[0]):
        raise Error(f"{log.name}: one solver publishes more poses than the other")
    return {
        "log": log.name,
        "poses": len(by_ceres[0]),
        "max_m": float(np.linalg.norm(by_ceres[0] - by_chain[0], axis=1).max()),
        "covariance": relative(by_ceres[1], by_chain[1]),
        "same_bytes": digests[0] == digests[1],
        **figures,
    }


def main() -> int:
    """Runs the command line."""
    parser = parser_of(__doc__)
    parser.add_argument("logs", nargs="+", type=Path, metavar="SEQ", help="zip or log")
    add_config_options(parser)
    parser.add_argument("--max-m", type=float, default=1e-6, help="default: %(default)s")
    args = parser.parse_args()
    results: list[dict[str, Any]] = []
    with temporary_folder() as folder:
        for log in one_by_one("logs", [log_of(source, folder) for source in args.logs]):
            results.append(compare(log, args.configs, args.overrides))
    names = ("ceres ms", "ceres x", "chain ms", "chain x")
    header = ["log", "poses", "apart, m", "covariance", "same bytes", *names]
    small = ("max_m", "covariance")
    rows = [[f"{v:.1e}" if k in small else v for k, v in row.items()] for row in results]
    print_figures(args, results, format_table(header, rows))
    alike = all(row["max_m"] <= args.max_m for row in results)
    return 0 if alike and all(row["same_bytes"] for row in results) else 1


if __name__ == "__main__":
    exit_with(main, failed=2)
