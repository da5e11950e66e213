#!/usr/bin/env python3
"""Is the estimator's covariance true? Monte Carlo over simulated drives, at run end, in `odom`.

Each run draws biases, wheel scale, noise and side slip from the model that the configuration
states, drives some 40 s without slip, and is estimated. The truth is placed by its first pose, yaw
included, at the estimator's first output. Of the errors at the end,

    NEES of x, y   e^T P^-1 e    2 degrees of freedom
    NEES of yaw    e^2 / P       1 degree of freedom

are averaged over the runs; N times the mean is chi-square with N times the degrees of freedom if
the covariance is true, and should lie in its 99 % band. Exit code 1 where one does not. P holds
the origin's prior too (1 mm, 1 mrad), which the error by this placing does not: it takes a tenth
off the mean for yaw, and next to nothing off that for x, y.

With --robot the drives are of 60 m, of a robot with left and right wheels (gprodom simulate): a row
for each robot and surface given. Beside NEES stands the error of all poses (aligned by se2, mean
over the runs) and that of dead reckoning. Drives are made, run and forgotten in memory.

    bench/consistency.py --runs 200
    bench/consistency.py --runs 100 --robot all
    bench/consistency.py --runs 100 --robot skid_steer --surface gravel --surface ice
    bench/consistency.py --runs 40 --set smoother.lag=5 --json
"""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from gprodom.benchmark.monte_carlo import End, end_of_drive, judge
from gprodom.simulate.robot import KINDS
from gprodom.simulate.surface import SURFACES
from program import add_seeds, exit_with, in_processes, parser_of, print_figures, seeds_of, table_of

NEES = ("nees_xy", "nees_yaw")
ERRORS = ("rmse_m", "reckoned_m")


def summarise(ends: list[End]) -> dict[str, Any]:
    """The figures of ``--json``."""
    errors = np.array([end.error for end in ends])
    variances = np.array([np.diag(end.covariance) for end in ends])
    rmse, reckoned = (float(np.mean([getattr(end, name) for end in ends])) for name in ERRORS)
    return {
        "runs": len(ends),
        "nees_xy": judge([end.nees_xy for end in ends], 2),
        "nees_yaw": judge([end.nees_yaw for end in ends], 1),
        "rms_error": np.sqrt(np.mean(errors**2, axis=0)),
        "rms_sigma": np.sqrt(np.mean(variances, axis=0)),
        "rmse_m": rmse,
        "reckoned_m": reckoned,
        "over_reckoned": rmse / reckoned,
        "ends": [
            {"seed": end.seed, "error": end.error, "nees_xy": end.nees_xy, "nees_yaw": end.nees_yaw}
            | {name: getattr(end, name) for name in ERRORS}
            for end in ends
        ],
    }


def table(summaries: dict[str, dict[str, Any]]) -> str:
    """For people: a row each."""
    rows = []
    for name, summary in summaries.items():
        row = {"drives": f"{name} ({summary['runs']})"}
        for nees in NEES:
            row |= {f"{nees} {key}": summary[nees][key] for key in ("mean", "low", "high")}
        rows.append(row | {key: summary[key] for key in (*ERRORS, "over_reckoned")})
    return table_of(rows)


def main() -> int:
    """Runs the command line."""
    parser = parser_of(__doc__, jobs=2, overrides=True)
    add_seeds(parser, "--runs", 200)
    parser.add_argument("--robot", choices=[*sorted(KINDS), "all"], action="append", default=[])
    parser.add_argument(
        "--surface", choices=sorted(SURFACES), action="append", help="default: floor"
    )
    args = parser.parse_args()
    kinds = sorted(KINDS) if "all" in args.robot else args.robot
    cases: list[tuple[str | None, str]] = [
        (kind, surface) for kind in kinds or [None] for surface in args.surface or ["floor"]
    ]
    summaries: dict[str, dict[str, Any]] = {}
    for kind, surface in cases:
        name = f"{kind}, {surface}" if kind else "plain"
        work = partial(end_of_drive, overrides=args.overrides, kind=kind, surface=surface)
        summaries[name] = summarise(in_processes(args.jobs, name, work, seeds_of(args)))
    print_figures(args, summaries, table(summaries))
    judged = [each[name]["inside"] for each in summaries.values() for name in NEES]
    return 0 if all(judged) else 1


if __name__ == "__main__":
    exit_with(main)
