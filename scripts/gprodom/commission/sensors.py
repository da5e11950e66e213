"""The sensors' data with what is already known put right: clocks, the wheel's scale."""

import itertools

import numpy as np

from gprodom.arrays import Floats
from gprodom.doctor.finding import Log
from gprodom.odometry.dead_reckoning import gyro_yaw_of, standstill, stays, wheel_distance

STRAIGHT_RAD = 0.1  # of heading to either side: the chord is then 0.2 % shorter at most
REST_S = 1.0  # between two moves


def copied(log: Log) -> Log:
    """A log whose channels can be changed without changing those of `log`."""
    return {role: dict(content) for role, content in log.items()}


def shift(log: Log, role: str, seconds: float) -> None:
    """Adds to the stamps of a role, in place."""
    log[role]["utime"] = log[role]["utime"] + round(seconds * 1e6)


def rescale(log: Log, scale: float) -> None:
    """Divides the wheel's distances by reported over true distance, in place."""
    role = "wheels" if "wheels" in log else "wheel"
    log[role]["metres_per_tick"] = np.asarray(log[role]["metres_per_tick"]) / scale


def heading_at_wheel(log: Log) -> Floats:
    """Yaw (n,), rad, of the gyro at the wheel's stamps."""
    time, distance = wheel_distance(log)
    imu_time, yaw = gyro_yaw_of(log, standstill(time, distance))
    return np.asarray(np.interp(time, imu_time, yaw))


def moves(log: Log, still_m: float) -> list[tuple[int, int]]:
    """Rows of the wheel's messages in the middle of a rest and of the next; a rest is `REST_S` or
    more in which the wheel turns by less than `still_m`."""
    time, distance = wheel_distance(log)
    rests = [
        (first + last) // 2
        for first, last in stays(distance, still_m)
        if time[last] - time[first] >= REST_S * 1e6
    ]
    return list(itertools.pairwise(rests))
