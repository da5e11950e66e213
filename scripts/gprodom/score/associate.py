"""Which estimate belongs to which truth."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gprodom.errors import Error
from gprodom.trajectory import Times, Trajectory, interpolate

MIN_PAIRS = 10
MAX_GAP_S = 1.0


@dataclass(frozen=True)
class Pairs:
    """Estimate and truth at the same n stamps (the truth's). `excluded`: truth points left out."""

    estimate: Trajectory
    truth: Trajectory
    excluded: int


def covered(trajectory: Trajectory, time: Times, max_gap_s: float = MAX_GAP_S) -> NDArray[np.bool_]:
    """Mask (m,) of the stamps that lie inside the trajectory and in no gap over `max_gap_s`."""
    inside = (time >= trajectory.time[0]) & (time <= trajectory.time[-1])
    right = np.clip(np.searchsorted(trajectory.time, time), 0, len(trajectory) - 1)
    left = np.maximum(right - 1, 0)
    gap = trajectory.time[right] - trajectory.time[left]
    exact = trajectory.time[right] == time
    return np.asarray(inside & (exact | (gap <= round(max_gap_s * 1e6))))


def associate(estimate: Trajectory, truth: Trajectory, max_gap_s: float = MAX_GAP_S) -> Pairs:
    """The estimate interpolated to every stamp of the truth.

    Truth points before the first or after the last estimate are left out, and those that fall
    between two estimates more than `max_gap_s` apart, so that nothing is extrapolated or invented.
    """
    if len(estimate) == 0 or len(truth) == 0:
        raise Error("nothing to score: the estimate or the truth holds no poses")
    used = covered(estimate, truth.time, max_gap_s)
    if truth.time[-1] < estimate.time[0] or truth.time[0] > estimate.time[-1]:
        raise Error(
            "estimate and truth do not overlap in time: estimate "
            f"{_span(estimate)}, truth {_span(truth)}; are they of the same sequence?"
        )
    count = int(used.sum())
    if count < MIN_PAIRS:
        raise Error(
            f"too few points to score: {count} truth points lie where the estimate has no gap over "
            f"{max_gap_s:g} s (of {len(truth)}); at least {MIN_PAIRS} are needed"
        )
    paired = truth.select(used)
    return Pairs(interpolate(estimate, paired.time), paired, len(truth) - count)


def _span(trajectory: Trajectory) -> str:
    return f"{trajectory.time[0] * 1e-6:.3f}-{trajectory.time[-1] * 1e-6:.3f} s"
