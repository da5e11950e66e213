#!/usr/bin/env python3
"""Recordings of real robots, as a new user would take them: is the estimator as good as dead
reckoning, does its covariance hold, how soon does it start?

DIR holds the recordings of the shared data (recordings.py has the table of them, with the error of
each truth) or some of them; any others have a description file beside them, of the form that is
told there. The Warthog is run with the mean of its wheels, and with left and right (skid steer).
Each is converted, its IMU's mounting is found (gprodom calibrate mount), and `wheel` and
`imu_wheel` are run. Errors are of the truth's points from the start of imu_wheel on, for both the
same: those at which both tell a pose, so none in a gap of either. They are aligned by se2.
`wheel_all_m`: of `wheel` over all points. `over`: (error + 15 mm) over that of `wheel`, which a few
millimetres do not decide.

    bench/robots.py DIR [--only NAME]... [--set KEY=VALUE]... [--json]
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from statistics import fmean, geometric_mean
from typing import Any

import numpy as np

from estimates import mount_in, mounting_setting, planar_figures, run_method
from gprodom.calibrate.mount import Mount
from gprodom.config import STANDARD
from gprodom.errors import Error
from gprodom.files import temporary_folder
from gprodom.lcm import logs
from gprodom.odometry.dead_reckoning import wheel_and_gyro
from gprodom.score.associate import covered
from gprodom.score.figures import Figures
from gprodom.score.sources import read_truth
from gprodom.trajectory import Trajectory, path_length
from program import exit_with, parser_of, print_figures, table_of
from recordings import Recording, chosen, convert

JUMP = "odom.largest_jump_m"  # in STATUS
UNDECIDED_M = 0.015  # that neither truth nor mounting of a small robot is better known than


def run(recording: Recording, data: Path, overrides: Sequence[str]) -> dict[str, Any]:
    """The figures of one recording."""
    with temporary_folder() as folder:
        log = folder / "in.lcmlog"
        convert(recording, data, log)
        return measure(recording, log, mount_in(log), overrides)


def measure(
    recording: Recording, log: Path, mount: Mount, overrides: Sequence[str], smooth: bool = True
) -> dict[str, Any]:
    """The figures of its log; what is run is written beside that."""
    output = log.with_suffix(".out.lcmlog")
    sensors = logs.read_roles(log, STANDARD.of("imu", "wheel"))
    settings = [mounting_setting(mount), *recording.settings]
    found = run_method(log, "imu_wheel", output, [*settings, *overrides], smooth)
    truth = read_truth(log).trajectory
    wheel = wheel_and_gyro(sensors)
    told = logs.read_roles(output, STANDARD.of("odometry", "status"))
    odometry, status = told["odometry"], told["status"]["messages"]
    start = int(found.trajectory.time[0])
    data_start = min(int(channel["utime"][0]) for channel in sensors.values())
    after = [message for message in status if message.utime > start]
    jumps = [dict(zip(m.names, m.values, strict=True)).get(JUMP, 0.0) for m in after]
    figures: dict[str, Any] = {
        "settings": settings,
        "start_s": (start - data_start) * 1e-6,
        "scale": float(odometry["wheel_scale"][-1]),
        "scale_sigma": float(odometry["wheel_scale_sigma"][-1]),
        "jump_m": max(jumps, default=0.0),
        "reasons": sorted({reason for message in after for reason in message.reasons}),
    }
    if not recording.points:
        return figures | distances(wheel, odometry, truth)
    told_by_both = covered(found.trajectory, truth.time) & covered(wheel, truth.time)
    rest = truth.select((truth.time >= start) & told_by_both)
    causal = planar_figures(found.trajectory, rest, recording.truth)
    smoothed = planar_figures(found.smoothed, rest, recording.truth) if found.smoothed else None
    reckoned = planar_figures(wheel, rest, recording.truth)
    return figures | {
        "wheel_m": reckoned.ate_rmse_m,
        "wheel_all_m": planar_figures(wheel, truth, recording.truth).ate_rmse_m,
        "causal_m": causal.ate_rmse_m,
        "smoothed_m": smoothed.ate_rmse_m if smoothed else None,
        "ratio": causal.ate_rmse_m / reckoned.ate_rmse_m,
        "over": over(causal, reckoned),
        "smoothed_over": over(smoothed, reckoned) if smoothed else None,
        "nees_xy": causal.nees_xy,
        "n": causal.n,
    }


def over(estimate: Figures, reckoned: Figures) -> float:
    """Of the errors, each with `UNDECIDED_M` more."""
    return (estimate.ate_rmse_m + UNDECIDED_M) / (reckoned.ate_rmse_m + UNDECIDED_M)


def distances(wheel: Trajectory, odometry: logs.Channel, truth: Trajectory) -> dict[str, Any]:
    """How far truth, wheel and estimate come while all three are there. Of the estimate it is the
    distance that it publishes: the length of its path has the jumps of odom as well, which are
    metres where a robot that started on the move learns its gyro's bias."""
    published = odometry["utime"]
    first = max(int(time[0]) for time in (wheel.time, published, truth.time))
    last = min(int(time[-1]) for time in (wheel.time, published, truth.time))

    def length(path: Trajectory) -> float:
        inside = path.select((path.time >= first) & (path.time <= last))
        return float(path_length(inside.position[:, :2], 0.5)[-1])

    return {
        "distance_m": length(truth),
        "wheel_distance_m": length(wheel),
        "causal_distance_m": float(
            np.ptp(np.interp([first, last], published, odometry["distance"]))
        ),
    }


def table(results: dict[str, dict[str, Any]]) -> str:
    """For people."""
    scored = [r for r in results.values() if "ratio" in r]
    rows = [
        {"recording": name}
        | {k: v for k, v in r.items() if k not in ("settings", "reasons", "error")}
        for name, r in results.items()
    ]
    text = table_of(rows)
    if scored:
        ratio = fmean(r["ratio"] for r in scored)
        mean = geometric_mean(r["over"] for r in scored)
        text += f"\nmean ratio {ratio:.3f}, geometric mean of over {mean:.3f}"
    for name, r in results.items():
        text += f"\n{name}: {r.get('error') or ' '.join(r['settings'])}"
    return text


def main() -> None:
    """Runs the command line."""
    parser = parser_of(__doc__, overrides=True)
    parser.add_argument("data", type=Path, metavar="DIR")
    parser.add_argument("--only", action="append", metavar="NAME", default=[])
    args = parser.parse_args()
    results: dict[str, dict[str, Any]] = {}
    for name, recording in chosen(args.data, args.only).items():
        try:
            results[name] = run(recording, args.data, args.overrides)
        except Error as error:  # one that does not start is a row, too
            results[name] = {"error": str(error)}
    print_figures(args, results, table(results))


if __name__ == "__main__":
    exit_with(main)
