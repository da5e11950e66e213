"""Causal gyro yaw: bias and gravity come from the standstills so far.

Time is divided into bins of `BIN_S`. In a bin the robot stands if over `WINDOW_S` up to it the
wheel was no faster than its noise at rest, and the gyro's means were steady (a robot that turns on
the spot has a mean wheel speed of zero, too). The samples of a bin are corrected with values from
earlier bins only.
"""

from __future__ import annotations

import numpy as np

from gprodom.arrays import Bools, Floats, Ints

BIN_S = 0.25
WINDOW_S = 1.0
REST_MPS = 0.02  # speed at rest of a wheel without a sign, whose noise is rectified
LARGEST_BIAS = 0.05  # rad/s, of a gyro of which nothing is known
BIAS_STEP = 0.02  # rad/s, of a bias against the one known
STEADY = 0.01  # rad/s, of the means of the bins in a window: deviation


def causal_yaw(
    imu_time: Ints, acceleration: Floats, gyro: Floats, wheel_time: Ints, distance: Floats
) -> Floats:
    """Yaw (n,), rad, 0 at the first sample: angular rate about gravity, less its bias so far.

    imu_time (n,), wheel_time (m,) microseconds; acceleration (n, 3) m/s^2 and gyro (n, 3) rad/s in
    the IMU's axes, at whatever rotation it is mounted; distance (m,) signed, cumulative, m. Before
    the first standstill the bias counts as zero and gravity is the mean acceleration so far.
    """
    seconds = (imu_time - imu_time[0]) * 1e-6
    bins = (seconds / BIN_S).astype(np.int64)
    count = np.bincount(bins)
    rates, forces = (_sums(bins, values) for values in (gyro, acceleration))
    edges = imu_time[0] * 1e-6 + BIN_S * np.arange(len(count) + 1)
    moved = np.abs(np.diff(np.interp(edges, wheel_time * 1e-6, distance)))
    bias, up = _so_far(count, rates, forces, moved)
    rate = np.sum((gyro - bias[bins]) * up[bins], axis=1)
    steps = 0.5 * (rate[1:] + rate[:-1]) * np.diff(seconds)
    return np.concatenate([[0.0], np.cumsum(steps)])


def _sums(bins: Ints, values: Floats) -> Floats:
    return np.column_stack([np.bincount(bins, column) for column in values.T])


def _so_far(count: Ints, rates: Floats, forces: Floats, moved: Floats) -> tuple[Floats, Floats]:
    """Bias (k, 3) and unit vector upwards (k, 3) as known at the beginning of each of k bins. In
    the first bins, where nothing is known, the vector comes from their own accelerations.
    """
    wide = round(WINDOW_S / BIN_S)
    bias, up = np.zeros((len(count), 3)), np.zeros((len(count), 3))
    known: Floats | None = None
    standing = slice(0, 0)  # bins of the standstill that bias and gravity come from
    for now in range(len(count)):
        window = slice(max(now - wide, 0), now)
        if _stands(count[window], rates[window], moved[window], wide, known):
            standing = slice(standing.start if standing.stop == now - 1 else window.start, now)
            known = rates[standing].sum(axis=0) / count[standing].sum()
        if known is not None:
            bias[now] = known
        level = standing if known is not None else slice(0, max(now, wide))
        force = forces[level].sum(axis=0)
        up[now] = force / np.linalg.norm(force)
    return bias, up


def _stands(count: Ints, rates: Floats, moved: Floats, wide: int, known: Floats | None) -> bool:
    usable: Bools = count > 0
    if len(count) < wide or not usable.all() or moved.sum() > REST_MPS * WINDOW_S:
        return False
    means = rates / count[:, None]
    off = means.mean(axis=0) if known is None else means.mean(axis=0) - known
    limit = LARGEST_BIAS if known is None else BIAS_STEP
    return bool(np.linalg.norm(off) < limit and means.std(axis=0).max() < STEADY)
