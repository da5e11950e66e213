"""Calibration: the constants of simulated recordings are found within their uncertainties."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml
from matplotlib.figure import Figure

from conftest import Cli
from gprodom import Odometry, describe_config
from gprodom.calibrate.antennas import Drive, distance_of, find_distance
from gprodom.calibrate.fragment import Found, fragment
from gprodom.calibrate.imu import measure_noise
from gprodom.calibrate.mount import find_mount
from gprodom.calibrate.offset import Offset, spread
from gprodom.calibrate.radar_timing import find_radar_offset
from gprodom.calibrate.timing import find_offset
from gprodom.config import STANDARD, read_antennas
from gprodom.convert.cmu import Recording
from gprodom.convert.streams import streams
from gprodom.errors import Error
from gprodom.ground.survey import find_survey
from gprodom.lcm import logs
from gprodom.lcm.log_writer import write_log
from gprodom.random_streams import stream
from gprodom.simulate.antennas import draw_antennas
from gprodom.simulate.drive import Bend, DriveSpec, Move, Stop, Track
from gprodom.simulate.ground import GroundSpec
from gprodom.simulate.imu import rotation_from_rpy
from gprodom.simulate.recording import as_recording, log_streams
from gprodom.simulate.robot import RADAR, robot
from gprodom.simulate.routes import make_route
from gprodom.simulate.sequence import Simulated, Spec, SurveySpec, simulate
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
    assert "at least 20 s" in cli.error("calibrate", "imu", drive_log(tmp_path / "short.lcmlog", 3))


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


# ``gprodom calibrate antennas`` on a simulated drive with two antennas in a row.


TRUE_M, WAY_M = 0.3, 12.0


def drive_of_two(way_m: float = WAY_M) -> Simulated:
    """12 m straight on, with antennas that are truly 0.3 m apart."""
    drawn = draw_antennas(
        [(TRUE_M / 2, 0.0), (-TRUE_M / 2, 0.0)], RADAR, stream(1, "antennas in a test")
    )
    antennas = tuple(replace(a, radar=replace(a.radar, lever_arm=a.told)) for a in drawn)
    track = DriveSpec(Track((Bend(1000.0),)), (Stop(4.0), Move(way_m, 0.4), Stop(2.0)))
    return simulate(Spec(track, radar=antennas[0].radar, antennas=antennas), 1)


def test_a_wrong_distance_is_found(tmp_path: Path, cli: Cli) -> None:
    """Told 2 cm too much, the distance is found within what the command says of itself."""
    log, output = tmp_path / "in.lcmlog", tmp_path / "antennas.yaml"
    write_log(log, log_streams(drive_of_two()))
    told = "gpr.antennas={0: [0.16, 0, 0], 1: [-0.16, 0.01, 0]}"
    words = ["calibrate", "antennas", log, "--distance", WAY_M, "--set", told]
    found = cli.json(*words, "-o", output)
    assert found["configured_m"] == pytest.approx(0.32)
    assert found["sigma_m"] < 0.003
    assert abs(found["distance_m"] - TRUE_M) < 3 * found["sigma_m"]
    places = read_antennas([output])
    assert distance_of(places) == pytest.approx(found["distance_m"], abs=2e-5)
    assert places[1][1] == 0.01
    assert places[0][0] == pytest.approx(-places[1][0]), "about their middle"


def test_the_known_distance_is_no_surer_with_more_drives() -> None:
    """But the passages' part is, and a spread beyond it counts."""
    drive = Drive(estimated_m=10.0, passages=25, sigma_m=0.02)
    one = find_distance([drive], 0.3, 10.1, 0.0)
    assert one.distance_m == pytest.approx(0.303)
    assert one.sigma_m == pytest.approx(0.3 * 0.002)
    assert find_distance([drive] * 4, 0.3, 10.1, 0.0).sigma_m == pytest.approx(0.3 * 0.001)
    assert find_distance([drive] * 400, 0.3, 10.0, 0.1).sigma_m > 0.3 * 0.01
    apart = [Drive(9.0, 25, 0.02), Drive(11.0, 25, 0.02)]
    assert find_distance(apart, 0.3, 10.0, 0.0).sigma_m > 0.3 * 0.05


def test_antennas_that_are_not_in_a_row_are_refused() -> None:
    """One, or two side by side."""
    for places in ({}, {0: (0.1, 0.0, 0.0)}, {0: (0.1, 0.2, 0.0), 1: (0.1, -0.2, 0.0)}):
        with pytest.raises(Error, match="in a row"):
            distance_of(places)


# ``gprodom calibrate mount`` on drives made here.


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
