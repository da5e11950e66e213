"""The estimator on recorded sequences: against the batch solution, and bounds on its errors.

The figures of all sequences stand in docs/results.md; here a few sequences guard them.
"""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gprodom
from conftest import SAMPLE, Cli
from gprodom.benchmark.motion import measure
from gprodom.convert.cmu import Recording, read_recording
from gprodom.ground.survey import Survey, write_survey

pytestmark = pytest.mark.usefixtures("compiled")

SEQUENCES = ["1700005000-0-nsh_b-cmu-gpr.zip", "1700003000-0-gates_g-cmu-gpr.zip"]

# Every row quadratic and no revisits, which only the solution over all data takes in.
QUADRATIC = ["wheel.robust_threshold=0", "graph.enabled=false"]


def estimate(recording: Recording, until: int, overrides: list[str]) -> Any:
    """An Odometry that has seen the recording up to a time (us), and its outputs."""
    odometry = gprodom.Odometry(set=overrides)
    odometry.record()
    return odometry, odometry.run(**recording.messages(until=until))


@pytest.fixture(scope="module", params=SEQUENCES)
def recording(shared: Path, request: pytest.FixtureRequest) -> Recording:
    return read_recording(shared / "cmu_like" / str(request.param))


def test_marginalising_costs_less_than_a_centimetre(recording: Recording) -> None:
    # What differs is then only where the marginalised factors were linearised.
    start, end = recording.imu_utime[[0, -1]]
    for until in np.linspace(start, end, 11)[1:].astype(np.int64):
        odometry, _ = estimate(recording, int(until), QUADRATIC)
        lagged, batch = odometry.recorded(), odometry.smoothed()
        assert lagged["time"][-1] == batch["time"][-1]
        difference = np.linalg.norm(lagged["position"][-1] - batch["position"][-1])
        assert difference < 0.01, f"{(until - start) / 1e6:.0f} s"


def test_steps_are_accepted_and_output_is_sound(recording: Recording) -> None:
    _, outputs = estimate(recording, int(recording.imu_utime[-1]), [])
    values = outputs.status[-1]["values"]
    assert values["solver.steps_accepted"] >= 0.999 * values["solver.steps"]
    odometry = outputs.odometry
    assert np.all(np.diff(odometry["time"]) > 0)
    assert all(np.all(np.isfinite(array)) for array in odometry.values())
    # From the standstill at the start to the last IMU sample, at the IMU's rate.
    assert len(odometry["time"]) > 0.95 * (len(recording.imu_utime) - 450)


def without(messages: dict[str, Any], begin_ns: int, end_ns: int) -> dict[str, Any]:
    """The messages of all sensors but those of a while."""
    kept = {
        sensor: (messages[f"{sensor}_time"] < begin_ns) | (messages[f"{sensor}_time"] >= end_ns)
        for sensor in ("imu", "wheel", "gpr")
    }
    of = {"imu": ["imu_time", "acceleration", "angular_velocity"]}
    of |= {"wheel": ["wheel_time", "wheel_distance"], "gpr": ["gpr_time", "traces"]}
    return {name: messages[name][kept[sensor]] for sensor in of for name in of[sensor]}


# A robot's computer that stalls: nothing is heard for half a second, and the encoder counts on.
def test_half_a_second_without_any_sensor_loses_no_distance() -> None:
    messages = read_recording(SAMPLE).messages()
    heard = gprodom.Odometry(set=["graph.enabled=false"]).run(**messages).odometry
    time, position = heard["time"], heard["position"]
    # Where the speed changes most meanwhile, so that one held would not do.
    speed, half = heard["velocity"][:, 0], 100
    changes = np.abs(speed[2 * half :] - speed[: -2 * half])
    changes[time[: -2 * half] < time[0] + 20_000_000_000] = 0.0
    begins = []
    for _ in range(3):
        i = int(np.argmax(changes))
        begins.append(time[i + half // 2])
        changes[max(0, i - 1000) : i + 1000] = 0.0
    for begin in begins:
        end = begin + 500_000_000
        deaf = gprodom.Odometry(set=["graph.enabled=false"]).run(**without(messages, begin, end))
        assert deaf.odometry["time"][deaf.odometry["time"] > end][0] - end < 1_000_000_000
        way, start = [], position[np.searchsorted(time, begin)]
        for odometry in (deaf.odometry, heard):
            later = np.searchsorted(odometry["time"], end + 1_000_000_000)
            way.append(np.linalg.norm(odometry["position"][later] - start))
        assert way[0] == pytest.approx(way[1], abs=0.03)


@pytest.mark.parametrize(
    ("times", "said"),
    [
        (lambda ns: ns * 1e-9, "imu_time: expected nanoseconds as integers .* got float64"),
        (lambda ns: ns.astype("datetime64[ns]"), "imu_time: expected nanoseconds as integers"),
        (lambda ns: ns // 1000, r"100 samples within .*of microseconds: t \* 1000"),
        (lambda ns: ns // 1_000_000, "100 samples within"),
    ],
)
def test_times_in_other_units_are_an_error(times: Callable[[Any], Any], said: str) -> None:
    messages = read_recording(SAMPLE).messages()
    for name in ("imu_time", "wheel_time", "gpr_time"):
        messages[name] = times(messages[name])
    with pytest.raises(ValueError, match=said):
        gprodom.Odometry().run(**messages)


def test_one_sensor_in_other_units_is_an_error() -> None:
    for name in ("wheel_time", "gpr_time"):
        messages = read_recording(SAMPLE).messages()
        messages[name] = messages[name] // 1000
        with pytest.raises(ValueError, match=f"{name}: from .* no overlap with imu_time"):
            gprodom.Odometry().run(**messages)
    messages["gpr_time"] = []
    messages["traces"] = np.zeros((0, 201))
    assert gprodom.Odometry(set=["gpr.enabled=false"]).run(**messages).odometry["time"].size > 0


def test_single_times_in_microseconds_are_an_error() -> None:
    odometry = gprodom.Odometry()
    still, gravity = np.zeros(3), np.array([0.0, 0.0, 9.81])
    with pytest.raises(ValueError, match="of microseconds"):
        for i in range(200):
            odometry.add_imu(1_700_000_000_000_000 + 5000 * i, gravity, still)
    with pytest.raises(TypeError):
        odometry.add_imu(1_700_000_000.5, gravity, still)


def test_configurations_merge(tmp_path: Path) -> None:
    one, two = tmp_path / "one.yaml", tmp_path / "two.yaml"
    one.write_text("wheel:\n  scale: 0.9\n  noise: 0.01\n")
    two.write_text("wheel:\n  scale: nonsense\n")
    gprodom.Odometry(str(one))
    with pytest.raises(gprodom.ConfigError, match=r"two\.yaml:2: wheel\.scale"):
        gprodom.Odometry([str(one), str(two)])
    with pytest.raises(gprodom.ConfigError, match=r"two\.yaml:2: wheel\.scale"):
        gprodom.Odometry([str(two), str(one)])


# Standstill and coherence on one sequence of each scene; bench/motion.py runs more.


def test_motion_of_the_sequences(shared: Path, tmp_path: Path) -> None:
    """Standstill, slip, and coherence no surer than it is; none of it harms the estimate."""
    sequences = sorted((shared / "cmu_like").glob("*.zip"))[2::3]
    assert sequences
    outcomes = [measure(sequence, [], tmp_path) for sequence in sequences]
    prompt = sum(outcome.prompt for outcome in outcomes)
    assert prompt >= 0.9 * sum(outcome.episodes for outcome in outcomes)
    for outcome in outcomes:
        standing, name = outcome.standing, outcome.sequence
        assert standing.recall > 0.95, name
        assert standing.false < 0.005, name
        assert standing.unseen_mm < 10, name
        assert outcome.false_flags <= 0.01 * outcome.metres + 1, name
        assert outcome.coherence_spans > 20, name
        assert outcome.coherence_covered > 0.9, name
        assert outcome.rmse["gprodom"] < 1.1 * outcome.rmse["imu_wheel"], name


def coarse_ground(path: Path) -> None:
    """Traces 0.6 m apart by a radar of 50 MHz, its echoes weak and without anything in common."""
    interval, samples = 8e-10, 300
    time = np.arange(samples) * interval

    def wavelet(at: float) -> np.ndarray:
        a = (np.pi * 50e6 * (time - at)) ** 2
        return (1 - 2 * a) * np.exp(-a)

    strength = 100 * np.exp(-time / 60e-9) * (time > 40e-9)
    reflections = np.random.default_rng(1).normal(0, strength, (100, samples))
    echoes = reflections @ np.array([wavelet(at) for at in time])
    counts = np.rint(30000 * wavelet(30e-9) + echoes).astype(np.int16)
    write_survey(
        path, Survey("coarse", counts[None], 0.6, np.zeros(1), interval, 30e-9, closed=False)
    )


def test_ground_that_shows_no_slow_motion(tmp_path: Path, cli: Cli) -> None:
    """It is no witness against the wheel: no worse than without a radar, and told."""
    coarse_ground(tmp_path / "coarse.npz")
    drive = tmp_path / "1700000001-0-coarse-cmu-gpr.zip"
    made = ["--ground", str(tmp_path / "coarse.npz"), "--distance", "60", "--seed", "1"]
    cli("simulate", *made, "-o", drive)
    error = {}
    for method in ("imu_wheel", "gprodom"):
        path = tmp_path / f"{method}.tum"
        said = cli("run", drive, "--method", method, "--tum", path).err
        assert ("the radar cannot detect slow motion" in said) is (method == "gprodom")
        error[method] = cli.json("score", path, drive)["ate_rmse_m"]
    assert error["gprodom"] < 1.1 * error["imu_wheel"] + 0.01
