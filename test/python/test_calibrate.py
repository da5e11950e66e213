"""Calibration: the constants of simulated recordings are found within their uncertainties."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml
from matplotlib.figure import Figure

from conftest import Cli
from gprodom import Odometry, describe_config
from gprodom.calibrate.fragment import Found, fragment
from gprodom.calibrate.imu import measure_noise
from gprodom.calibrate.offset import Offset, spread
from gprodom.calibrate.radar_timing import find_radar_offset
from gprodom.calibrate.timing import find_offset
from gprodom.config import STANDARD
from gprodom.convert.cmu import Recording
from gprodom.convert.streams import streams
from gprodom.errors import Error
from gprodom.ground.survey import find_survey
from gprodom.lcm import logs
from gprodom.lcm.log_writer import write_log
from gprodom.simulate import Spec, make_route, simulate, stream
from gprodom.simulate.ground import GroundSpec
from gprodom.simulate.recording import as_recording
from gprodom.simulate.robot import robot
from gprodom.simulate.sequence import SurveySpec
from gprodom.simulate.wheel import WheelSpec


def sensors(log: Path) -> dict[str, logs.Channel]:
    return logs.read_roles(log, STANDARD.of("imu", "wheel", "gpr_trace"))


def write(path: Path, recording: Recording) -> Path:
    """A log of it."""
    write_log(path, streams(recording, 2e-10))
    return path


def drive_log(path: Path, seed: int, slips: int = 2, late: int = 0, **wheel: object) -> Path:
    """A robot's log; `late` (us) is added to the IMU's stamps."""
    route = make_route("loop", 40.0, 0.8, 4.0, stream(seed, "route"))
    spec = robot(route, None, slips=slips)
    spec = replace(spec, wheel=replace(spec.wheel, **wheel))
    recording = as_recording(simulate(spec, seed))
    return write(path, replace(recording, imu_utime=recording.imu_utime + late))


def test_wheel_scale_and_lever_arm(tmp_path: Path, cli: Cli) -> None:
    log = drive_log(tmp_path / "a.lcmlog", 1, scale=1.03, scale_sigma=0.0, lever_arm=(0.0, 0.25))
    out = tmp_path / "wheel.yaml"
    found = cli.json("calibrate", "wheel", log, "-o", out)
    assert abs(found["scale"] - 1.03) < max(4 * found["scale_sigma"], 5e-4)
    assert abs(found["lever_m"] - 0.25) < max(4 * found["lever_sigma"], 5e-3)
    assert found["scale_sigma"] < 0.005
    written = yaml.safe_load(out.read_text())
    assert written["wheel"]["scale"] == pytest.approx(found["scale"], abs=1e-5)
    assert written["wheel"]["lever_arm"][1] == pytest.approx(found["lever_m"], abs=1e-3)


def test_wheel_scale_on_the_rest(tmp_path: Path, cli: Cli) -> None:
    log = drive_log(tmp_path / "a.lcmlog", 2, slips=0, scale=0.95, scale_sigma=0.0)
    (rest,) = cli.json("calibrate", "wheel", log, "--fit-share", "0.5")["rest"]
    assert rest["error_before_pct"] == pytest.approx(-5, abs=0.7)
    assert abs(rest["error_after_pct"]) < 0.7
    cli("calibrate", "wheel", log, "--fit-share", "2", code=2)
    cli("calibrate", "wheel", log, "--prism", "1", code=2)


def test_imu_noise() -> None:
    rng = np.random.default_rng(1)
    rate, n = 100.0, 100 * 1200
    density, walk = 2e-3, 4e-4
    white = rng.normal(0, density * np.sqrt(rate), (n, 3))
    steps = rng.normal(0, walk / np.sqrt(rate), (n, 3))
    found = measure_noise(white + np.cumsum(steps, axis=0), rate)
    assert found.density == pytest.approx(density, rel=0.05)
    assert found.walk == pytest.approx(walk, rel=0.35)
    assert not found.walk_is_bound
    still = measure_noise(white, rate)
    assert still.walk_is_bound
    assert still.density == pytest.approx(density, rel=0.03)


def test_uncertainty_of_the_walk_reflects_its_few_long_averages() -> None:
    """Twenty minutes hold some ten averages of two minutes on each axis: no "+- 0 %"."""
    rng = np.random.default_rng(1)
    rate, walks = 20.0, []
    for _ in range(12):
        steps = rng.normal(0, 4e-4 / np.sqrt(rate), (24_000, 3))
        found = measure_noise(
            rng.normal(0, 2e-3 * np.sqrt(rate), steps.shape) + steps.cumsum(0), rate
        )
        walks.append(found)
    scatter = np.std([found.walk for found in walks]) / 4e-4
    told = np.median([found.walk_sigma for found in walks])
    assert 0.5 * scatter < told < 3 * scatter
    assert 0.05 < told < 0.5


def test_what_is_not_significant_is_a_comment() -> None:
    sure = Found("imu.time_offset", "0.0100", "+- 0.0010 s")
    unsure = Found("gpr.time_offset", "0.0001", "+- 0.0010 s", Offset(1e-4, 1e-3, 0.5).significant)
    text = fragment([sure, unsure])
    assert yaml.safe_load(text) == {"imu": {"time_offset": 0.01}}
    assert "# not significant: gpr.time_offset: 0.0001  # +- 0.0010 s" in text
    assert yaml.safe_load(fragment([unsure])) == {}
    assert Offset(2.1e-3, 1e-3, 0.5).significant


def test_imu_fragment(tmp_path: Path, cli: Cli, drawn: list[Figure]) -> None:
    """The standstill at the start of a drive, as the simulated IMU was made."""
    route = make_route("line", 6.0, 0.6, 60.0, stream(1, "route"))
    log = write(tmp_path / "a.lcmlog", as_recording(simulate(robot(route, None), 5)))
    out, picture = tmp_path / "imu.yaml", tmp_path / "allan.png"
    cli("calibrate", "imu", log, "-o", out, "--plot", picture)
    written = yaml.safe_load(out.read_text())["imu"]
    assert written["gyro_noise_density"] == pytest.approx(1.61e-4, rel=0.05)
    assert written["accel_noise_density"] == pytest.approx(5.85e-4, rel=0.05)
    assert "too short to tell" in out.read_text()
    [figure] = drawn
    assert picture.is_file()
    for axis, noise in zip(figure.axes, ("gyro", "accel"), strict=True):
        assert [axes.get_label() for axes in axis.containers] == ["x", "y", "z"]
        for container in axis.containers:  # at short times white noise, falling by its root
            tau, deviation = np.array(container.lines[0].get_data())
            density = np.median((deviation * np.sqrt(tau))[tau < 1.0])
            assert density == pytest.approx(written[f"{noise}_noise_density"], rel=0.1)
    short = drive_log(tmp_path / "short.lcmlog", 3)
    assert "at least 20 s" in cli.error("calibrate", "imu", short)


@pytest.mark.parametrize("late", [0, 60_000])
def test_time_offset(tmp_path: Path, late: int) -> None:
    route = make_route("stops", 40.0, 0.8, 4.0, stream(4, "route"))
    recording = as_recording(simulate(Spec(route, wheel=WheelSpec(), ground=None, station=None), 4))
    recording = replace(recording, imu_utime=recording.imu_utime + late)
    found = find_offset(sensors(write(tmp_path / "a.lcmlog", recording)))
    assert found.offset_s == pytest.approx(-late * 1e-6, abs=0.012)
    assert found.sigma_s < 0.02
    assert found.explained > 0.4


@pytest.mark.parametrize("ground", ["rays", "basement"])
@pytest.mark.parametrize("late", [0, 50_000])
def test_radar_time_offset(tmp_path: Path, late: int, ground: str, cli: Cli) -> None:
    """The offset added to the radar's stamps is found, and the estimator accepts the file."""
    spec, length = GroundSpec(), None
    if ground != "rays":
        spec, length = SurveySpec(ground), find_survey(ground).length
    route = make_route("stops", 30.0, 0.6, 4.0, stream(5, "route"), length)
    recording = as_recording(simulate(robot(route, spec, slips=2), 5))
    recording = replace(recording, gpr_utime=recording.gpr_utime + late)
    log, out = write(tmp_path / "a.lcmlog", recording), tmp_path / "time.yaml"
    found = cli.json("calibrate", "time", log, "-o", out)
    assert found["gpr"]["sigma_s"] < 0.02
    assert abs(found["gpr"]["offset_s"] + late * 1e-6) < max(3 * found["gpr"]["sigma_s"], 0.01)
    assert abs(found["imu"]["offset_s"]) < 0.02
    if abs(found["gpr"]["offset_s"]) <= 2 * found["gpr"]["sigma_s"]:
        assert late == 0
        assert "# not significant: gpr.time_offset" in out.read_text()
        return
    offset = yaml.safe_load(out.read_text())["gpr"]["time_offset"]
    config = yaml.safe_load(describe_config([f"gpr.time_offset={offset}"]))
    assert config["gpr"]["time_offset"] == pytest.approx(found["gpr"]["offset_s"], abs=1e-4)


def test_no_radar_offset_without_motion(tmp_path: Path) -> None:
    route = make_route("line", 6.0, 0.6, 30.0, stream(1, "route"))
    recording = as_recording(simulate(robot(route, GroundSpec()), 5))
    still = recording.gpr_utime < recording.gpr_utime[0] + 25_000_000
    recording = replace(
        recording, gpr_utime=recording.gpr_utime[still], traces=recording.traces[still]
    )
    log = sensors(write(tmp_path / "a.lcmlog", recording))
    with pytest.raises(Error, match="starts and stops"):
        find_radar_offset(log)


def test_radar_time_offset_moves_the_stamps() -> None:
    """With the offset, results of traces that were stamped late have the right stamps."""
    route = make_route("stops", 6.0, 0.6, 4.0, stream(6, "route"))
    recording = as_recording(simulate(robot(route, GroundSpec()), 6))
    late = replace(recording, gpr_utime=recording.gpr_utime + 30_000)

    def begins(offset: float) -> set[int]:
        keys = ["gpr.front_end=stationarity", "graph.enabled=false", f"gpr.time_offset={offset}"]
        found = Odometry(set=keys).run(**late.messages())
        return {displacement["from"] for displacement in found.displacements}

    stamps = set(recording.gpr_utime * 1000)
    assert len(begins(-0.03)) > 20
    assert begins(-0.03) <= stamps
    assert not begins(0.0) & stamps


@pytest.mark.parametrize("parts", [[], [0.1]])
def test_a_spread_needs_parts(parts: list[float]) -> None:
    """Of a drive that shows an offset in one place, or nowhere: no sigma, and no crash."""
    with pytest.raises(Error, match="more starts and stops"):
        spread(parts, 0.1)
