#!/usr/bin/env python3
"""Recordings of real robots, as a new user would take them: is the estimator as good as dead
reckoning, does its covariance hold, how soon does it start?

DIR holds wid02/, wid09/, warthog_a/, car/ (tables), husky.bag and xsens_skid/test1.bag, or some of
them. The Warthog is run with the mean of its wheels, and with left and right (skid steer). Each is
converted, its IMU's mounting is found (gprodom calibrate mount), and `wheel` and `imu_wheel` are
run. Errors are of the truth's points from the start of imu_wheel on, for both the same, aligned by
se2; in brackets that of `wheel` over all points. With --from, each recording also begins so many
seconds later, as a rule while the robot drives.

    bench/robots.py DIR [--only NAME]... [--from SECONDS]... [--set KEY=VALUE]... [--json]
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections.abc import Sequence
from contextlib import redirect_stdout
from dataclasses import dataclass, replace
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np

from gprodom.calibrate.mount import Mount, find_mount
from gprodom.cli import main as gprodom
from gprodom.config import STANDARD
from gprodom.console import add_json_flag, format_table, print_json
from gprodom.errors import Error
from gprodom.lcm import logs
from gprodom.odometry.dead_reckoning import wheel_and_gyro
from gprodom.odometry.estimate import estimate
from gprodom.odometry.methods import find_method
from gprodom.score.associate import associate
from gprodom.score.consistency import TruthError
from gprodom.score.figures import Figures, compare
from gprodom.score.sources import read_truth
from gprodom.trajectory import Trajectory, path_length
from mid_drive import cut_log

TABLES = ("accelerometer", "gyroscope", "wheel-speed", "position")
JUMP = "odom.largest_jump_m"  # in STATUS


@dataclass(frozen=True)
class Recording:
    """path: in DIR; of tables the folder. options: of gprodom convert; of tables the file names.
    sides: options that say which wheels are left and right. settings: what a user measures with a
    tape. points: whether the truth tells positions, and not only how far the robot came."""

    path: str
    options: tuple[str, ...]
    truth: TruthError
    settings: tuple[str, ...] = ()
    points: bool = True
    sides: tuple[str, ...] = ()


def tables(folder: str, wheel: str, truth: TruthError, points: bool = True) -> Recording:
    """Of one file each."""
    files = ("accelerometer.csv", "gyroscope.csv", wheel, "position.csv")
    return Recording(folder, files, truth, points=points)


RTK = TruthError(0.03, 0.03)
LIDAR = TruthError(0.03, 0.1)
WARTHOG = tables("warthog_a", "wheels.csv", LIDAR)
SKID_STEER = ("wheel.drive=skid_steer", "wheel.track=1.08")
RECORDINGS = {
    "wid02": tables("wid02", "wheel.csv", RTK),
    "wid09": tables("wid09", "wheel.csv", RTK),
    "warthog_a": WARTHOG,
    "warthog_a (pair)": replace(WARTHOG, settings=SKID_STEER, sides=("--left=1", "--right=2")),
    "husky": Recording(
        "husky.bag",
        ("--imu=/imu/data", "--wheel=/husky_velocity_controller/odom", "--truth=/fix"),
        TruthError(1.0, 0.0),
    ),
    "car": tables("car", "wheel_speed.csv", RTK, points=False),
    "xsens_skid": Recording(
        "xsens_skid/test1.bag",
        ("--imu=/xsens/imu_data", "--wheel=/wheel_odometry", "--truth=/stereo_odometer/odometry"),
        TruthError(5.0, 0.0),
        points=False,
    ),
}


def convert(recording: Recording, data: Path, log: Path) -> None:
    """To an LCM log, by the command a user would give."""
    path = data / recording.path
    if path.is_dir():
        named = zip(TABLES, recording.options, strict=True)
        given = ["tables", *(f"--{name}={path / file}" for name, file in named), *recording.sides]
    else:
        given = ["bag", str(path), *recording.options]
    with redirect_stdout(StringIO()):  # its table
        code = gprodom(["convert", *given, "-o", str(log)])
    if code != 0:
        raise Error(f"{path}: could not be converted")


def run(
    recording: Recording, data: Path, overrides: Sequence[str], from_s: float = 0.0
) -> dict[str, Any]:
    """The figures of one recording, without its first seconds."""
    with tempfile.TemporaryDirectory(prefix="gprodom-") as name:
        log = Path(name) / "in.lcmlog"
        convert(recording, data, log)
        sensors = logs.read_roles(log, STANDARD.of("imu", "wheel"))
        mount = find_mount(sensors)
        if from_s > 0:
            begin = int(sensors["imu"]["utime"][0]) + round(from_s * 1e6)
            log = cut_log(log, begin, Path(name) / "rest.lcmlog")
        return measure(recording, log, mount, overrides)


def measure(
    recording: Recording, log: Path, mount: Mount, overrides: Sequence[str], smooth: bool = True
) -> dict[str, Any]:
    """The figures of its log; what is run is written beside that."""
    output = log.with_suffix(".out.lcmlog")
    sensors = logs.read_roles(log, STANDARD.of("imu", "wheel"))
    angles = ", ".join(f"{angle:.4f}" for angle in mount.rpy)
    settings = [f"imu.rpy_body_imu=[{angles}]", *recording.settings]
    found = estimate(
        log, find_method("imu_wheel"), (), [*settings, *overrides], output, smooth=smooth
    )
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
        return figures | distances(wheel, found.trajectory, truth)
    rest = truth.select(truth.time >= start)
    causal = score(found.trajectory, rest, recording.truth)
    smoothed = score(found.smoothed, rest, recording.truth) if found.smoothed else None
    reckoned = score(wheel, rest, recording.truth)
    return figures | {
        "wheel_m": reckoned.ate_rmse_m,
        "wheel_all_m": score(wheel, truth, recording.truth).ate_rmse_m,
        "causal_m": causal.ate_rmse_m,
        "smoothed_m": smoothed.ate_rmse_m if smoothed else None,
        "ratio": causal.ate_rmse_m / reckoned.ate_rmse_m,
        "nees_xy": causal.nees_xy,
        "n": causal.n,
    }


def score(trajectory: Trajectory, truth: Trajectory, error: TruthError) -> Figures:
    """Aligned by se2."""
    return compare(associate(trajectory, truth), "se2", 3.0, error).figures


def distances(wheel: Trajectory, found: Trajectory, truth: Trajectory) -> dict[str, Any]:
    """How far truth, wheel and estimate come while all three are there."""
    first = max(int(each.time[0]) for each in (wheel, found, truth))
    last = min(int(each.time[-1]) for each in (wheel, found, truth))

    def length(path: Trajectory) -> float:
        inside = path.select((path.time >= first) & (path.time <= last))
        return float(path_length(inside.position[:, :2], 0.5)[-1])

    return {
        "distance_m": length(truth),
        "wheel_distance_m": length(wheel),
        "causal_distance_m": length(found),
    }


def table(results: dict[str, dict[str, Any]]) -> str:
    """For people."""
    rows: list[list[object]] = []
    for name, r in results.items():
        if "error" in r:
            rows.append([name, "none", *[""] * 6])
            continue
        scale = f"{r['scale']:.4f} +- {r['scale_sigma']:.4f}"
        if "ratio" in r:
            wheel = f"{r['wheel_m']:.3f} ({r['wheel_all_m']:.3f})"
            rows.append(
                [
                    name,
                    wheel,
                    r["causal_m"],
                    r["smoothed_m"],
                    r["ratio"],
                    r["nees_xy"],
                    r["start_s"],
                    scale,
                ]
            )
        else:
            wheel = f"{r['wheel_distance_m']:.1f} of {r['distance_m']:.1f}"
            rows.append([name, wheel, r["causal_distance_m"], "", "", "", r["start_s"], scale])
    ratios = [r["ratio"] for r in results.values() if "ratio" in r]
    header = ["recording", "wheel (m)", "imu_wheel", "smoothed", "ratio", "nees", "start (s)"]
    text = format_table([*header, "scale"], rows)
    if ratios:
        text += f"\nmean ratio {np.mean(ratios):.3f}"
    for name, r in results.items():
        text += f"\n{name}: {r.get('error') or ' '.join(r['settings'])}"
    return text


def main() -> int:
    """Runs the command line."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("data", type=Path, metavar="DIR")
    parser.add_argument("--only", action="append", choices=RECORDINGS, default=[])
    parser.add_argument(
        "--from", type=float, action="append", default=[], metavar="SECONDS", dest="begins"
    )
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", dest="overrides")
    add_json_flag(parser)
    args = parser.parse_args()
    results: dict[str, dict[str, Any]] = {}
    for name in args.only or RECORDINGS:
        recording = RECORDINGS[name]
        if not (args.data / recording.path).exists():
            continue
        for from_s in (0.0, *args.begins):
            row = f"{name} from {from_s:g} s" if from_s > 0 else name
            try:
                results[row] = run(recording, args.data, args.overrides, from_s)
            except Error as error:  # one that does not start is a row, too
                results[row] = {"error": str(error)}
    if args.json:
        print_json(results)
    else:
        print(table(results))
    return 0 if results else 1


if __name__ == "__main__":
    sys.exit(main())
