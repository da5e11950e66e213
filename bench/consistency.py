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

    bench/consistency.py --runs 200
    bench/consistency.py --runs 40 --set smoother.lag=5 --json
"""

from __future__ import annotations

import argparse
import math
import sys
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

import gprodom
from gprodom.console import Progress, add_json_flag, format_table, print_json
from gprodom.errors import Error
from gprodom.simulate import Simulated, Spec, make_route, simulate, stream
from gprodom.simulate.recording import as_recording

DISTANCE = 12.0  # m
SPEED = 0.6  # m/s, at most
STANDSTILL = 4.0  # s, at first
BAND = 0.99


@dataclass(frozen=True)
class End:
    """Error and covariance at the end of one run: x, y (m), yaw (rad)."""

    seed: int
    error: tuple[float, float, float]
    covariance: list[list[float]]  # of x, y, yaw

    @property
    def nees_xy(self) -> float:
        """Normalised squared error of the position."""
        error, covariance = np.array(self.error[:2]), np.array(self.covariance)[:2, :2]
        return float(error @ np.linalg.solve(covariance, error))

    @property
    def nees_yaw(self) -> float:
        """Normalised squared error of the yaw."""
        return self.error[2] ** 2 / self.covariance[2][2]


def drive(seed: int) -> Simulated:
    """The drive of one run."""
    route = make_route("random", DISTANCE, SPEED, STANDSTILL, stream(seed, "route"))
    return simulate(Spec(route, ground=None, station=None), seed)


def run(seed: int, overrides: list[str]) -> End:
    """Simulates one run and estimates it."""
    simulated = drive(seed)
    estimator = gprodom.Odometry(set=overrides)
    odometry = estimator.run(**as_recording(simulated).messages()).odometry
    if not len(odometry["time"]):
        raise Error(f"seed {seed}: no odometry")
    w, x, y, z = odometry["orientation"][-1]
    yaw = math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
    ends = odometry["time"][[0, -1]] // 1000
    dx, dy = odometry["position"][-1, :2] - simulated.position_from(ends[0], ends)[1]
    turned = np.diff(simulated.motion_at(ends).yaw)[0]
    error = (float(dx), float(dy), math.remainder(yaw - turned, 2 * math.pi))
    rows = np.ix_([0, 1, 5], [0, 1, 5])
    covariance = odometry["pose_covariance"][-1].reshape(6, 6)[rows]
    return End(seed, error, covariance.tolist())


def judge(nees: list[float], freedom: int) -> dict[str, Any]:
    """Mean of `nees` and the band it should lie in."""
    from scipy.stats import chi2

    count = len(nees)
    tail = 0.5 * (1 - BAND)
    low, high = chi2.ppf([tail, 1 - tail], count * freedom) / count
    mean = float(np.mean(nees))
    inside = bool(low <= mean <= high)
    return {"mean": mean, "low": float(low), "high": float(high), "inside": inside}


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
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", dest="overrides")
    add_json_flag(parser)
    args = parser.parse_args()
    seeds = range(args.first_seed, args.first_seed + args.runs)
    ends: list[End] = []
    try:
        with (
            ProcessPoolExecutor(args.jobs) as pool,
            Progress("consistency", len(seeds)) as progress,
        ):
            for end in pool.map(partial(run, overrides=args.overrides), seeds):
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
