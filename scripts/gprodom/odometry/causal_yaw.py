"""Causal gyro yaw: bias and gravity come from the standstills so far.

Time is divided into bins of `BIN_S`. In a bin the robot stands if over `WINDOW_S` up to it the
wheel was no faster than its noise at rest, and the gyro's means were steady (a robot that turns on
the spot has a mean wheel speed of zero, too). The samples of a bin are corrected with values from
earlier bins only.
"""

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
    return CausalYaw().add(imu_time, acceleration, gyro, wheel_time, distance, is_all=True)[1]


class CausalYaw:
    """The same of data that come piece by piece: a bin is told once it is over for IMU and wheel,
    the first `WINDOW_S` at once, as gravity is then taken from all of it."""

    def __init__(self) -> None:
        self._origin: int | None = None
        self._imu: tuple[Ints, Floats, Floats] = (np.zeros(0, np.int64), *np.zeros((2, 0, 3)))
        self._wheel: tuple[Ints, Floats] = (np.zeros(0, np.int64), np.zeros(0))
        self._counts, self._moved = np.zeros(0, np.int64), np.zeros(0)
        self._rates, self._forces = np.zeros((2, 0, 3))
        self._known: Floats | None = None
        self._standing = slice(0, 0)  # bins of the standstill that bias and gravity come from
        self._last: tuple[int, float, float] | None = None  # time, rate and yaw told last

    def add(
        self,
        imu_time: Ints,
        acceleration: Floats,
        gyro: Floats,
        wheel_time: Ints,
        distance: Floats,
        is_all: bool = False,
    ) -> tuple[Ints, Floats]:
        """Times (k,) and yaw (k,) that can be told now. Stamps must go on from those before.

        is_all: nothing more comes, so that all that is left is told.
        """
        new = imu_time, acceleration, gyro
        time, force, rate = (_after(a, b) for a, b in zip(self._imu, new, strict=True))
        self._wheel = (_after(self._wheel[0], wheel_time), _after(self._wheel[1], distance))
        if self._origin is None:
            if not len(time):
                return time, np.zeros(0)
            self._origin = int(time[0])
        bins = ((time - self._origin) * 1e-6 / BIN_S).astype(np.int64)
        begun = len(self._counts)
        over = int(bins[-1]) + 1 if len(bins) and is_all else self._over(bins)
        if over <= begun or (begun == 0 and over < round(WINDOW_S / BIN_S) and not is_all):
            self._imu = time, force, rate
            return np.zeros(0, np.int64), np.zeros(0)
        told = bins < over
        self._imu = time[~told], force[~told], rate[~told]
        bias, up = self._so_far(bins[told] - begun, rate[told], force[told], over - begun)
        return self._integrated(time[told], bins[told] - begun, rate[told], bias, up)

    def _over(self, bins: Ints) -> int:
        """Bins that neither IMU nor wheel adds to any more."""
        if not len(bins) or not len(self._wheel[0]):
            return 0
        assert self._origin is not None
        wheel = int((self._wheel[0][-1] - self._origin) * 1e-6 / BIN_S)
        return min(int(bins[-1]), wheel)

    def _so_far(self, bins: Ints, rate: Floats, force: Floats, new: int) -> tuple[Floats, Floats]:
        """Bias (new, 3) and unit vector upwards (new, 3) as known at the beginning of each of the
        `new` bins that follow those before. In the first bins, where nothing is known, the vector
        comes from their own accelerations.
        """
        assert self._origin is not None
        wide, begun = round(WINDOW_S / BIN_S), len(self._counts)
        edges = self._origin * 1e-6 + BIN_S * np.arange(begun, begun + new + 1)
        moved = np.abs(np.diff(np.interp(edges, self._wheel[0] * 1e-6, self._wheel[1])))
        self._wheel = _from(self._wheel, edges[-1])
        self._moved = np.concatenate([self._moved, moved])
        self._counts = np.concatenate([self._counts, np.bincount(bins, minlength=new)])
        self._rates = np.concatenate([self._rates, _sums(bins, rate, new)])
        self._forces = np.concatenate([self._forces, _sums(bins, force, new)])
        bias, up = np.zeros((new, 3)), np.zeros((new, 3))
        for row in range(new):
            now = begun + row
            window, standing = slice(max(now - wide, 0), now), self._standing
            parts = self._counts[window], self._rates[window], self._moved[window]
            if _stands(*parts, wide, self._known):
                start = standing.start if standing.stop == now - 1 else window.start
                standing = self._standing = slice(start, now)
                self._known = self._rates[standing].sum(axis=0) / self._counts[standing].sum()
            if self._known is not None:
                bias[row] = self._known
            level = standing if self._known is not None else slice(0, max(now, wide))
            gravity = self._forces[level].sum(axis=0)
            up[row] = gravity / np.linalg.norm(gravity)
        return bias, up

    def _integrated(
        self, time: Ints, bins: Ints, gyro: Floats, bias: Floats, up: Floats
    ) -> tuple[Ints, Floats]:
        rate = np.sum((gyro - bias[bins]) * up[bins], axis=1)
        assert self._origin is not None
        before = self._last if self._last is not None else (int(time[0]), float(rate[0]), 0.0)
        rates = np.concatenate([[before[1]], rate])
        seconds = (np.concatenate([[before[0]], time]) - self._origin) * 1e-6
        steps = 0.5 * (rates[1:] + rates[:-1]) * np.diff(seconds)
        yaw = np.cumsum(np.concatenate([[before[2]], steps]))[1:]
        self._last = int(time[-1]), float(rate[-1]), float(yaw[-1])
        return time, yaw


def _after(before: Floats, new: Floats) -> Floats:
    return new if not len(before) else np.concatenate([before, new])


def _from(wheel: tuple[Ints, Floats], second: float) -> tuple[Ints, Floats]:
    """What the distance from that second on follows from."""
    first = max(int(np.searchsorted(wheel[0] * 1e-6, second, side="right")) - 1, 0)
    return wheel[0][first:], wheel[1][first:]


def _sums(bins: Ints, values: Floats, count: int) -> Floats:
    return np.column_stack([np.bincount(bins, column, count) for column in values.T])


def _stands(count: Ints, rates: Floats, moved: Floats, wide: int, known: Floats | None) -> bool:
    usable: Bools = count > 0
    if len(count) < wide or not usable.all() or moved.sum() > REST_MPS * WINDOW_S:
        return False
    means = rates / count[:, None]
    off = means.mean(axis=0) if known is None else means.mean(axis=0) - known
    limit = LARGEST_BIAS if known is None else BIAS_STEP
    return bool(np.linalg.norm(off) < limit and means.std(axis=0).max() < STEADY)
