#!/usr/bin/env python3
"""Errors of turn and tilt after a gap of the IMU that was bridged by constant values.

For gaps of several lengths T, at any time of each LOG.lcmlog: the turn that the gyro shows over T
less that of the mean of the gap's two ends held (root mean square and 99th percentile, rad, about
z), the speed likewise (m/s, of the worst axis), and the change of the direction of gravity, which
the accelerometer's mean over 2 s shows (RMS per axis, rad). By these docs/estimation.md says what
may be claimed lost.

    bench/imu_gaps.py LOG.lcmlog...
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from gprodom.arrays import Floats
from gprodom.errors import Error
from gprodom.lcm import logs
from program import exit_with, parser_of, print_rows

LENGTHS = (0.2, 0.3, 0.5, 1.0, 2.0, 5.0, 10.0)  # s
GRAVITY_MEAN = 2.0  # s


def error_of_held(t: Floats, values: Floats, samples: int) -> Floats:
    """The integral of `values` (n, 3) over so many samples, less that of its ends held."""
    steps = np.diff(t)[:, None]
    integral = np.concatenate([np.zeros((1, 3)), np.cumsum(values[:-1] * steps, axis=0)])
    begin = np.arange(0, len(t) - samples, max(1, samples // 4))
    end = begin + samples
    held = 0.5 * (values[begin] + values[end]) * (t[end] - t[begin])[:, None]
    return np.asarray(integral[end] - integral[begin] - held)


def tilt(acceleration: Floats, mean: int, samples: int) -> float:
    """RMS per axis of the change of gravity's direction, rad."""
    kernel = np.ones(mean) / mean
    down = np.stack([np.convolve(axis, kernel, "valid") for axis in acceleration.T], axis=1)
    down /= np.linalg.norm(down, axis=1)[:, None]
    angle = np.linalg.norm(np.cross(down[:-samples], down[samples:]), axis=1)
    return float(np.sqrt(np.mean(angle**2) / 2))


def measure(paths: list[Path], length: float) -> dict[str, Any]:
    """The figures of one length, RMS over the logs; of the percentile the largest."""
    turn, percentile, speed, tilts = [], [], [], []
    for path in paths:
        imu = logs.read(path, ["IMU"]).get("IMU")
        if imu is None:
            raise Error(f"{path}: no IMU")
        t = imu["utime"] * 1e-6
        rate = 1 / float(np.median(np.diff(t)))
        samples = round(length * rate)
        if len(t) < samples + 2 * GRAVITY_MEAN * rate:
            continue
        turned = error_of_held(t, imu["angular_velocity"], samples)
        turn.append(float(np.mean(turned[:, 2] ** 2)))
        percentile.append(float(np.quantile(np.abs(turned[:, 2]), 0.99)))
        accelerated = error_of_held(t, imu["linear_acceleration"], samples)
        speed.append(float(np.max(np.mean(accelerated**2, axis=0))))
        tilts.append(tilt(imu["linear_acceleration"], round(GRAVITY_MEAN * rate), samples) ** 2)
    if not turn:
        raise Error(f"no log is longer than {length} s")
    return {
        "length_s": length,
        "yaw_rms": float(np.sqrt(np.mean(turn))),
        "yaw_99": max(percentile),
        "speed_rms": float(np.sqrt(np.mean(speed))),
        "tilt_rms": float(np.sqrt(np.mean(tilts))),
    }


def main() -> None:
    """Runs the command line."""
    parser = parser_of(__doc__)
    parser.add_argument("logs", nargs="+", type=Path, metavar="LOG.lcmlog")
    args = parser.parse_args()
    rows = [measure(args.logs, length) for length in LENGTHS]
    heading = ["gap (s)", "yaw, RMS (rad)", "99 %", "speed, RMS (m/s)", "tilt, RMS (rad)"]
    print_rows(args, rows, heading)


if __name__ == "__main__":
    exit_with(main)
