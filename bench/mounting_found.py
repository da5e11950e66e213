#!/usr/bin/env python3
"""An IMU that is mounted in any way, and imu.rpy_body_imu: auto.

Each SOURCE is a sequence or log with truth, or the folder of bench/robots.py (then with --only).
Its IMU is turned at random (any rotation, by --seed and name), and `imu_wheel` is run with the
mounting that is right and with `auto`. Columns: error of dead reckoning and of both (m, RMS aligned
by se2), (error + 15 mm) of `auto` over that of the right mounting; after how many seconds of data
the yaw was first known, and how far it is off at the end (degrees; in a recording, from what
`gprodom calibrate mount` finds).

    bench/mounting_found.py SOURCE... [--only RECORDING]... [--seed 1] [--set KEY=VALUE]... [--json]
"""

from __future__ import annotations

import zlib
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from statistics import geometric_mean
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from estimates import mount_in, planar_figures, run_method
from gprodom.calibrate.mount import rpy_of
from gprodom.commission.parameter import listed
from gprodom.config import STANDARD
from gprodom.drive.imu_mounting import matrix_of
from gprodom.files import temporary_folder
from gprodom.lcm import logs
from gprodom.odometry.dead_reckoning import wheel_and_gyro
from gprodom.score.consistency import TruthError
from gprodom.score.sources import read_truth
from program import exit_with, in_processes, parser_of, print_figures, table_of
from recordings import recordings_of
from robot_variations import is_folder, names_of, recorded
from robots import UNDECIDED_M
from sensors import read, write

SIGMA = "imu.yaw_sigma_rad"  # in STATUS
KNOWN = 0.5  # rad


def run(case: tuple[Path, str], seed: int, overrides: Sequence[str]) -> dict[str, Any]:
    """The figures of one recording, or of a sequence."""
    source, name = case
    with temporary_folder() as folder:
        recording, log = recorded(source, name, folder)
        # In a sequence the IMU sits as the simulation has it.
        R = matrix_of(mount_in(log).rpy) if is_folder(source) else np.eye(3)
        sensors = read(log)
        label = name if is_folder(source) else name[:10]
        R_old_new = Rotation.random(random_state=seed + zlib.crc32(label.encode())).as_matrix()
        turned = replace(sensors, force=sensors.force @ R_old_new, rate=sensors.rate @ R_old_new)
        log = write(turned, folder / "in.lcmlog")
        right = R @ R_old_new
        settings = [*recording.settings, *overrides]
        row = {"recording": label, **reckoned(log, right, recording.truth)}
        for which, mounting in (("right", listed(list(rpy_of(right)))), ("auto", "auto")):
            output = folder / f"{which}.lcmlog"
            given = [*settings, f"imu.rpy_body_imu={mounting}"]
            made, truth = run_method(log, "imu_wheel", output, given), read_truth(log).trajectory
            figures = planar_figures(made.trajectory, truth, recording.truth)
            row[f"{which}_m"] = figures.ate_rmse_m
        row["over"] = (row["auto_m"] + UNDECIDED_M) / (row["right_m"] + UNDECIDED_M)
        return row | told(output, log, right)


def reckoned(log: Path, right: Any, error: TruthError) -> dict[str, float]:
    """The error of dead reckoning with the right mounting."""
    sensors = logs.read_roles(log, STANDARD.of("imu", "wheel"))
    for name in ("linear_acceleration", "angular_velocity"):
        sensors["imu"][name] = sensors["imu"][name] @ right.T
    truth = read_truth(log).trajectory
    return {"wheel_m": planar_figures(wheel_and_gyro(sensors), truth, error).ate_rmse_m}


def told(output: Path, log: Path, right: Any) -> dict[str, Any]:
    """What STATUS and the last warning say of the mounting."""
    status = logs.read(output, ["STATUS"])["STATUS"]["messages"]
    begin = int(logs.read_roles(log, STANDARD.of("imu"))["imu"]["utime"][0])
    values = [(m.utime, dict(zip(m.names, m.values, strict=True))) for m in status]
    known = [time for time, of in values if of.get(SIGMA, np.inf) < KNOWN]
    last = values[-1][1]
    rpy = tuple(last.get(f"imu.{angle}_rad", np.nan) for angle in ("roll", "pitch", "yaw"))
    off = matrix_of(rpy) @ right.T
    return {
        "known_s": (known[0] - begin) * 1e-6 if known else None,
        "yaw_off_deg": float(np.degrees(np.arctan2(off[1, 0] - off[0, 1], off[0, 0] + off[1, 1]))),
        "yaw_sigma_deg": float(np.degrees(last.get(SIGMA, np.nan))),
    }


def main() -> None:
    """Runs the command line."""
    parser = parser_of(__doc__, jobs=2, overrides=True)
    parser.add_argument("sources", nargs="+", type=Path, metavar="SOURCE")
    parser.add_argument("--only", action="append", metavar="RECORDING", default=[])
    parser.add_argument("--seed", type=int, default=1)
    args = parser.parse_args()
    cases = [(source, name) for source in args.sources for name in names_of(source, args.only)]
    # The truth of others tells the distance alone.
    cases = [
        (source, name)
        for source, name in cases
        if not is_folder(source) or recordings_of(source)[name].points
    ]
    work = partial(run, seed=args.seed, overrides=args.overrides)
    rows = in_processes(args.jobs, "mountings", work, cases)
    mean = geometric_mean(row["over"] for row in rows)
    print_figures(args, rows, f"{table_of(rows)}\ngeometric mean of over: {mean:.2f}")


if __name__ == "__main__":
    exit_with(main)
