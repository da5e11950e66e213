"""Simulated robots with left and right wheels, on several surfaces."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from conftest import Cli, run_cli
from gprodom.ground.survey import LATERAL, Survey, find_survey, write_survey
from gprodom.lcm.logs import read
from gprodom.simulate import Spec, make_route, simulate, stream
from gprodom.simulate.antennas import AntennaSpec, draw_antennas, receive
from gprodom.simulate.drive import Drive
from gprodom.simulate.ground import Ground, GroundSpec
from gprodom.simulate.imu import measure
from gprodom.simulate.pair import PairSpec
from gprodom.simulate.pair import measure as measure_pair
from gprodom.simulate.radar import RadarSpec
from gprodom.simulate.robot import KINDS
from gprodom.simulate.sequence import SurveySpec
from gprodom.simulate.surface import SURFACES, draw_grip
from test_simulate import NO_NOISE

EXACT = PairSpec(0.5, scale_sigma=0, radii_sigma=0, track_sigma=0, noise=0, quantum=1e-7)


@pytest.fixture(name="drive")
def _drive() -> Drive:
    return Drive(make_route("loop", 20.0, 0.8, 2.0, stream(1, "route")), stream(1, "drive"))


def times(drive: Drive, rate: float = 50.0) -> np.ndarray:
    return np.arange(0, drive.duration - 0.1, 1 / rate)


def test_sides_differ_by_track_times_turn(drive: Drive) -> None:
    t = times(drive)
    pair, motion = measure_pair(t, drive, EXACT, stream(1, "pair")), drive.at(t)
    apart = (pair.right - pair.left) * EXACT.quantum
    np.testing.assert_allclose(apart, 0.5 * (motion.yaw - motion.yaw[0]), atol=1e-3)
    middle = 0.5 * (pair.right + pair.left) * EXACT.quantum
    np.testing.assert_allclose(middle, motion.s, atol=1e-3)


def test_skid_steer_turns_as_if_wider(drive: Drive) -> None:
    t = times(drive)
    pair = measure_pair(t, drive, replace(EXACT, skids=True), stream(1, "pair"))
    motion = drive.at(t)
    wider = (pair.right - pair.left)[-1] * EXACT.quantum / (motion.yaw[-1] - motion.yaw[0])
    assert wider == pytest.approx(0.5 * SURFACES["floor"].widening, rel=0.01)


def test_late_and_held(drive: Drive) -> None:
    t = times(drive)
    prompt = measure_pair(t, drive, EXACT, stream(1, "pair"))
    late = measure_pair(t, drive, replace(EXACT, late=0.2), stream(1, "pair"))
    np.testing.assert_allclose(late.left[10:], prompt.left[:-10], atol=10)
    held = measure_pair(t, drive, replace(EXACT, held=0.25), stream(1, "pair"))
    speeds = np.diff(held.left)
    assert len(np.unique(np.round(speeds / 100))) < len(speeds) / 5


def test_grip_has_the_quantiles_of_its_surface() -> None:
    grip = draw_grip(SURFACES["ice"], 20_000.0, stream(1, "grip"))
    shown = np.quantile(grip, [0.25, 0.5, 0.75])
    np.testing.assert_allclose(shown, SURFACES["ice"].grip[1:4], atol=0.03)


def test_sideways_speed_is_that_of_the_centre(drive: Drive) -> None:
    """The centre moves only forwards; accelerations still integrate to the motion."""
    spec = make_route("loop", 20.0, 0.8, 2.0, stream(1, "route"))
    spec = replace(spec, centre_offset=0.3, lateral_noise=0.0)
    turning = Drive(spec, stream(1, "drive"))
    t = np.arange(0, turning.duration - 0.1, 0.002)
    motion = turning.at(t)
    np.testing.assert_allclose(motion.lateral, -0.3 * motion.yaw_rate, atol=1e-12)
    gained = motion.acceleration[:, 1] - motion.yaw_rate * motion.v
    lateral = np.concatenate([[0.0], np.cumsum(0.5 * (gained[1:] + gained[:-1]) * 0.002)])
    np.testing.assert_allclose(lateral, motion.lateral, atol=1e-4)


def test_tilting_ground_turns_gravity(drive: Drive) -> None:
    """The gyro integrates to the tilt that the force shows."""
    spec = replace(NO_NOISE, rate=500.0, tilt=0.02)
    t = np.arange(0, drive.duration - 0.1, 1 / spec.rate)
    motion = drive.at(t)
    data = measure(motion, spec, stream(1, "imu"))
    pitch = -(data.acceleration[:, 0] - motion.acceleration[:, 0]) / spec.gravity
    assert 0.01 < np.std(pitch[motion.travelled > 1]) < 0.03
    roll_rate, pitch_rate, yaw_rate = data.angular_velocity.T
    roll = (data.acceleration[:, 1] - motion.acceleration[:, 1]) / spec.gravity
    change = pitch_rate - roll * yaw_rate  # of pitch, to first order of the tilt
    shown = pitch[0] + np.concatenate([[0.0], np.cumsum(0.5 * (change[1:] + change[:-1]))]) / 500
    np.testing.assert_allclose(shown, pitch, atol=2e-3)
    assert np.std(roll_rate) > 0


def test_engine_shakes_at_a_standstill(drive: Drive) -> None:
    spec = replace(KINDS["car"].imu, tilt=0.0)
    t = np.arange(0, 2.0, 1 / spec.rate)
    shaken = measure(drive.at(t), spec, stream(1, "imu")).acceleration
    assert np.std(shaken[:, 0]) == pytest.approx(spec.accel_idle, rel=0.1)


def test_command(tmp_path: Path, cli: Cli) -> None:
    log = tmp_path / "field.lcmlog"
    arguments = ["simulate", "--robot", "skid_steer", "--surface", "ice", "--ground", "none"]
    arguments += ["--distance", "10", "--standstill", "3", "-o", str(log)]
    cli(*arguments)
    first = log.read_bytes()
    cli(*arguments)
    assert log.read_bytes() == first
    assert set(read(log)) == {"IMU", "WHEELS", "TOTAL_STATION"}
    assert json.loads((tmp_path / "field.json").read_text())["pair"]["track"] > 1.08
    assert "wants a --robot" in cli.error("simulate", "--surface", "ice", "-o", log, code=2)


# The simulator's ground: scatterers and layers, changed permittivity, survey lines.


def test_same_place_same_trace() -> None:
    x, y = np.linspace(0, 5, 251), np.linspace(0, 0.2, 251)
    ground = Ground(GroundSpec(), x, y, stream(1, "ground"))
    traces = ground.traces(x, y)
    np.testing.assert_array_equal(ground.traces(x[::-1], y[::-1])[::-1], traces)
    traces = traces - traces.mean(axis=0)
    far = traces[:-100].ravel() @ traces[100:].ravel()
    near = traces[:-1].ravel() @ traces[1:].ravel()
    here = traces.ravel() @ traces.ravel()
    assert 0.9 < near / here < 0.999  # 2 cm aside is seen, and alike
    assert abs(far / here) < 0.3


def test_changed_permittivity_delays_the_echoes() -> None:
    x = np.linspace(0, 5, 251)

    def seen(*permittivity: float) -> np.ndarray:
        spec = GroundSpec(permittivity=permittivity)
        return Ground(spec, x, np.zeros_like(x), stream(1, "ground")).traces(x, np.zeros_like(x))

    as_it_was = seen()
    np.testing.assert_allclose(seen(0.0, 0.0), as_it_was, atol=1.0)
    spec = GroundSpec()
    begin = round(spec.surface_time / spec.sample_interval)
    late = begin + (np.arange(30, 150) - begin) * 1.1  # 21 % more: slower by a tenth
    samples = np.arange(spec.samples)
    slower = np.array([np.interp(late, samples, trace) for trace in seen(0.21, 0.21)])
    slower, before = (a - a.mean(axis=0) for a in (slower, as_it_was[:, 30:150]))
    alike = np.sum(slower * before) / np.sqrt(np.sum(slower**2) * np.sum(before**2))
    assert alike > 0.9
    # Only below the first half metre: what is above arrives as it did.
    deep = seen(0.0, 0.0, 0.2, 0.2)
    shallow = slice(begin, begin + round(2 * 0.4 / spec.wave_speed / spec.sample_interval))
    np.testing.assert_allclose(deep[:, shallow], as_it_was[:, shallow], atol=300.0)
    assert np.abs(deep[:, 120:] - as_it_was[:, 120:]).max() > 300.0


def test_ground_of_a_survey_is_seen_again(tmp_path: Path) -> None:
    """The same place gives the same trace forwards, backwards and a lap later."""
    x = np.arange(500) / 500
    lines = 5000 * np.sin(2 * np.pi * (x[:, None] * 30 + np.arange(120) / 13))
    survey = Survey("made", lines.astype(np.int16)[None], 0.02, np.zeros(1), 2e-10, 1e-9)
    write_survey(tmp_path / "made.npz", survey)
    drive = make_route("loop", 30.0, 0.6, 1.0, stream(1, "route"), survey.length)
    ground = SurveySpec(str(tmp_path / "made.npz"), middle=0.0)
    clean = RadarSpec(noise=0.0)
    data = simulate(Spec(replace(drive, lateral_noise=0), radar=clean, ground=ground), 1)
    s = data.motion_at(data.gpr_utime).s
    expected = 5000 * np.sin(2 * np.pi * (s[:, None] / 10 * 30 + np.arange(120) / 13))
    assert s.max() > 20
    assert np.abs(data.traces - expected).max() < 0.02 * 5000


# Several simulated antennas on one robot, and ground that differs beside the track.


QUIET = RadarSpec(noise=0.0)


def alike(a: np.ndarray, b: np.ndarray) -> float:
    a, b = a - a.mean(axis=0), b - b.mean(axis=0)
    return float(np.sum(a * b) / np.sqrt(np.sum(a**2) * np.sum(b**2)))


@pytest.mark.parametrize("ground", ["rays", "basement"])
def test_two_antennas_are_written_and_converted(ground: str, tmp_path: Path) -> None:
    path = tmp_path / "1700000000-0-two-cmu-gpr.zip"
    words = ["simulate", "--seed=3", "--distance=2", "--standstill=1", f"--ground={ground}"]
    words += ["--antenna=0.15,0", "--antenna=-0.15,0.1", "-o", str(path)]
    run_cli(*words)
    run_cli("convert", "cmu", path, "-o", tmp_path / "two.lcmlog")
    gpr = read(tmp_path / "two.lcmlog")["GPR_TRACE"]
    times = [gpr["utime"][gpr["antenna_id"] == i] for i in (0, 1)]
    count = min(map(len, times))
    assert count > 100
    assert set(times[1][:count] - times[0][:count]) == {4000}
    facts = json.loads(path.with_suffix(".json").read_text())
    assert facts["antennas"] == [[0.15, 0, 0], [-0.15, 0.1, 0]]
    off = np.subtract(facts["antennas_true"], facts["antennas"])
    assert np.all(off[0] == 0)
    assert 0 < np.abs(off[1]).max() < 0.02


def test_with_one_antenna_nothing_is_said_of_several(tmp_path: Path) -> None:
    path = tmp_path / "one.zip"
    words = ["--distance=1", "--standstill=0", "--ground=none", "--antenna=0.1,0"]
    run_cli("simulate", *words, "-o", path)
    facts = json.loads(path.with_suffix(".json").read_text())
    assert not [key for key in (*facts, *facts["spec"]) if key.startswith("antennas")]
    assert facts["spec"]["radar"]["lever_arm"] == [0.1, 0.0]


@pytest.mark.parametrize("ground", [GroundSpec(), SurveySpec("basement")])
def test_the_rear_antenna_sees_what_the_front_one_saw(ground: GroundSpec | SurveySpec) -> None:
    drive = replace(make_route("line", 8.0, 0.4, 0.0, stream(1, "route")), lateral_noise=0.0)
    arms = ((0.15, 0.0), (-0.15, 0.0), (-0.15, 0.06))
    antennas = tuple(AntennaSpec(replace(QUIET, lever_arm=arm), arm) for arm in arms)
    data = simulate(Spec(drive, radar=QUIET, antennas=antennas, ground=ground), 1)
    s = data.motion_at(data.gpr_utime).s
    forwards = slice(0, int(np.argmax(s)))
    places = np.arange(0.4, s.max() - 0.4, 0.02)
    seen = []
    received = (data.traces, *(a.counts for a in data.more_antennas.values()))
    for traces, arm in zip(received, arms, strict=True):
        at = np.searchsorted(s[forwards] + arm[0], places)
        seen.append(traces[forwards][at].astype(float))
    assert alike(seen[0], seen[1]) > 0.95  # traces are 2 cm apart, so the places agree to 1 cm
    assert alike(seen[0], seen[2]) < alike(seen[0], seen[1]) - 0.03


@pytest.mark.parametrize("name", ["garage", "basement", "floor"])
def test_ground_beside_the_track_differs_as_real_ground(name: str) -> None:
    survey = find_survey(name).decorrelating()
    along = np.arange(0.0, survey.length, 0.02)

    def seen(beside: float) -> np.ndarray:
        return survey.turned_traces(along, np.full_like(along, beside))

    first = find_survey(name).traces(along, np.zeros_like(along))
    np.testing.assert_allclose(seen(0.0), first, atol=1.0)
    for begin in (-0.02, 0.0, 0.03):  # the same anywhere, beside the lines too
        here = seen(begin)
        assert np.std(here - here.mean(axis=0)) == pytest.approx(
            np.std(first - first.mean(axis=0)), rel=1e-3
        )
        for off in (0.01, 0.03, 0.06):
            assert alike(here, seen(begin + off)) == pytest.approx(np.cos(off / LATERAL), abs=2e-3)


def test_ground_of_a_single_line_differs_beside_it_too() -> None:
    lines = stream(1, "line").randint(-3000, 3000, (1, 200, 50)).astype(np.int16)
    survey = Survey("made", lines, 0.02, np.zeros(1), 2e-10, 0.0).decorrelating()
    along = np.arange(0, 4, 0.02)
    seen = [survey.turned_traces(along, np.full_like(along, at)) for at in (0.0, 0.02)]
    assert alike(*seen) == pytest.approx(np.cos(0.02 / LATERAL), abs=2e-3)


def test_faults_of_an_antenna() -> None:
    """A tone comes louder, later and with its phase turned, and the drift of time zero adds."""
    interval, frequency, n = 2e-10, 5e8, 200
    t = np.arange(n) * interval
    pulse = np.exp(-(((t - 2e-8) / 4e-9) ** 2))
    clean = np.tile(5000 * pulse * np.cos(2 * np.pi * frequency * t), (3, 1))
    time, still = np.array([0.0, 300.0, 600.0]), np.zeros(3)
    spec = AntennaSpec(
        QUIET, (0, 0), gain=1.5, time_zero=4e-10, time_zero_rate=1e-9 / 600, phase=0.3
    )
    seen = receive(clean, time, still, interval, spec, stream(1, "x"))
    for row, at in zip(seen, time, strict=True):
        late = 4e-10 + 1e-9 * at / 600
        envelope = np.exp(-(((t - late - 2e-8) / 4e-9) ** 2))
        expected = 7500 * envelope * np.cos(2 * np.pi * frequency * (t - late) + 0.3)
        assert np.abs(row - expected).max() < 75
    driven = np.linspace(0, 50, 500)
    bounced = receive(
        np.tile(clean[:1], (500, 1)), driven, driven, interval,
        replace(spec, gain=1.0, bounce=0.004), stream(1, "x"),
    )  # fmt: skip
    assert 0.001 < np.std(np.abs(bounced).max(axis=1)) / 5000 < 0.05


def test_antennas_do_not_bounce_alike() -> None:
    """At no distance along the track, or it would pass for ground between them."""
    driven = np.arange(0, 60, 0.02)
    clean = np.tile(10_000 * np.hanning(100), (len(driven), 1))
    heights = []
    for name in ("front", "rear"):
        spec = AntennaSpec(QUIET, (0, 0), bounce=0.01)
        seen = receive(clean, driven, driven, 2e-10, spec, stream(1, name)).max(axis=1)
        heights.append((seen - seen.mean()) / seen.std())
    alike_at = [np.mean(heights[0][lag:] * heights[1][: len(driven) - lag]) for lag in range(100)]
    assert np.abs(alike_at).max() < 0.4


def test_antennas_are_drawn_with_faults_of_their_own() -> None:
    first, second = draw_antennas([(0.2, 0), (-0.2, 0)], RadarSpec(ringing=10.0), stream(1, "a"))
    assert first.radar.lever_arm == first.told == (0.2, 0)
    assert second.radar.lever_arm != second.told
    for name in ("gain", "time_zero", "phase", "bounce"):
        assert getattr(first, name) != getattr(second, name)
    assert first.radar.noise != second.radar.noise
