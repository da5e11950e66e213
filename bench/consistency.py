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

With --robot the drives are of 60 m, of a robot with left and right wheels (gprodom simulate).

    bench/consistency.py --runs 200
    bench/consistency.py --runs 100 --robot skid_steer --surface gravel
    bench/consistency.py --runs 40 --set smoother.lag=5 --json
"""

from __future__ import annotations

import argparse
import sys
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from typing import Any

import numpy as np

from gprodom.benchmark.monte_carlo import End, end_of_drive, judge
from gprodom.console import Progress, add_json_flag, format_table, print_json
from gprodom.errors import Error
from gprodom.simulate.robot import KINDS
from gprodom.simulate.surface import SURFACES


def summarise(ends: list[End]) -> dict[str, Any]:
    """The figures of ``--json``."""
    errors = np.array([end.error for end in ends])
    variances = np.array([np.diag(end.covariance) for end in ends])
    return {
        "runs": len(ends),
        "nees_xy": judge([end.nees_xy for end in ends], 2),
        "nees_yaw": judge([end.nees_yaw for end in ends], 1),
        "rms_error": np.sqrt(np.mean(errors**2, axis=0)),
        "rms_sigma": np.sqrt(np.mean(variances, axis=0)),
        "ends": [
            {"seed": end.seed, "error": end.error, "nees_xy": end.nees_xy, "nees_yaw": end.nees_yaw}
            for end in ends
        ],
    }


def main() -> int:
    """Runs the command line."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--runs", type=int, default=200, help="default: %(default)s")
    parser.add_argument("--first-seed", type=int, default=0, help="default: %(default)s")
    parser.add_argument("--jobs", type=int, default=2, help="at once (default: %(default)s)")
    parser.add_argument("--robot", choices=sorted(KINDS))
    parser.add_argument(
        "--surface", choices=sorted(SURFACES), default="floor", help="default: %(default)s"
    )
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", dest="overrides")
    add_json_flag(parser)
    args = parser.parse_args()
    seeds = range(args.first_seed, args.first_seed + args.runs)
    ends: list[End] = []
    work = partial(end_of_drive, overrides=args.overrides, kind=args.robot, surface=args.surface)
    try:
        with (
            ProcessPoolExecutor(args.jobs) as pool,
            Progress("consistency", len(seeds)) as progress,
        ):
            for end in pool.map(work, seeds):
                ends.append(end)
                progress.advance()
    except Error as error:
        print(f"consistency: error: {error}", file=sys.stderr)
        return 1
    summary = summarise(ends)
    if args.json:
        print_json(summary)
    else:
        rows = [
            [name, *(summary[name][key] for key in ("mean", "low", "high", "inside"))]
            for name in ("nees_xy", "nees_yaw")
        ]
        print(format_table(["", "mean", "99 % low", "high", "inside"], rows))
        for at, (name, unit) in enumerate((("x", "mm"), ("y", "mm"), ("yaw", "mrad"))):
            rms, sigma = 1e3 * summary["rms_error"][at], 1e3 * summary["rms_sigma"][at]
            print(f"{name}: RMS error {rms:.2f} {unit}, RMS sigma {sigma:.2f} {unit}")
    return 0 if summary["nees_xy"]["inside"] and summary["nees_yaw"]["inside"] else 1


if __name__ == "__main__":
    sys.exit(main())
