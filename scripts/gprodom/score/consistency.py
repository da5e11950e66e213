"""NEES of an estimate: whether its covariance is right, with the truth's own error included.

The estimate's pose error, as a turn theta and a shift rho of its whole frame (x and y; the error of
a position p is rho + theta J p with J a quarter turn), grows by what the odometry adds, and shrinks
where a place is seen again. So errors at two times are correlated, and how much follows from the
published covariances: the later error has the earlier one in it, less the part that was removed.
With the truth's noise (white) and the error of its clock (one for the run) that gives C, the
covariance of all position errors together. The truth's start pose is not known; it is estimated
from all points by least squares weighted with C, and its covariance enters the errors left over.
"""

from dataclasses import dataclass

import numpy as np

from gprodom import rotation
from gprodom.arrays import Floats
from gprodom.score.align import fit_planar
from gprodom.score.associate import Pairs

MOST_POINTS = 200  # of a run, evenly, are judged: their errors are correlated anyway
QUARTER_TURN = np.array([[0.0, -1.0], [1.0, 0.0]])
LEAST_VARIANCE = 1e-12  # m^2, rad^2; keeps a pose that is known exactly invertible


@dataclass(frozen=True)
class TruthError:
    """The truth's own error: noise of a coordinate (m) and offset of its clock (s), one standard
    deviation each."""

    sigma_m: float = 0.002
    delay_sigma_s: float = 0.0


def nees_xy(pairs: Pairs, truth_error: TruthError) -> float | None:
    """Mean of e^T S^-1 e over the points, e what is left of the error of x and y once the truth is
    placed, S its covariance: 2 if the published covariance is right. None if there is no
    covariance, or one that is not positive.
    """
    if pairs.estimate.covariance is None:
        return None
    planar = pairs.estimate.covariance[:, [[0], [1], [5]], [0, 1, 5]]
    if np.any(np.linalg.det(planar[:, :2, :2]) <= 0):
        return None
    velocity = _velocity(pairs)
    if pairs.estimate.orientation is not None and pairs.truth.orientation is not None:
        error, blocks = _error_from_first_pose(pairs), planar[:, :2, :2].copy()
        blocks += truth_error.sigma_m**2 * np.eye(2)
        blocks += truth_error.delay_sigma_s**2 * velocity[:, :, None] * velocity[:, None, :]
    else:
        placed = _error_from_best_pose(pairs, planar, velocity, truth_error)
        if placed is None:
            return None
        error, blocks = placed
    weighted = np.linalg.solve(blocks, error[..., None])[..., 0]
    return float(np.mean(np.sum(error * weighted, axis=1)))


def _error_from_first_pose(pairs: Pairs) -> Floats:
    """Error (n, 2) with the first poses made equal, where both have attitude."""
    assert pairs.estimate.orientation is not None and pairs.truth.orientation is not None
    turn = rotation.yaw_of(pairs.estimate.orientation[0]) - rotation.yaw_of(
        pairs.truth.orientation[0]
    )
    way = (pairs.truth.position - pairs.truth.position[0]) @ rotation.yaw_matrix(float(turn)).T
    return np.asarray((pairs.estimate.position - pairs.estimate.position[0] - way)[:, :2])


def _error_from_best_pose(
    pairs: Pairs, planar: Floats, velocity: Floats, truth_error: TruthError
) -> tuple[Floats, Floats] | None:
    """Error (m, 2) of at most `MOST_POINTS` points left over with the truth placed by all of them,
    and the covariance (m, 2, 2) of each; None where the truth does not move."""
    picked = np.unique(np.linspace(0, len(pairs.truth) - 1, MOST_POINTS).round().astype(int))
    estimate = pairs.estimate.position[picked, :2]
    moving = velocity[picked].ravel()
    C = position_covariance(estimate, planar[picked])
    C += truth_error.sigma_m**2 * np.eye(len(C))
    C += truth_error.delay_sigma_s**2 * np.outer(moving, moving)
    placed = _placed(estimate, pairs.truth.position[picked, :2], C)
    if placed is None:
        return None
    error, covariance = placed
    points = np.arange(len(picked))
    return error, covariance.reshape(len(picked), 2, len(picked), 2)[points, :, points]


def position_covariance(position: Floats, planar: Floats) -> Floats:
    """Of all position errors together (2n, 2n), m^2, from positions (n, 2) and the covariances
    (n, 3, 3) of x, y, yaw at each."""
    n = len(position)
    lever = np.zeros((n, 2, 3))  # of an error (rho, theta) in the position
    lever[:, :, :2] = np.eye(2)
    lever[:, :, 2] = position @ QUARTER_TURN.T
    to_chart = np.tile(np.eye(3), (n, 1, 1))
    to_chart[:, :2, 2] = -lever[:, :, 2]
    chart = to_chart @ planar @ to_chart.transpose(0, 2, 1) + LEAST_VARIANCE * np.eye(3)
    C = np.zeros((n, 2, n, 2))
    carried = chart[:1]  # covariance of the error now with that at each time so far
    for now in range(n):
        if now > 0:
            kept = _kept(chart[now - 1], chart[now])
            carried = np.concatenate([kept @ carried, chart[now : now + 1]])
        block = lever[now] @ carried @ lever[: now + 1].transpose(0, 2, 1)
        C[now, :, : now + 1] = block.transpose(1, 0, 2)
        C[: now + 1, :, now] = block.transpose(0, 2, 1)
    return np.asarray(C.reshape(2 * n, 2 * n))


def _kept(before: Floats, after: Floats) -> Floats:
    """The part F of an error that is in the next one as well: all of it in directions in which the
    variance grows; where it shrinks by a factor f, as much as an update by a measurement leaves: f.
    """
    root = np.linalg.cholesky(before)
    inverse = np.linalg.inv(root)
    ratio, axes = np.linalg.eigh(inverse @ after @ inverse.T)
    return np.asarray(root @ axes @ np.diag(np.clip(ratio, 0, 1)) @ axes.T @ inverse)


def _placed(estimate: Floats, truth: Floats, C: Floats) -> tuple[Floats, Floats] | None:
    """Error (n, 2) left over with the truth (n, 2) where weighted least squares put it, and the
    covariance (2n, 2n) of that; None where the truth does not move."""
    flat = np.column_stack([truth, np.zeros(len(truth))])
    aim = np.column_stack([estimate, np.zeros(len(estimate))])
    if np.ptp(flat, axis=0).max() < 1e-6:
        return None
    start = fit_planar(flat, aim)
    turn = float(np.arctan2(start.matrix[1, 0], start.matrix[0, 0]))
    shift = start.translation[:2]
    factor = np.linalg.cholesky(C)
    for _ in range(10):
        turned = truth @ rotation.yaw_matrix(turn)[:2, :2].T
        error = estimate - turned - shift
        N = np.zeros((len(truth), 2, 3))
        N[:, :, :2] = np.eye(2)
        N[:, :, 2] = turned @ QUARTER_TURN.T
        white = np.linalg.solve(factor, np.column_stack([error.ravel(), N.reshape(-1, 3)]))
        information = white[:, 1:].T @ white[:, 1:]
        if np.linalg.matrix_rank(information) < 3:
            return None
        step = np.linalg.solve(information, white[:, 1:].T @ white[:, 0])
        shift, turn = shift + step[:2], turn + float(step[2])
        if np.abs(step).max() < 1e-9:
            break
    fitted = N.reshape(-1, 3)
    return error, C - fitted @ np.linalg.solve(information, fitted.T)


def _velocity(pairs: Pairs) -> Floats:
    """Of the estimate (n, 2), m/s, between neighbouring points; 0 where there is but one."""
    if len(pairs.truth) < 2:
        return np.zeros((len(pairs.truth), 2))
    return np.asarray(np.gradient(pairs.estimate.position[:, :2], pairs.truth.seconds(), axis=0))
