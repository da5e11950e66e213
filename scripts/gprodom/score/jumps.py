"""Jumps of `map`: how often and how far the published pose was moved by revisit corrections."""

from dataclasses import dataclass

import numpy as np

from gprodom import rotation
from gprodom.lcm import logs
from gprodom.trajectory import Trajectory, interpolate

JUMPED_M = 1e-6  # smaller steps are rounding


@dataclass(frozen=True)
class Jump:
    """A correction at `utime` (us) moved the robot's pose in `map` by `metres`, at the robot."""

    utime: int
    metres: float


@dataclass(frozen=True)
class MapJumps:
    """Corrections that moved the robot's pose in `map`, and how far (metres, at the robot)."""

    count: int
    mean_m: float
    max_m: float


def summarise(jumps: list[Jump], after: int | None = None) -> MapJumps:
    """Number and size of the jumps, or of those after a time (us)."""
    sizes = np.array([jump.metres for jump in jumps if after is None or jump.utime > after])
    if sizes.size == 0:
        return MapJumps(0, 0.0, 0.0)
    return MapJumps(int(sizes.size), float(sizes.mean()), float(sizes.max()))


def find_jumps(corrections: logs.Channel | None, odom: Trajectory) -> list[Jump]:
    """Jumps from a channel of correction_t messages (None: there is none) and the path in `odom`.

    A correction moves the robot from the old map pose of its odom pose to the new one; before the
    first correction `map` is `odom`.
    """
    if corrections is None:
        return []
    order = np.argsort(corrections["utime"], kind="stable")
    times = np.clip(corrections["utime"][order], odom.time[0], odom.time[-1])
    here = interpolate(odom, times).position
    turns = rotation.to_matrix(corrections["orientation"][order])
    after = np.einsum("nij,nj->ni", turns, here) + corrections["position"][order]
    # The correction in force before each: the one before it, at first none.
    turns = np.concatenate([np.eye(3)[None], turns[:-1]])
    shifts = np.concatenate([np.zeros((1, 3)), corrections["position"][order][:-1]])
    before = np.einsum("nij,nj->ni", turns, here) + shifts
    sizes = np.linalg.norm(after - before, axis=1)
    return [
        Jump(int(utime), float(size))
        for utime, size in zip(corrections["utime"][order], sizes, strict=True)
        if size > JUMPED_M
    ]
