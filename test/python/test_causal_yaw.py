"""Yaw with the gyro bias of the standstills so far."""

import numpy as np
import pytest

from gprodom.odometry.causal_yaw import CausalYaw, causal_yaw

BIAS = np.array([0.01, -0.02, 0.005])
TIME = np.arange(0, 40_000_000, 10_000)
SECONDS = TIME * 1e-6
SIDE = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])  # R_imu_body


def sensed(turning: np.ndarray, speed: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Acceleration, angular rate and distance of a robot with that rate (rad/s) and wheel speed
    (m/s), its IMU on its side and shaken."""
    shaken = 0.3 * np.sin(2 * np.pi * 25 * SECONDS)[:, None]
    force = np.tile([0.0, 0.0, 9.81], (TIME.size, 1)) @ SIDE.T + shaken
    gyro = turning[:, None] * SIDE[:, 2] + BIAS + 0.03 * shaken
    return force, gyro, np.cumsum(speed) * 0.01


def yaw_of(turning: np.ndarray, speed: np.ndarray, until: int = len(TIME)) -> np.ndarray:
    """Of that robot."""
    force, gyro, distance = sensed(turning, speed)
    whole = slice(0, until)
    return causal_yaw(TIME[whole], force[whole], gyro[whole], TIME[whole], distance[whole])


def test_bias_is_that_of_the_first_standstill_with_a_running_engine() -> None:
    driving = SECONDS > 5
    noise = 0.011 * ~driving  # of a wheel speed without a sign
    yaw = yaw_of(0.2 * driving, 0.5 * driving + noise)
    assert yaw[-1] - yaw[500] == pytest.approx(0.2 * 35, abs=0.01)


def test_bias_is_removed_from_the_first_standstill_on() -> None:
    driving = (SECONDS < 15) | (SECONDS > 20)
    yaw = yaw_of(0.1 * driving, 0.5 * driving)
    assert yaw[1500] == pytest.approx((0.1 + BIAS[1]) * 15, abs=0.02)
    assert yaw[-1] - yaw[2000] == pytest.approx(0.1 * 20, abs=0.01)


def test_turning_on_the_spot_is_no_standstill() -> None:
    yaw = yaw_of(np.where(SECONDS > 5, 0.3, 0.0), np.zeros(TIME.size))
    assert yaw[-1] - yaw[500] == pytest.approx(0.3 * 35, abs=0.01)


def test_later_data_do_not_change_what_was_known() -> None:
    driving = SECONDS < 20
    speed = 0.5 * driving
    assert yaw_of(0.1 * driving, speed, 1000) == pytest.approx(yaw_of(0.1 * driving, speed)[:1000])


@pytest.mark.parametrize("piece", [7, 130, 1000])
def test_piece_by_piece_it_is_the_same(piece: int) -> None:
    driving = (SECONDS < 3) | ((SECONDS > 8) & (SECONDS < 20)) | (SECONDS > 25)
    force, gyro, distance = sensed(0.3 * driving, 0.5 * driving)
    whole = causal_yaw(TIME, force, gyro, TIME[::5], distance[::5])
    told = CausalYaw()
    parts, late = [], 3  # pieces by which the wheel comes later
    for first in range(0, TIME.size + late * piece, piece):
        imu = slice(first, first + piece)
        behind = max(first - late * piece, 0)
        wheel = slice(-(-behind // 5) * 5, max(first - (late - 1) * piece, 0), 5)
        parts.append(told.add(TIME[imu], force[imu], gyro[imu], TIME[wheel], distance[wheel]))
    no_imu, no_wheel = np.zeros((0, 3)), np.zeros(0)
    none = np.zeros(0, np.int64)
    parts.append(told.add(none, no_imu, no_imu, none, no_wheel, is_all=True))
    time, yaw = (np.concatenate(each) for each in zip(*parts, strict=True))
    np.testing.assert_array_equal(time, TIME)
    np.testing.assert_allclose(yaw, whole, atol=1e-12)
