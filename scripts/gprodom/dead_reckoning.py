"""Plain dead reckoning: distance along the track and gyro yaw less its bias, nothing else."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gprodom import logs, rotation
from gprodom.errors import Error
from gprodom.trajectory import Times, Trajectory

Array = NDArray[np.float64]

MOVED_M = 1e-3  # the wheel has turned this far: the first standstill is over
MIN_STANDSTILL_S = 0.5


def yaw_from_gyro(imu_time: Times, acceleration: Array, gyro: Array, standstill_end: int) -> Array:
    """Yaw (n,), rad, 0 at the first sample: angular rate about gravity, less its bias.

    imu_time (n,) microseconds; acceleration (n, 3) m/s^2 and gyro (n, 3) rad/s in the IMU's axes,
    at whatever rotation it is mounted. Gravity and bias are means up to `standstill_end`
    (microseconds); a floor level enough that gravity stays put in the robot is taken for granted.
    """
    still = imu_time <= standstill_end
    seconds = (imu_time - imu_time[0]) * 1e-6
    if not still.any() or seconds[still][-1] < MIN_STANDSTILL_S:
        raise Error(
            f"the robot does not stand for {MIN_STANDSTILL_S:g} s at the start: "
            "no gyro bias, so no dead reckoning"
        )
    up = acceleration[still].mean(axis=0)
    up /= np.linalg.norm(up)
    rate = (gyro - gyro[still].mean(axis=0)) @ up
    steps = 0.5 * (rate[1:] + rate[:-1]) * np.diff(seconds)
    return np.concatenate([[0.0], np.cumsum(steps)])


def first_motion(wheel_time: Times, distance: Array) -> int:
    """Time (microseconds) of the last wheel reading before the wheel has moved `MOVED_M`."""
    moving = np.abs(distance - distance[0]) > MOVED_M
    return int(
        wheel_time[-1] if not moving.any() else wheel_time[max(int(np.argmax(moving)) - 1, 0)]
    )


def integrate(time: Times, distance: Array, yaw_time: Times, yaw: Array) -> Trajectory:
    """Trajectory at `time` (m,) from signed cumulative distance (m,) and yaw (n,) at `yaw_time`.

    Each step goes along the yaw at its middle. Starts at the origin with the yaw of time[0] as 0.
    """
    origin = time[0]
    stamps, clock = (time - origin) * 1e-6, (yaw_time - origin) * 1e-6
    heading = np.interp(stamps, clock, yaw)
    middle = np.interp(0.5 * (stamps[1:] + stamps[:-1]), clock, yaw) - heading[0]
    step = np.diff(distance)
    position = np.zeros((time.size, 3))
    position[1:, 0] = np.cumsum(step * np.cos(middle))
    position[1:, 1] = np.cumsum(step * np.sin(middle))
    return Trajectory(time, position, rotation.from_yaw(heading - heading[0]))


def wheel_distance(log: dict[str, logs.Channel]) -> tuple[Times, Array]:
    """Times (n,) and signed cumulative wheel distance (n,), metres, of a log's WHEEL channel."""
    wheel = _channel(log, "WHEEL")
    return wheel["utime"], np.asarray(wheel["ticks"] * wheel["metres_per_tick"], dtype=float)


def gyro_yaw(log: dict[str, logs.Channel]) -> tuple[Times, Array]:
    """Times (n,) and yaw (n,), rad, of a log's IMU channel (`yaw_from_gyro`)."""
    imu = _channel(log, "IMU")
    time = imu["utime"]
    standstill_end = first_motion(*wheel_distance(log))
    acceleration, rate = imu["linear_acceleration"], imu["angular_velocity"]
    return time, yaw_from_gyro(time, acceleration, rate, standstill_end)


def wheel_and_gyro(log: dict[str, logs.Channel]) -> Trajectory:
    """The method `wheel`: wheel distance with gyro yaw, at the wheel's stamps."""
    return integrate(*wheel_distance(log), *gyro_yaw(log))


def _channel(log: dict[str, logs.Channel], name: str) -> logs.Channel:
    if name not in log:
        raise Error(f"the log holds no {name} messages, which dead reckoning needs")
    return log[name]
