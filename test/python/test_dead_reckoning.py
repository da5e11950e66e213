"""Dead reckoning: closed forms, and the reference figures of the recorded sequences."""

from pathlib import Path

import numpy as np
import pytest

from gprodom.convert.cmu import _find_gravity, _parse_imu, _parse_wheel, parse_truth
from gprodom.convert.source import IMU, TRUTH, WHEEL, read_files
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
