"""``gprodom calibrate mount`` on drives made here."""

from pathlib import Path

import numpy as np
import pytest

from conftest import Cli
from gprodom.calibrate.mount import find_mount
from gprodom.errors import Error
from gprodom.simulate.imu import rotation_from_rpy


def drive(
    rpy: tuple[float, float, float],
    speed: float = 1.0,
    vibration: float = 0.5,
    pace: float = 0.9,
    late_s: float = 0.0,
    wheel_noise: float = 0.0,
    arm: tuple[float, float, float] = (0.0, 0.0, 0.0),
    bend: float = 0.0,
) -> dict[str, dict[str, np.ndarray]]:
    """A minute of starts, stops and bends that never stands, seen by an IMU mounted at `rpy`.

    vibration: m/s^2 a sample. pace: of the speed's changes, rad/s. late_s and wheel_noise (share of
    the speed, a sample) are the wheel's. arm: the IMU's place in body, m. bend: mean
    yaw rate, rad/s.
    """
    rng = np.random.default_rng(5)
    utime = np.arange(0, 60_000_000, 10_000)
    t = utime * 1e-6
    v = speed * (1.5 + np.sin(pace * t))
    rate, faster = bend + 0.4 * np.sin(0.35 * t), 0.14 * np.cos(0.35 * t)
    force = np.column_stack([pace * speed * np.cos(pace * t), v * rate, np.full(t.size, 9.81)])
    force[:, 0] -= rate**2 * arm[0] + faster * arm[1]
    force[:, 1] += faster * arm[0] - rate**2 * arm[1]
    turning = np.column_stack([0 * t, 0 * t, rate])
    R = rotation_from_rpy(rpy)  # R_body_imu
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


def test_a_bias_of_the_accelerometer_is_within_the_sigma_of_roll_and_pitch() -> None:
    """All parts of the drive have it alike, so their spread does not show it."""
    log = drive((0.0, 0.0, 0.0))
    log["imu"]["linear_acceleration"] += [0.03, -0.03, 0.0]
    found = find_mount(log)
    for angle, sigma in zip(found.rpy[:2], found.sigma[:2], strict=True):
        assert 0.002 < abs(angle) < 1.5 * sigma


@pytest.mark.parametrize(
    ("speed", "vibration", "said"),
    [(0.05, 3.0, "wheel and gyro explain"), (0.001, 0.5, "drives for less than")],
)
def test_without_a_drive_there_is_no_mounting(speed: float, vibration: float, said: str) -> None:
    with pytest.raises(Error, match=said):
        find_mount(drive((0.0, 0.0, 0.0), speed, vibration))


@pytest.mark.parametrize("arm", [(0.5, 0.0, 0.0), (-0.3, 0.4, 0.2)])
def test_what_turns_add_beside_the_origin_is_taken_out(arm: tuple[float, float, float]) -> None:
    rpy = (-0.1, 0.05, -1.5)
    log = drive(rpy, speed=0.3, arm=arm, bend=0.6)
    assert find_mount(log, arm).rpy == pytest.approx(rpy, abs=0.03)
    assert find_mount(log).rpy != pytest.approx(rpy, abs=0.2)


@pytest.mark.parametrize("seed", [1, 2])
def test_command_with_an_imu_beside_the_origin(seed: int, tmp_path: Path, cli: Cli) -> None:
    """A loop, whose bends all go to one side: without the IMU's place its yaw looks turned."""
    log = tmp_path / "loop.lcmlog"
    simulated = ["simulate", "--seed", str(seed), "--route", "loop", "--ground", "none"]
    cli(*simulated, "--slips", "0", "--imu=0.5,0,0", "-o", log)
    words = ["calibrate", "mount", log]
    assert cli.json(*words)["rpy"][2] < -0.2
    found = cli.json(*words, "--set", "imu.lever_arm=[0.5, 0, 0]")
    assert abs(found["rpy"][2]) < 3 * found["sigma"][2]
    assert found["sigma"][2] < 0.03
    assert np.abs(found["rpy"][:2]).max() < 0.01  # a bias of the accelerometer
