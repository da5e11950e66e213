"""Sequential radar displacements of a log as arrays, and dead reckoning on them."""

from dataclasses import dataclass

import numpy as np

from gprodom.arrays import Floats, sums
from gprodom.errors import Error
from gprodom.lcm import logs
from gprodom.lcm.constants import kind
from gprodom.odometry.dead_reckoning import gyro_yaw, integrate, wheel_distance
from gprodom.trajectory import Times, Trajectory


@dataclass(frozen=True)
class Displacements:
    """Valid sequential displacements in time order: times (n,) in microseconds, metres (n,)."""

    start: Times
    end: Times
    distance: Floats

    def __len__(self) -> int:
        return int(self.start.size)


def sequential(log: logs.Log, source: str) -> Displacements:
    """The valid sequential displacements of `source` (a front end's name)."""
    if "displacement" not in log:
        raise Error("the replay published no displacements: is the radar in use?")
    content = log["displacement"]
    wanted = (
        (content["kind"] == kind("SEQUENTIAL"))
        & content["valid"]
        & (content["source"] == source)
        & (content["utime_to"] > content["utime_from"])
    )
    if not wanted.any():
        found = ", ".join(sorted(set(content["source"].tolist())))
        raise Error(f"no valid displacement of {source!r} was published (sources: {found})")
    order = np.argsort(content["utime_to"][wanted], kind="stable")
    return Displacements(
        content["utime_from"][wanted][order],
        content["utime_to"][wanted][order],
        content["distance"][wanted][order],
    )


def reckon(log: logs.Log, displacements: Displacements) -> Trajectory:
    """Dead reckoning on radar distance: its size from the radar, its sign from the wheel, gyro yaw.

    Windows may overlap, so each displacement counts as a mean speed at the middle of its window;
    between windows, and over invalid ones, the speed is interpolated. The robot stands while the
    wheel does.
    """
    time, wheel = wheel_distance(log)
    span = (displacements.end - displacements.start) * 1e-6
    middle = 0.5e-6 * (displacements.start - time[0] + displacements.end - time[0])
    order = np.argsort(middle, kind="stable")
    seconds = (time - time[0]) * 1e-6
    speed = np.interp(seconds, middle[order], (np.abs(displacements.distance) / span)[order])
    sign = np.sign(np.diff(wheel))
    step = sign * 0.5 * (speed[1:] + speed[:-1]) * np.diff(seconds)
    return integrate(time, sums(step), *gyro_yaw(log))
