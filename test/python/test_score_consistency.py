"""The NEES of a score: 2 for errors drawn from the covariance, more if it is too small."""

from concurrent.futures import ProcessPoolExecutor
from functools import partial

import numpy as np
import pytest

from gprodom.benchmark.monte_carlo import end_of_drive, judge
from gprodom.score.associate import Pairs
from gprodom.score.consistency import TruthError, nees_xy, position_covariance
from gprodom.trajectory import Trajectory

N = 150
STEP = np.array([0.02, 0.004, 0.004])  # of one step: along, aside (m), yaw (rad)


def drive(rng: np.random.Generator, claimed: float = 1.0) -> Pairs:
    """A drive whose odometry errs by `STEP`, with covariances of `claimed` times that; the truth is
    in a frame of its own, with 5 cm of noise and a clock 0.1 s (one sigma) off."""
    poses = np.zeros((2, N, 3))  # truth, estimate
    P = np.zeros((N, 3, 3))
    for k in range(1, N):
        step = np.array([0.2, 0.0, 0.05 * np.sin(0.1 * k)])
        for pose, error in ((poses[0], np.zeros(3)), (poses[1], rng.normal(size=3) * STEP)):
            d, (c, s) = step + error, (np.cos(pose[k - 1, 2]), np.sin(pose[k - 1, 2]))
            pose[k] = pose[k - 1] + [c * d[0] - s * d[1], s * d[0] + c * d[1], d[2]]
        F = np.eye(3)
        moved = poses[1, k, :2] - poses[1, k - 1, :2]
        F[:2, 2] = [-moved[1], moved[0]]
        G = np.eye(3)
        G[:2, :2] = [[c, -s], [s, c]]
        P[k] = F @ P[k - 1] @ F.T + G @ np.diag((claimed * STEP) ** 2) @ G.T
    time = 1_700_000_000_000_000 + 200_000 * np.arange(N)
    covariance = np.tile(1e-8 * np.eye(6), (N, 1, 1))
    covariance[:, [[0], [1], [5]], [0, 1, 5]] += P
    late = 0.1 * rng.normal() * np.gradient(poses[0, :, :2], 0.2, axis=0)
    seen = poses[0, :, :2] + late + 0.05 * rng.normal(size=(N, 2))
    c, s = np.cos(2.0), np.sin(2.0)
    turned = seen @ np.array([[c, s], [-s, c]]) + [10.0, -4.0]
    flat = np.zeros((N, 1))
    estimate = Trajectory(time, np.hstack([poses[1, :, :2], flat]), None, covariance)
    return Pairs(estimate, Trajectory(time, np.hstack([turned, flat])), 0)


def mean_nees(claimed: float, error: TruthError, runs: int = 30) -> float:
    rng = np.random.default_rng(3)
    found = [nees_xy(drive(rng, claimed), error) for _ in range(runs)]
    return float(np.mean([value for value in found if value is not None]))


def test_nees_is_two_for_correct_covariances() -> None:
    # Errors within a run are correlated: some ten independent points of 2 degrees of freedom each.
    assert mean_nees(1.0, TruthError(0.05, 0.1)) == pytest.approx(2, abs=0.4)


def test_nees_is_larger_for_a_covariance_that_is_too_small() -> None:
    assert mean_nees(0.2, TruthError(0.05, 0.1), 10) > 6
    assert mean_nees(1.0, TruthError(0.002, 0.0), 10) > 6


def test_correlation_follows_from_the_covariances() -> None:
    """Two shifts that add up, then one measured away: the first error is in the second, not in the
    third."""
    planar = np.array([np.diag([v, v, 1e-9]) for v in (1.0, 4.0, 0.01)])
    along = position_covariance(np.zeros((3, 2)), planar)[::2, ::2]
    assert np.diag(along) == pytest.approx([1.0, 4.0, 0.01], rel=1e-6)
    assert along[1, 0] == pytest.approx(1.0, rel=1e-6)
    assert along[2, 0] == pytest.approx(0.01 / 4, rel=1e-3)


def test_a_truth_without_motion_gives_no_nees() -> None:
    pairs = drive(np.random.default_rng(1))
    still = Trajectory(pairs.truth.time, np.zeros((N, 3)))
    assert nees_xy(Pairs(pairs.estimate, still, 0), TruthError()) is None


# The estimator's covariance over 40 simulated drives; bench/consistency.py runs more.
#
# The wheels of these drives never slip for long, and the configuration says so: otherwise the
# variance for slip would be far larger than their error.


@pytest.mark.usefixtures("compiled")
def test_covariance_is_true() -> None:
    with ProcessPoolExecutor(2) as pool:
        ends = list(pool.map(partial(end_of_drive, overrides=["wheel.slip_share=0"]), range(40)))
    for nees, freedom in (([end.nees_xy for end in ends], 2), ([end.nees_yaw for end in ends], 1)):
        judged = judge(nees, freedom)
        assert judged["inside"], {**judged, "errors": [end.error for end in ends]}
