"""Dead reckoning: closed forms, and the reference figures of the recorded sequences."""

from pathlib import Path

import numpy as np
import pytest

from gprodom.convert.cmu import _find_gravity, _parse_imu, _parse_wheel, parse_truth
from gprodom.convert.source import IMU, TRUTH, WHEEL, read_files
from gprodom.odometry.causal_yaw import CausalYaw, causal_yaw
from gprodom.odometry.dead_reckoning import integrate, standstill, yaw_from_gyro
from gprodom.score.associate import associate
from gprodom.score.figures import compare
from gprodom.trajectory import Trajectory

REFERENCE = {
    "1700001000-0-gates_g": 0.761,
    "1700002000-0-gates_g": 0.366,
    "1700003000-0-gates_g": 0.559,
    "1700004000-0-nsh_b": 0.337,
    "1700005000-0-nsh_b": 0.241,
    "1700006000-0-nsh_b": 0.858,
    "1700007000-0-nsh_h": 0.239,
    "1700008000-0-nsh_h": 0.385,
    "1700009000-0-nsh_h": 0.298,
    "1700010000-0-beach": 0.215,
    "1700011000-0-beach": 0.205,
    "1700012000-0-beach": 0.170,
}


@pytest.mark.parametrize("name", REFERENCE)
def test_reference_figures(shared: Path, name: str) -> None:
    files = read_files(shared / "cmu_like" / f"{name}-cmu-gpr.zip")
    imu, wheel = _parse_imu(files[IMU]), _parse_wheel(files[WHEEL[0]])
    truth = parse_truth(files[TRUTH])
    acceleration, rate, _ = _find_gravity(imu.values, IMU)
    distance = wheel.values[:, 0]
    yaw = yaw_from_gyro(imu.utime, acceleration, rate, standstill(wheel.utime, distance))
    estimate = integrate(wheel.utime, distance, imu.utime, yaw)
    score = compare(associate(estimate, Trajectory(truth.utime, truth.values)), "se2", 3.0)
    assert score.figures.ate_rmse_m == pytest.approx(REFERENCE[name], abs=0.01)


def test_a_circle_driven_with_a_tilted_imu_and_a_biased_gyro() -> None:
    """4 s of standstill, then once round at 0.5 m/s and 0.5 rad/s; the IMU lies on its side."""
    bias = np.array([0.01, -0.02, 0.005])
    time = np.arange(0, round(1e6 * (4 + 4 * np.pi)), 5_000)
    moving = time > 4_000_000
    side = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])  # R_imu_body
    rate = np.where(moving[:, None], [0.0, 0.0, 0.5], 0.0) @ side.T + bias
    acceleration = np.tile([0.0, 0.0, 9.81], (time.size, 1)) @ side.T
    distance = 0.5 * np.maximum(time * 1e-6 - 4, 0)
    yaw = yaw_from_gyro(time, acceleration, rate, standstill(time, distance))
    path = integrate(time, distance, time, yaw)
    assert yaw[-1] == pytest.approx(2 * np.pi, abs=0.01)
    assert path.position[-1] == pytest.approx([0, 0, 0], abs=0.01)
    assert path.position[:, 1].max() == pytest.approx(2.0, abs=0.01)  # turned left, radius 1 m


def test_standstill_on_the_way() -> None:
    """Moving from the start, then still from 4 to 10 s: that, less a second at either end."""
    time = np.arange(0, 20_000_000, 20_000)
    seconds = time * 1e-6
    distance = np.where(seconds < 4, seconds, np.where(seconds < 10, 4.0, seconds - 6))
    start, end = standstill(time, distance)
    assert (start * 1e-6, end * 1e-6) == pytest.approx((5.0, 9.0), abs=0.03)
    nowhere = standstill(time, seconds)
    assert nowhere[0] == nowhere[1]
    assert standstill(time, np.maximum(seconds - 3, 0))[1] == pytest.approx(3e6, abs=3e4)


# Yaw with the gyro bias of the standstills so far.


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
