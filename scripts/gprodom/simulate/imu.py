"""An IMU at the track point: exact kinematics, then biases that walk and white noise.

Defaults equal those of ``imu`` in the estimator's configuration.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gprodom.arrays import Floats
from gprodom.simulate.drive import Motion


@dataclass(frozen=True)
class ImuSpec:
    """Biases at the start are drawn from their sigmas; densities are per axis."""

    rate: float = 200.0  # Hz
    rpy_body_imu: tuple[float, float, float] = (
        0.0,
        0.0,
        0.0,
    )  # rad; roll, pitch, yaw of R_body_imu
    gyro_noise_density: float = 2.3e-4  # rad/s/sqrt(Hz)
    accel_noise_density: float = 8.3e-4  # m/s^2/sqrt(Hz)
    gyro_bias_walk: float = 1.0e-5  # rad/s^2/sqrt(Hz)
    accel_bias_walk: float = 1.0e-4  # m/s^3/sqrt(Hz)
    gyro_bias_sigma: float = 2.0e-3  # rad/s
    accel_bias_sigma: float = 0.03  # m/s^2
    gravity: float = 9.80665  # m/s^2


@dataclass(frozen=True)
class ImuData:
    """What the IMU says, in its own frame, and the biases in it: each (n, 3)."""

    acceleration: Floats  # m/s^2, specific force
    angular_velocity: Floats  # rad/s
    accel_bias: Floats
    gyro_bias: Floats
    orientation: Floats  # (n, 4) w x y z: the yaw that the gyro integrates to, drift included


def rotation_from_rpy(rpy: tuple[float, float, float]) -> Floats:
    """Rz(yaw) Ry(pitch) Rx(roll)."""
    (cr, cp, cy), (sr, sp, sy) = np.cos(rpy), np.sin(rpy)
    return np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )


def measure(motion: Motion, spec: ImuSpec, random: np.random.RandomState) -> ImuData:
    """IMU samples of `motion`, whose times are 1 / `spec.rate` apart."""
    n, step = len(motion.s), 1.0 / spec.rate
    body_imu = rotation_from_rpy(spec.rpy_body_imu)
    force = np.column_stack([motion.acceleration, np.full(n, spec.gravity)]) @ body_imu
    rate = np.column_stack([np.zeros((n, 2)), motion.yaw_rate]) @ body_imu

    def bias(sigma: float, walk: float) -> Floats:
        steps = random.standard_normal((n, 3)) * (walk * np.sqrt(step))
        steps[0] = random.standard_normal(3) * sigma
        return np.asarray(np.cumsum(steps, axis=0))

    def white(density: float) -> Floats:
        return np.asarray(random.standard_normal((n, 3)) * (density / np.sqrt(step)))

    gyro_bias = bias(spec.gyro_bias_sigma, spec.gyro_bias_walk)
    accel_bias = bias(spec.accel_bias_sigma, spec.accel_bias_walk)
    measured_rate = rate + gyro_bias + white(spec.gyro_noise_density)
    measured_force = force + accel_bias + white(spec.accel_noise_density)
    turn = np.concatenate([[0.0], np.cumsum((measured_rate @ body_imu.T)[:-1, 2])]) * step
    return ImuData(
        acceleration=measured_force,
        angular_velocity=measured_rate,
        accel_bias=accel_bias,
        gyro_bias=gyro_bias,
        orientation=_orientation(float(motion.yaw[0]) + turn, spec.rpy_body_imu),
    )


def _orientation(yaw: Floats, rpy: tuple[float, float, float]) -> Floats:
    """Quaternions (n, 4) of Rz(yaw) R_body_imu."""
    (cr, cp, cy), (sr, sp, sy) = np.cos(np.divide(rpy, 2)), np.sin(np.divide(rpy, 2))
    w, x = cr * cp * cy + sr * sp * sy, sr * cp * cy - cr * sp * sy
    y, z = cr * sp * cy + sr * cp * sy, cr * cp * sy - sr * sp * cy
    cos, sin = np.cos(yaw / 2), np.sin(yaw / 2)
    return np.stack(
        [cos * w - sin * z, cos * x - sin * y, cos * y + sin * x, cos * z + sin * w], axis=1
    )
