"""Associates the estimate with the truth by time."""

from dataclasses import dataclass

import numpy as np

from gprodom.arrays import Bools
from gprodom.console import warn
from gprodom.errors import Error
from gprodom.trajectory import Times, Trajectory, interpolate, path_length

MIN_PAIRS = 10
MAX_GAP_S = 1.0
UNCOVERED_M = 1.0  # of the truth's way: a stretch that the relative error would count


@dataclass(frozen=True)
class Pairs:
    """Estimate and truth at the same n stamps (the truth's).

    `excluded`: truth points left out; for how long, and how far the truth travels meanwhile.
    """

    estimate: Trajectory
    truth: Trajectory
    excluded: int
    excluded_s: float = 0.0
    excluded_m: float = 0.0


def covered(trajectory: Trajectory, time: Times, max_gap_s: float = MAX_GAP_S) -> Bools:
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
    left_out = ~(used[:-1] & used[1:])  # of the steps from point to point
    seconds = float(np.sum(np.diff(truth.time)[left_out])) * 1e-6
    metres = float(np.sum(np.diff(path_length(truth.position))[left_out]))
    return Pairs(interpolate(estimate, paired.time), paired, len(truth) - count, seconds, metres)


def warn_of_uncovered(pairs: Pairs) -> None:
    """Warns if the estimate does not cover a metre of the truth or more: the rest is scored."""
    if pairs.excluded_m < UNCOVERED_M:
        return
    warn(
        f"the estimate does not cover {pairs.excluded_m:.1f} m of the truth's way "
        f"({pairs.excluded} of {pairs.excluded + len(pairs.truth)} points, "
        f"{pairs.excluded_s:.1f} s): the figures are of the rest"
    )


def _span(trajectory: Trajectory) -> str:
    return f"{trajectory.time[0] * 1e-6:.3f}-{trajectory.time[-1] * 1e-6:.3f} s"
