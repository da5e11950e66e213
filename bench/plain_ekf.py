"""A plain EKF on IMU and wheel, as robots run it: after robot_localization's in two dimensions.

State x, y, yaw, forward speed, yaw rate, forward acceleration. The wheel gives the speed with no
motion sideways, the IMU yaw rate and forward acceleration, both as they are measured (less the
bias of the first standstill where asked): no biases, no scale, no standstill, no slip.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gprodom.convert.cmu import Recording

Array = NDArray[np.float64]

RATE = 30.0  # Hz, of the filter
# Process noise a second, of x, y, yaw, speed, yaw rate, acceleration, as robot_localization's.
PROCESS = np.diag([0.05, 0.05, 0.06, 0.025, 0.02, 0.01])
SPEED_SIGMA, RATE_SIGMA, ACCELERATION_SIGMA = 0.02, 0.01, 0.2


def run(recording: Recording, scale: float, less_bias: bool) -> tuple[NDArray[np.int64], Array]:
    """Stamps (us) and positions (n, 3), m. `scale`: of the wheel, reported over true."""
    time = recording.imu_utime
    gyro, force = recording.angular_velocity[:, 2], recording.acceleration[:, 0]
    if less_bias:
        still = time < time[0] + 2_000_000
        gyro, force = gyro - gyro[still].mean(), force - force[still].mean()
    stamps = np.arange(time[0], min(time[-1], recording.wheel_utime[-1]), round(1e6 / RATE))
    way = np.interp(
        stamps, recording.wheel_utime, recording.ticks * recording.metres_per_tick / scale
    )
    x, P = np.zeros(6), np.diag([1e-9] * 6)
    places = [np.zeros(3)]
    ends = np.searchsorted(time, stamps, side="right")
    for k in range(1, len(stamps)):
        dt = (stamps[k] - stamps[k - 1]) * 1e-6
        x, F = _predict(x, dt)
        P = F @ P @ F.T + PROCESS * dt
        heard = slice(ends[k - 1], ends[k])
        measured = [(3, (way[k] - way[k - 1]) / dt, SPEED_SIGMA)]
        measured += [(4, float(value), RATE_SIGMA) for value in gyro[heard]]
        measured += [(5, float(value), ACCELERATION_SIGMA) for value in force[heard]]
        for row, value, sigma in measured:
            gain = P[:, row] / (P[row, row] + sigma**2)
            x = x + gain * (value - x[row])
            P = P - np.outer(gain, P[row])
        places.append(np.array([x[0], x[1], 0.0]))
    return stamps, np.array(places)


def _predict(x: Array, dt: float) -> tuple[Array, Array]:
    """The state dt (s) later, and the derivative of that."""
    heading = x[2] + 0.5 * x[4] * dt
    way = x[3] * dt + 0.5 * x[5] * dt**2
    cos, sin = np.cos(heading), np.sin(heading)
    F = np.eye(6)
    for row, along, across in ((0, cos, -sin), (1, sin, cos)):
        F[row, 2] = across * way
        F[row, 3] = along * dt
        F[row, 4] = across * way * 0.5 * dt
        F[row, 5] = along * 0.5 * dt**2
    F[2, 4] = F[3, 5] = dt
    return np.array(
        [x[0] + cos * way, x[1] + sin * way, x[2] + x[4] * dt, x[3] + x[5] * dt, x[4], x[5]]
    ), F
