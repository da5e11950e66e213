"""How sure a path is: standard deviations, and what holds the position with 95 %."""

import numpy as np

from gprodom.arrays import Floats
from gprodom.trajectory import Trajectory

SIGMAS_95 = 2.4477  # radius that holds 95 % of a normal distribution in the plane, in sigma
SIGMAS_95_OF_ONE = 1.96  # the same of one figure


def position_sigma(path: Trajectory) -> Floats:
    """Standard deviation (n,) of the position in the plane, m: the root of both variances' sum."""
    assert path.covariance is not None
    return np.asarray(np.sqrt(np.maximum(path.covariance[:, [0, 1], [0, 1]].sum(axis=1), 0)))


def yaw_sigma(path: Trajectory) -> Floats:
    """Standard deviation (n,) of the heading, rad."""
    assert path.covariance is not None
    return np.asarray(np.sqrt(np.maximum(path.covariance[:, 5, 5], 0)))


def radius_95(path: Trajectory) -> Floats:
    """(n,), m: the larger half axis of the ellipse that holds the position with 95 %."""
    assert path.covariance is not None
    largest = np.linalg.eigvalsh(path.covariance[:, :2, :2])[:, 1]
    return np.asarray(SIGMAS_95 * np.sqrt(np.maximum(largest, 0)))


def half_axes(path: Trajectory) -> Floats:
    """(n, 2, 2): the half axes of the ellipse that holds the position with 95 %, m, as columns."""
    assert path.covariance is not None
    values, vectors = np.linalg.eigh(path.covariance[:, :2, :2])
    return np.asarray(vectors * (SIGMAS_95 * np.sqrt(np.maximum(values, 0)))[:, None, :])


def ellipses(path: Trajectory, corners: int = 60) -> Floats:
    """(n, corners, 2): round each position the closed line of that ellipse, m."""
    angle = np.linspace(0, 2 * np.pi, corners)
    circle = np.stack([np.cos(angle), np.sin(angle)])
    return np.asarray(path.position[:, None, :2] + np.swapaxes(half_axes(path) @ circle, 1, 2))
