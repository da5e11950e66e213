"""A sequence cut into state intervals: what every smoother of bench/smoothers.py is given."""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import gprodom
from gprodom.convert.cmu import Recording
from gprodom.lcm.constants import flag

Array = NDArray[np.float64]

STILL_S = 2.0  # of the standstill at the start: gravity and gyro bias
GRAVITY = 9.80665
GYRO_DENSITY, ACCEL_DENSITY = 1.61e-4, 5.85e-4  # of an MTi-30, at the least

# Standard deviations of the first state, in the order of nav_state.h: rotation (roll, pitch, yaw),
# position, velocity, gyro bias, accelerometer bias, wheel scale (held fixed).
FIRST_SIGMA = np.array(
    [5e-3, 5e-3, 1e-3] + [1e-3] * 3 + [2e-3] * 3 + [2e-4] * 3 + [0.03] * 3 + [1e-7]
)


@dataclass(frozen=True)
class Interval:
    """Between two states. `dt` (n,), s; `force`, `rate` (n, 3), body; `wheel` (n,), m, reported."""

    time: int  # ns, of the state at its end
    dt: Array
    force: Array
    rate: Array
    wheel: Array
    has_wheel: bool


@dataclass(frozen=True)
class Cut:
    """A start and the intervals after it. `orientation`: w, x, y, z of the first state."""

    time: int  # ns, of the first state
    orientation: Array
    gyro_bias: Array
    gyro_density: float  # rad/s/sqrt(Hz)
    accel_density: float
    intervals: list[Interval] = field(default_factory=list)


def cut(recording: Recording, rate: float) -> Cut:
    """States at `rate` (Hz), on stamps of the IMU. The recording begins at a standstill.

    What the daemon says of slipping counts for all smoothers alike.
    """
    time, force, gyro = recording.imu_utime, recording.acceleration, recording.angular_velocity
    still = time <= time[0] + round(1e6 * STILL_S)
    up = force[still].mean(axis=0)
    roll, pitch = np.arctan2(up[1], up[2]), np.arctan2(-up[0], np.hypot(up[1], up[2]))
    root_dt = np.sqrt(np.median(np.diff(time)) * 1e-6)
    start = int(np.flatnonzero(still)[-1])
    times = np.arange(time[start], time[-1], round(1e6 / rate))
    last = np.searchsorted(time, times)  # of each interval, the IMU sample it ends at
    flags = _flags(recording)
    way, intervals = recording.ticks * recording.metres_per_tick, []
    for begin, end in pairwise(last):
        if end <= begin:
            continue
        stamps = time[begin : end + 1]
        rolled = np.interp(stamps, recording.wheel_utime, way)
        first, end_at = np.searchsorted(flags[0], [stamps[0] + 1, stamps[-1]])
        said = flags[1][first : end_at + 1]
        intervals.append(
            Interval(
                int(stamps[-1]) * 1000,
                np.diff(stamps) * 1e-6,
                0.5 * (force[begin:end] + force[begin + 1 : end + 1]),
                0.5 * (gyro[begin:end] + gyro[begin + 1 : end + 1]),
                np.diff(rolled),
                not bool(np.any(said & flag("SLIPPING"))),
            )
        )
    half = 0.5 * np.array([roll, pitch])
    (cr, cp), (sr, sp) = np.cos(half), np.sin(half)
    return Cut(
        int(time[start]) * 1000,
        np.array([cr * cp, sr * cp, cr * sp, -sr * sp]),
        gyro[still].mean(axis=0),
        max(GYRO_DENSITY, float(np.mean(gyro[still].std(axis=0))) * root_dt),
        max(ACCEL_DENSITY, float(np.mean(force[still].std(axis=0))) * root_dt),
        intervals,
    )


def _flags(recording: Recording) -> tuple[NDArray[np.int64], NDArray[np.int32]]:
    """Stamps (us) and odometry_t.flags of the estimator without radar."""
    estimator = gprodom.Odometry(set=["gpr.enabled=false", "graph.enabled=false"])
    told = estimator.run(**recording.messages()).odometry
    return told["time"] // 1000, told["flags"]


def write(path: Path, whole: Cut, scale: float) -> None:
    """As bench/smoother_update.cpp reads it. `scale`: of the wheel, taken off its increments."""

    def numbers(values: Array) -> str:
        return " ".join(f"{value:.12g}" for value in np.ravel(values))

    zero = np.zeros(3)
    first = [whole.orientation, whole.gyro_bias, zero, FIRST_SIGMA]
    with path.open("w", encoding="utf-8") as file:
        file.write(f"initial {whole.time} {' '.join(numbers(part) for part in first)}\n")
        for each in whole.intervals:
            file.write(
                f"interval {each.time} {whole.gyro_density:.9g} {whole.accel_density:.9g} "
                f"{int(each.has_wheel)} {len(each.dt)}\n"
            )
            for row in np.column_stack([each.dt, each.force, each.rate, each.wheel / scale]):
                file.write(numbers(row) + "\n")
