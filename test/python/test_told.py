"""What STATUS tells of a sensor that is not as it should be, on drives of a few lines."""

from typing import Any

import numpy as np
import pytest

import gprodom

pytestmark = pytest.mark.usefixtures("compiled")

START = 1_700_000_000_000_000_000  # ns
STANDS_S = 4.0


class Drive:
    """A robot that stands, speeds up evenly, and drives straight on until it stops, if it does. IMU
    at 100 Hz, wheel and radar at 20 Hz."""

    def __init__(
        self, speed: float, acceleration: float, seconds: float, stops_s: float = np.inf
    ) -> None:
        random = np.random.default_rng(2)
        self.t = np.arange(0, seconds, 0.01)
        took = speed / acceleration
        speeds_up = (self.t > STANDS_S) & (self.t < STANDS_S + took)
        brakes = (self.t > stops_s) & (self.t < stops_s + took)
        change = acceleration * (speeds_up.astype(float) - brakes)
        along = np.cumsum(np.cumsum(change) * 0.01) * 0.01
        force = np.outer(change, [1, 0, 0]) + [0, 0, 9.81]
        self.force = force + random.normal(0, 0.02, (len(self.t), 3))
        self.rate = random.normal(0, 0.001, (len(self.t), 3))
        self.wheel_t, self.wheel = self.t[::5], along[::5]
        self.traces = np.empty((0, 201), np.float32)

    def told(self, *settings: str) -> tuple[dict[str, float], list[str]]:
        """Counted events by name, and every reason that was given."""
        outputs = gprodom.Odometry(set=list(settings)).run(**self.messages())
        reasons = {reason for status in outputs.status for reason in status["reasons"]}
        values: dict[str, float] = outputs.status[-1]["values"]
        return {name: values[name] for name in values if ": " in name}, sorted(reasons)

    def messages(self) -> dict[str, Any]:
        """What the sensors send. Without traces the robot has no radar."""
        return {
            "imu_time": START + np.rint(self.t * 1e9).astype(np.int64),
            "acceleration": self.force,
            "angular_velocity": self.rate,
            "wheel_time": START + np.rint(self.wheel_t * 1e9).astype(np.int64),
            "wheel_distance": self.wheel,
            "gpr_time": START + np.rint(self.t[::5] * 1e9).astype(np.int64)[: len(self.traces)],
            "traces": self.traces,
        }


WITHOUT_RADAR = "gpr.enabled=false"
JUMPED = "WHEEL: distance jumped: the encoder was set back, or a count is wrong"
TOO_FAST = "WHEEL: beyond wheel.max_speed: the distance jumped, or the robot is faster than that"


def test_a_fast_robot_is_no_jump_of_its_wheel() -> None:
    drive = Drive(speed=12.0, acceleration=3.0, seconds=12)
    moving = drive.wheel_t > 9.0  # the wheel's driver is started late
    drive.wheel_t, drive.wheel = drive.wheel_t[moving], drive.wheel[moving]
    events, _ = drive.told(WITHOUT_RADAR)
    assert not [name for name in events if "jump" in name or "max_speed" in name]
    events, _ = drive.told(WITHOUT_RADAR, "wheel.max_speed=5")
    assert TOO_FAST in events and JUMPED not in events


def test_an_encoder_set_back_is_told_as_that() -> None:
    drive = Drive(speed=1.0, acceleration=1.0, seconds=12)
    drive.wheel = np.where(drive.wheel_t < 9.0, drive.wheel, drive.wheel - drive.wheel[180])
    events, _ = drive.told(WITHOUT_RADAR)
    assert events[JUMPED] == 1


def test_a_radar_that_repeats_one_trace_is_told_as_stuck() -> None:
    drive = Drive(speed=1.0, acceleration=1.0, seconds=12)
    trace = np.rint(np.random.default_rng(3).normal(0, 500, 201))
    drive.traces = np.tile(trace, (len(drive.wheel_t), 1)).astype(np.float32)
    events, reasons = drive.told()
    driven = drive.t[-1] - STANDS_S - 0.5  # s, at 1 m/s; the first metre cannot tell it
    assert events["GPR_TRACE: values stuck"] == pytest.approx(20 * (driven - 1), abs=10)
    assert "GPR_TRACE: values stuck for a second or more" in reasons
    assert not [reason for reason in reasons if "no data" in reason or "immobilised" in reason]


def test_an_imu_that_hangs_is_told_as_stuck() -> None:
    drive = Drive(speed=1.0, acceleration=1.0, seconds=75)
    hangs = drive.t > 70  # that its values change as a rule is known after a minute
    drive.force[hangs], drive.rate[hangs] = drive.force[7000], drive.rate[7000]
    _, reasons = drive.told(WITHOUT_RADAR)
    assert "IMU: values stuck for a second or more" in reasons


BIAS = "IMU: gyro bias has changed: heading uncertain since the last standstill"
TURNS = (
    "gyro: a steady turn while all other sensors show a standstill: its bias has changed, or the "
    "robot is turned on the spot"
)


@pytest.mark.parametrize("settings", [(), (WITHOUT_RADAR,)])
@pytest.mark.parametrize("step", [0.005, 0.02, 0.04, 0.1])
def test_a_step_of_the_gyro_bias_is_told_at_the_next_standstill(
    step: float, settings: tuple[str, ...]
) -> None:
    drive = Drive(speed=1.0, acceleration=1.0, seconds=18, stops_s=12)
    drive.rate[drive.t > 9, 2] += step
    events, reasons = drive.told(*settings)
    assert events.get(BIAS, 0) == (1 if step < 0.05 else 0)
    assert (TURNS in reasons) is (step > 0.05)
