"""Unit quaternions (w, x, y, z) and rotation matrices on arrays."""

import numpy as np

from gprodom.arrays import Floats


def to_matrix(q: Floats) -> Floats:
    """Rotation matrices (..., 3, 3) of unit quaternions (..., 4)."""
    w, x, y, z = np.moveaxis(np.asarray(q, dtype=float), -1, 0)
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def from_yaw(yaw: Floats) -> Floats:
    """Quaternions (..., 4) of a rotation by `yaw` (rad) about z."""
    half = 0.5 * np.asarray(yaw, dtype=float)
    zero = np.zeros_like(half)
    return np.stack([np.cos(half), zero, zero, np.sin(half)], axis=-1)


def from_matrix(matrix: Floats) -> Floats:
    """Quaternion (4), w at least 0, of one rotation matrix (3, 3)."""
    from scipy.spatial.transform import Rotation

    x, y, z, w = Rotation.from_matrix(matrix).as_quat()
    return np.array([w, x, y, z]) * (-1 if w < 0 else 1)


def from_rpy(rpy: tuple[float, ...]) -> Floats:
    """(3, 3) rotation Rz(yaw) Ry(pitch) Rx(roll) of roll, pitch, yaw (rad)."""
    (cr, cp, cy), (sr, sp, sy) = np.cos(rpy), np.sin(rpy)
    return np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )


def yaw_matrix(yaw: float) -> Floats:
    """(3, 3) rotation by `yaw` (rad) about z."""
    c, s = np.cos(yaw), np.sin(yaw)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def multiply(a: Floats, b: Floats) -> Floats:
    """Hamilton product a b of quaternions (..., 4)."""
    a, b = np.asarray(a, dtype=float), np.asarray(b, dtype=float)
    aw, bw, av, bv = a[..., :1], b[..., :1], a[..., 1:], b[..., 1:]
    scalar = aw * bw - np.sum(av * bv, axis=-1, keepdims=True)
    return np.concatenate([scalar, aw * bv + bw * av + np.cross(av, bv)], axis=-1)


def conjugate(q: Floats) -> Floats:
    """Inverse of unit quaternions (..., 4)."""
    return np.asarray(np.asarray(q, dtype=float) * np.array([1.0, -1.0, -1.0, -1.0]))


def to_vector(q: Floats) -> Floats:
    """Rotation vectors (n, 3) or (3,), rad, at most pi long, of quaternions (n, 4) or (4,)."""
    from scipy.spatial.transform import Rotation

    return np.asarray(Rotation.from_quat(np.roll(q, -1, axis=-1)).as_rotvec())


def yaw_of(q: Floats) -> Floats:
    """Yaw (rad) of quaternions (..., 4): the heading of the body's x axis."""
    w, x, y, z = np.moveaxis(np.asarray(q, dtype=float), -1, 0)
    return np.asarray(np.arctan2(2 * (x * y + w * z), 1 - 2 * (y * y + z * z)))


def slerp(a: Floats, b: Floats, weight: Floats) -> Floats:
    """Spherical interpolation (n, 4) from `a` (weight 0) to `b` (weight 1), the short way round."""
    dot = np.sum(a * b, axis=-1, keepdims=True)
    b = np.where(dot < 0, -b, b)
    angle = np.arccos(np.clip(np.abs(dot), 0.0, 1.0))
    weight = np.asarray(weight, dtype=float)[..., None]
    small = angle < 1e-6  # here sin(k a) / sin(a) is k to rounding
    sin = np.where(small, 1.0, np.sin(angle))
    wa = np.where(small, 1 - weight, np.sin((1 - weight) * angle) / sin)
    wb = np.where(small, weight, np.sin(weight * angle) / sin)
    q = wa * a + wb * b
    return np.asarray(q / np.linalg.norm(q, axis=-1, keepdims=True))


def added_by_turning(rate: Floats, step_s: float | Floats, arm_m: Floats) -> Floats:
    """Acceleration (n, 3), m/s^2, of the end of an arm over that of its beginning:
    alpha x r + omega x (omega x r), in the axes of `rate` (n, 3), rad/s. step_s: between the rows,
    over which alpha is the central difference; (n,) where they are not even."""
    angular = np.gradient(rate, axis=0) / np.reshape(step_s, (-1, 1))
    return np.asarray(np.cross(angular, arm_m) + np.cross(rate, np.cross(rate, arm_m)))
