"""The sensors and the truth of a recording, read from a log and written to one."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from gprodom.arrays import Bools, Floats, Ints
from gprodom.config import STANDARD, TRUTH_CHANNEL
from gprodom.lcm import logs
from gprodom.lcm.log_writer import Stream, write_log
from gprodom.lcm.wire import encode
from gprodom.score.sources import read_truth

FINEST_M = 1e-6  # of a wheel's count, if nothing makes it coarse


@dataclass(frozen=True)
class Sensors:
    """Times in us. force m/s^2, rate rad/s (n, 3); wheels: distances (m, 1 or 2), m; quantum_m: of
    a wheel's count; truth (k, 3), m."""

    imu_time: Ints
    force: Floats
    rate: Floats
    wheel_time: Ints
    wheels: Floats
    truth_time: Ints
    truth: Floats
    quantum_m: float = FINEST_M

    @property
    def seconds(self) -> Floats:
        """Of the IMU's samples, from the first."""
        return np.asarray((self.imu_time - self.imu_time[0]) * 1e-6)

    def imu_at(self, which: Ints | Bools | slice) -> Sensors:
        """With these of the IMU's samples alone."""
        imu = {"imu_time": self.imu_time, "force": self.force, "rate": self.rate}
        return replace(self, **{name: values[which] for name, values in imu.items()})

    def wheel_at(self, which: Ints | Bools | slice) -> Sensors:
        """With these of the wheels' samples alone."""
        return replace(self, wheel_time=self.wheel_time[which], wheels=self.wheels[which])


def read(log: Path) -> Sensors:
    """Of a log."""
    found = logs.read_roles(log, STANDARD.of("imu", "wheel", "wheels"))
    imu, wheel = found["imu"], found.get("wheels", found.get("wheel"))
    assert wheel is not None
    ticks = [wheel[name] for name in ("left_ticks", "right_ticks", "ticks") if name in wheel]
    truth = read_truth(log).trajectory
    return Sensors(
        imu["utime"],
        imu["linear_acceleration"],
        imu["angular_velocity"],
        wheel["utime"],
        np.column_stack(ticks) * wheel["metres_per_tick"][:, None],
        truth.time,
        truth.position,
    )


def write(sensors: Sensors, log: Path) -> Path:
    """As a log."""
    ticks = np.floor(sensors.wheels / sensors.quantum_m + 0.5).astype(np.int64)
    names = ("left_ticks", "right_ticks") if ticks.shape[1] == 2 else ("ticks",)
    counts = dict(zip(names, ticks.T, strict=True)) | {"metres_per_tick": sensors.quantum_m}
    imu = {
        "linear_acceleration": sensors.force,
        "angular_velocity": sensors.rate,
        "has_orientation": False,
        "orientation": np.tile([1.0, 0.0, 0.0, 0.0], (len(sensors.force), 1)),
    }
    wheel = (STANDARD.wheels, "wheels_t") if len(names) == 2 else (STANDARD.wheel, "wheel_t")
    channels = [
        (STANDARD.imu, "imu_t", sensors.imu_time, imu),
        (*wheel, sensors.wheel_time, counts),
        (TRUTH_CHANNEL, "position_truth_t", sensors.truth_time, {"position": sensors.truth}),
    ]
    streams = [
        Stream(channel, time, encode(kind, {"utime": time, **fields}, len(time)))
        for channel, kind, time, fields in channels
    ]
    write_log(log, streams)
    return log


def rate_hz(time: Ints) -> float:
    """Samples per second."""
    return float(1e6 / np.median(np.diff(time)))
