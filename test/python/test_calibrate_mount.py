"""``gprodom calibrate mount`` on drives made here."""

from __future__ import annotations

import numpy as np
import pytest

from gprodom.calibrate.mount import find_mount
from gprodom.errors import Error


def drive(
    rpy: tuple[float, float, float],
    speed: float = 1.0,
    vibration: float = 0.5,
    pace: float = 0.9,
    late_s: float = 0.0,
    wheel_noise: float = 0.0,
) -> dict[str, dict[str, np.ndarray]]:
    """A minute of starts, stops and bends that never stands, seen by an IMU mounted at `rpy`.

    vibration: m/s^2 a sample. pace: of the speed's changes, rad/s. late_s and wheel_noise (share of
    the speed, a sample) are the wheel's.
    """
    rng = np.random.default_rng(5)
    utime = np.arange(0, 60_000_000, 10_000)
    t = utime * 1e-6
    v = speed * (1.5 + np.sin(pace * t))
    rate = 0.4 * np.sin(0.35 * t)
    force = np.column_stack([pace * speed * np.cos(pace * t), v * rate, np.full(t.size, 9.81)])
    turning = np.column_stack([0 * t, 0 * t, rate])
    c, s = np.cos(rpy), np.sin(rpy)
    roll = np.array([[1, 0, 0], [0, c[0], -s[0]], [0, s[0], c[0]]])
    pitch = np.array([[c[1], 0, s[1]], [0, 1, 0], [-s[1], 0, c[1]]])
    yaw = np.array([[c[2], -s[2], 0], [s[2], c[2], 0], [0, 0, 1]])
    R = yaw @ pitch @ roll  # R_body_imu
    imu = {
        "utime": utime,
        "linear_acceleration": force @ R + vibration * rng.normal(size=force.shape),
        "angular_velocity": turning @ R + 0.02 * rng.normal(size=force.shape),
    }
    rolled = (
        speed * (1.5 + np.sin(pace * (t - late_s))) * (1 + wheel_noise * rng.normal(size=t.size))
    )
    ticks = np.round(np.cumsum(rolled) * 0.01 / 1e-4).astype(np.int64)
    wheel = {"utime": utime, "ticks": ticks, "metres_per_tick": np.full(t.size, 1e-4)}
    return {"imu": imu, "wheel": wheel}


@pytest.mark.parametrize("rpy", [(0.0, 0.0, 0.0), (-0.1, 0.05, -1.5), (1.57, 0.02, -1.57)])
def test_mounting_is_found_without_a_standstill(rpy: tuple[float, float, float]) -> None:
    found = find_mount(drive(rpy))
    assert found.rpy == pytest.approx(rpy, abs=0.03)
    assert found.explained > 0.5
    assert max(found.sigma) < 0.05


@pytest.mark.parametrize("wheel", [{"late_s": 0.5, "pace": 2.5}, {"wheel_noise": 3.0}])
def test_mounting_is_found_though_the_wheel_is_late_or_noisy(wheel: dict[str, float]) -> None:
    found = find_mount(drive((0.1, -0.05, 2.0), speed=0.6, vibration=3.0, **wheel))
    assert found.rpy == pytest.approx((0.1, -0.05, 2.0), abs=0.1)


def test_vibration_alone_gives_no_mounting() -> None:
    with pytest.raises(Error, match="wheel and gyro explain"):
        find_mount(drive((0.0, 0.0, 0.0), speed=0.05, vibration=3.0))


def test_a_robot_that_does_not_drive_gives_no_mounting() -> None:
    with pytest.raises(Error, match="drives for less than"):
        find_mount(drive((0.0, 0.0, 0.0), speed=0.001))
