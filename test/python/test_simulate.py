"""The simulator: exact motion, sensors with the errors they claim, the same bytes from a seed."""

import hashlib
import json
import re
import zipfile
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml

from conftest import CHECKOUT, CONFIG, SAMPLE, Cli, run_bench, run_cli
from gprodom.errors import UsageError
from gprodom.simulate import Spec, make_route, radar, simulate, stream
from gprodom.simulate.drive import Drive
from gprodom.simulate.imu import ImuSpec, rotation_from_rpy
from gprodom.simulate.lasting import KINDS
from gprodom.simulate.radar import RadarSpec
from gprodom.simulate.robot import robot
from gprodom.simulate.routes import ROUTES
from gprodom.simulate.wheel import Slip, Stuck, WheelSpec

ERRORS = ("noise_density", "bias_walk", "bias_sigma")
NO_NOISE = ImuSpec(**{f"{sensor}_{each}": 0 for sensor in ("gyro", "accel") for each in ERRORS})
NO_WHEEL_NOISE = WheelSpec(scale_sigma=0, scale_walk=0, noise=0, quantum=1e-9)


def route(name: str, distance: float = 30.0, seed: int = 3):
    return make_route(name, distance, 0.8, 2.0, stream(seed, "route"))


@pytest.mark.parametrize("name", ROUTES)
def test_imu_integrates_to_the_truth(name: str) -> None:
    rpy = (0.2, -0.4, 2.0)
    spec = Spec(route(name, 45.0), imu=replace(NO_NOISE, rpy_body_imu=rpy), ground=None)
    data = simulate(spec, 3)
    assert data.drive.duration > 60
    truth = data.motion_at(data.imu_utime)
    assert np.ptp(truth.lateral) > 0.01  # side slip is there
    step = 1 / spec.imu.rate
    rate = data.imu.angular_velocity @ rotation_from_rpy(rpy).T
    force = data.imu.acceleration @ rotation_from_rpy(rpy).T - [0, 0, spec.imu.gravity]
    np.testing.assert_allclose(rate[:, :2], 0, atol=1e-12)

    def integrate(slope: np.ndarray) -> np.ndarray:
        return np.concatenate([[0], np.cumsum(0.5 * step * (slope[1:] + slope[:-1]))])

    yaw = truth.yaw[0] + integrate(rate[:, 2])
    np.testing.assert_allclose(yaw, truth.yaw, atol=2e-5)
    cos, sin = np.cos(yaw), np.sin(yaw)
    velocity = (
        integrate(cos * force[:, 0] - sin * force[:, 1]),
        integrate(sin * force[:, 0] + cos * force[:, 1]),
    )
    for component, position in zip(velocity, (truth.x, truth.y), strict=True):
        np.testing.assert_allclose(position[0] + integrate(component), position, atol=2e-3)


def test_an_imu_beside_the_origin_feels_its_own_path() -> None:
    """Its accelerations are those of its path in the plane, by numeric second derivative."""
    arm = (0.5, -0.3, 0.2)
    data = simulate(Spec(route("loop"), imu=replace(NO_NOISE, lever_arm=arm), ground=None), 3)
    t, h = (data.imu_utime - data.spec.start_utime)[10:-10] * 1e-6, 5e-3

    def place(at: np.ndarray) -> np.ndarray:
        motion = data.drive.at(at)
        turned = np.exp(1j * motion.yaw)
        return np.asarray(motion.x + 1j * motion.y + turned * (arm[0] + 1j * arm[1]))

    second = (place(t + h) - 2 * place(t) + place(t - h)) / h**2
    wanted = second * np.exp(-1j * data.drive.at(t).yaw)
    felt = data.imu.acceleration[10:-10]
    off = felt[:, 0] + 1j * felt[:, 1] - wanted
    assert np.abs(off).max() < 0.005
    at_origin = simulate(Spec(route("loop"), imu=NO_NOISE, ground=None), 3).imu.acceleration
    assert np.abs(felt - at_origin[10:-10])[:, :2].max() > 0.1
    np.testing.assert_allclose(felt[:, 2], data.spec.imu.gravity, atol=1e-9)


def test_wheel_counts_the_distance_of_its_contact_point() -> None:
    wheel = replace(NO_WHEEL_NOISE, scale=1.03, lever_arm=(0.2, 0.4))
    data = simulate(Spec(route("loop"), wheel=wheel, ground=None), 1)
    reported = data.wheel.ticks * wheel.quantum
    t = (data.wheel_utime - data.spec.start_utime) * 1e-6
    # The contact point's own path, from its position in the plane.
    fine = np.linspace(t[0], t[-1], 400_001)
    motion = data.drive.at(fine)
    contact = np.stack(
        [
            motion.x + 0.2 * np.cos(motion.yaw) - 0.4 * np.sin(motion.yaw),
            motion.y + 0.2 * np.sin(motion.yaw) + 0.4 * np.cos(motion.yaw),
        ]
    )
    heading = 0.5 * (motion.yaw[1:] + motion.yaw[:-1])
    forward = np.diff(contact[0]) * np.cos(heading) + np.diff(contact[1]) * np.sin(heading)
    assert reported[-1] == pytest.approx(1.03 * forward.sum(), abs=1e-5)


def test_slip_multiplies_and_spins() -> None:
    slips = (Slip(0.5, 1.0, spin=0.3), Slip(6.0, 2.0, factor=1.5))
    drive = route("line")
    clean = simulate(Spec(drive, wheel=NO_WHEEL_NOISE, ground=None), 1)
    slipped = simulate(Spec(drive, wheel=replace(NO_WHEEL_NOISE, slips=slips), ground=None), 1)
    t = (clean.wheel_utime - clean.spec.start_utime) * 1e-6
    before, after = (np.interp([6.0, 8.0], t, d.wheel.ticks * 1e-9) for d in (clean, slipped))
    assert np.diff(after) == pytest.approx(1.5 * np.diff(before), rel=0.02)
    assert np.interp(1.9, t, slipped.wheel.ticks * 1e-9) == pytest.approx(0.3, rel=0.03)
    assert np.interp(1.9, t, clean.wheel.ticks * 1e-9) == 0


def test_a_stuck_robot_stands_while_its_wheel_turns_and_shakes_it() -> None:
    stuck = Stuck(0.8, 1.0, 0.4)
    imu = replace(NO_NOISE, accel_vibration=0.25)
    spec = Spec(route("line"), imu=imu, wheel=replace(NO_WHEEL_NOISE, stuck=(stuck,)), ground=None)
    data = simulate(spec, 1)
    t = (data.wheel_utime - spec.start_utime) * 1e-6
    assert np.interp(1.9, t, data.wheel.ticks * 1e-9) == pytest.approx(0.4 * 0.7, rel=0.03)
    assert np.interp(1.9, data.truth_utime * 1e-6 - spec.start_utime * 1e-6, data.truth.s) == 0
    shaken = data.imu.acceleration[:, 0]
    imu_t = (data.imu_utime - spec.start_utime) * 1e-6
    during, before = (imu_t > 1.1) & (imu_t < 1.5), imu_t < 0.8
    assert shaken[during].std() == pytest.approx(0.4 * 0.25, rel=0.3)
    assert shaken[before].std() < 0.01 * shaken[during].std()


@pytest.mark.parametrize("kind", KINDS)
def test_slip_that_lasts(kind: str) -> None:
    """The wheel's excess over the way is the slip that was drawn; no kind is none, or wild."""
    spec = Spec(route("random", 60.0), wheel=replace(NO_WHEEL_NOISE, lasting=kind), ground=None)
    excess = []
    for seed in range(6):
        data = simulate(spec, seed)
        rolled = np.abs(np.diff(data.wheel.ticks)).sum() * NO_WHEEL_NOISE.quantum
        excess.append(rolled / data.truth.travelled[-1] - 1)
    assert 0.005 < np.mean(excess) < 0.6, excess
    assert np.ptp(excess) > 0.002, excess


def test_errors_have_the_size_they_claim() -> None:
    """White noise, biases, scale, wheel error and side slip over many drives, each in 4 sigma."""
    runs = 60
    ends = []
    for seed in range(runs):
        drive = replace(route("random", 8.0, seed), lateral_noise=0.01)
        data = simulate(Spec(drive, ground=None, station=None), seed)
        motion = data.motion_at(data.wheel_utime)
        path, wheel = motion.travelled[-1], data.spec.wheel
        true = np.diff(motion.s)
        reported = np.diff(data.wheel.ticks) * wheel.quantum
        moving = np.abs(true) > 1e-4
        error = (reported - data.wheel.scale[0] * true)[moving]
        heading = np.column_stack([-np.sin(motion.yaw), np.cos(motion.yaw)])
        steps = np.diff(np.column_stack([motion.x, motion.y]), axis=0)
        slip = (steps * 0.5 * (heading[1:] + heading[:-1])).sum()
        gyro = data.imu.angular_velocity - data.imu.gyro_bias
        gyro[:, 2] -= data.motion_at(data.imu_utime).yaw_rate
        ends.append(
            [
                (data.wheel.scale[0] - 1) / wheel.scale_sigma,
                error.sum() / (wheel.noise * np.sqrt(path)),
                slip / (0.01 * np.sqrt(path)),
                *(data.imu.gyro_bias[0] / data.spec.imu.gyro_bias_sigma),
                *(data.imu.accel_bias[0] / data.spec.imu.accel_bias_sigma),
                *(np.sqrt(1 / 200 / len(gyro)) * gyro.sum(axis=0) / 2.3e-4),
            ]
        )
    assert np.abs(np.mean(np.square(ends), axis=0) - 1).max() < 4 * np.sqrt(2 / runs)


def test_defaults_are_those_of_the_estimator() -> None:
    imu, wheel, default = ImuSpec(), WheelSpec(), yaml.safe_load(CONFIG.read_text())
    for key in ("gyro_noise_density", "accel_noise_density", "gyro_bias_walk", "accel_bias_walk"):
        assert getattr(imu, key) == float(default["imu"][key])
    for key in ("scale", "scale_sigma", "noise"):
        assert getattr(wheel, key) == default["wheel"][key]
    assert route("line").lateral_noise == default["wheel"]["lateral_noise"]
    state = (CHECKOUT / "src/estimation/nav_state.h").read_text()
    constants = dict(re.findall(r"constexpr double (k\w+) = ([-+0-9.e]+);", state))
    assert imu.accel_bias_sigma == float(constants["kAccelBiasSigma"])
    assert imu.gravity == float(constants["kStandardGravity"])
    assert wheel.scale_walk == float(constants["kWheelScaleWalk"])


def test_loop_closes_and_line_is_seen_again() -> None:
    for name, again in (("loop", 2 + 24 / 2.2), ("line", 2 * 30 / 3.5 - 2)):
        drive = replace(route(name), lateral_noise=0)
        motion = simulate(Spec(drive, ground=None), 1).truth
        both = np.searchsorted(motion.travelled, [2, again])
        assert np.hypot(np.diff(motion.x[both]), np.diff(motion.y[both])) < 0.05


def digest(folder: Path) -> dict[str, str]:
    return {
        str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted(folder.rglob("*"))
        if path.is_file()
    }


def test_same_seed_same_bytes(tmp_path: Path, cli: Cli) -> None:
    arguments = ["simulate", "--distance", "5", "--standstill", "1", "--slips", "2"]
    for folder, seed in (("a", "5"), ("b", "5"), ("c", "6")):
        (tmp_path / folder).mkdir()
        for name in ("x.zip", "y"):
            told = cli.json(*arguments, "--seed", seed, "-o", tmp_path / folder / name)
            assert told["slips"] == 2
    a, b, c = (digest(tmp_path / folder) for folder in "abc")
    assert a == b
    assert len(a) == 10  # a zip, four tables and the radar's facts, two truths of two files each
    del a["y/gpr_meas.json"]  # the radar's sample interval, whatever the seed
    assert not set(a.values()) & set(c.values())


def test_sample_is_made_by_the_command_in_its_readme(tmp_path: Path) -> None:
    text = SAMPLE.with_name("README.md").read_text()
    [(command, name)] = re.findall(r"^gprodom (simulate .*) -o (\S+)$", text, re.M)
    made, shipped = tmp_path / SAMPLE.name, CHECKOUT / name
    run_cli(*command.split(), "-o", made)
    assert shipped.stat().st_size < 5e6
    with zipfile.ZipFile(made) as new, zipfile.ZipFile(shipped) as old:
        assert new.namelist() == old.namelist()
        for name in new.namelist():
            if name.endswith(".json"):
                assert new.read(name) == old.read(name)
                continue
            texts = [archive.read(name).decode().splitlines() for archive in (new, old)]
            tables = [np.genfromtxt(text, delimiter=",", skip_header=1) for text in texts]
            # Another machine's sine may differ in its last bit, and so a rounded figure by one.
            atol = 1.0 if name.endswith("gpr_meas.csv") else 1e-6
            np.testing.assert_allclose(*tables, rtol=1e-7, atol=atol, err_msg=name)
    facts = [json.loads(path.with_suffix(".json").read_text()) for path in (made, shipped)]
    assert facts[0]["slip"] == facts[1]["slip"]


def test_bad_arguments(cli: Cli, tmp_path: Path) -> None:
    said = cli.error("simulate", "--distance", "-3", "-o", tmp_path / "x.zip", code=2)
    assert "expected 1 to 5000" in said and said.count("\n") == 1
    said = cli.error("simulate", "--distance", "3", "-o", tmp_path / "no" / "x.zip")
    assert "does not exist" in said and said.count("\n") == 1


def test_eight_and_stops_over_repeating_ground() -> None:
    """Laps as long as the ground close; lines stay on it."""
    drive = replace(make_route("eight", 40.0, 0.6, 1.0, stream(1, "route"), 10.0), lateral_noise=0)
    motion = simulate(Spec(drive, ground=None), 1).truth
    laps = np.searchsorted(motion.s, [0.5, 10.5, 20.5])
    assert np.ptp(motion.x[laps]) < 0.05
    assert np.ptp(motion.y[laps]) < 0.05
    assert np.abs(np.degrees(np.ptp(motion.yaw))) < 300  # left and right cancel
    stops = make_route("stops", 40.0, 0.6, 1.0, stream(1, "route"), 10.0)
    motion = simulate(Spec(stops, ground=None), 1).truth
    assert motion.s.min() > -1e-6
    assert motion.s.max() <= 9.0 + 1e-6
    assert motion.travelled[-1] == pytest.approx(40, abs=0.5)
    with pytest.raises(UsageError, match="repeats"):
        make_route("random", 40.0, 0.6, 1.0, stream(1, "route"), 10.0)


def test_place_beside_the_track() -> None:
    """Wandering off a closed track and back, over several laps: where, and how far aside."""
    track = make_route("loop", 30.0, 0.6, 1.0, stream(1, "route"), 10.0)
    data = simulate(Spec(replace(track, wander=0.03, yaw=1.0), ground=None), 4)
    motion = data.truth
    along, beside = data.drive.beside_track(motion.s, motion.x, motion.y)
    assert 0.01 < np.abs(beside).max() < 0.2
    assert np.abs(along - motion.s).max() < 0.2
    centre = Drive(replace(track, wander=0.0, lateral_noise=0.0, yaw=1.0), stream(1, "drive"))
    there = centre.beside_track(motion.s, motion.x, motion.y)
    np.testing.assert_allclose(there, (along, beside), atol=1e-9)
    # The middle of the track is driven without wandering.
    exact = simulate(Spec(replace(track, wander=0, lateral_noise=0, yaw=1.0), ground=None), 4)
    m = exact.truth
    along, beside = exact.drive.beside_track(m.s, m.x, m.y)
    assert np.abs(beside).max() < 1e-3
    assert np.abs(along - m.s).max() < 1e-3


def test_radar_faults() -> None:
    time = np.arange(4000) * 1.0  # long enough to see slow drifts whole
    wave = np.tile(3000 * np.sin(np.arange(200) / 4) * np.hanning(200), (4000, 1))

    def measure(**faults: float) -> np.ndarray:
        spec = RadarSpec(noise=0.0, **faults)
        return radar.measure(wave, time, 2e-10, spec, stream(2, "radar")).astype(float)

    clean = measure()
    np.testing.assert_allclose(clean, wave, atol=0.5)
    gain = measure(gain_drift=0.05) @ wave[0] / (wave[0] @ wave[0])
    assert 0.03 < gain.std() < 0.07
    late = [
        np.correlate(trace, wave[0], "full").argmax() - 199
        for trace in measure(time_zero_drift=4e-10)[::40]
    ]
    assert 1 <= np.std(late) <= 4  # two samples
    # Jitter is new in each trace.
    gain = measure(gain_jitter=0.05) @ wave[0] / (wave[0] @ wave[0])
    assert np.std(gain) == pytest.approx(0.05, rel=0.05)
    assert abs(np.corrcoef(gain[1:], gain[:-1])[0, 1]) < 0.05
    slope = np.gradient(wave[0], 2e-10)
    late = -(measure(time_zero_jitter=2e-11) - wave) @ slope / (slope @ slope)
    assert np.std(late) == pytest.approx(2e-11, rel=0.05)
    assert abs(np.corrcoef(late[1:], late[:-1])[0, 1]) < 0.05
    ring = measure(ringing=500.0) - clean
    assert np.abs(ring - ring[0]).max() <= 1.0  # the same in every trace
    struck = np.abs(measure(spikes=0.01) - clean).max(axis=1) > 1000
    assert 0.005 < struck.mean() < 0.02


def test_vibration_grows_with_speed() -> None:
    imu = replace(NO_NOISE, accel_vibration=0.3, gyro_vibration=0.01)
    data = simulate(Spec(route("line"), imu=imu, ground=None, station=None), 3)
    motion = data.motion_at(data.imu_utime)
    shaken = data.imu.acceleration[:, 2] - imu.gravity
    assert np.abs(shaken[np.abs(motion.v) < 1e-9]).max() < 1e-9
    fast, slow = np.abs(motion.v) > 0.7, (np.abs(motion.v) > 0.2) & (np.abs(motion.v) < 0.4)
    per_speed = [np.std(shaken[part] / motion.v[part]) for part in (fast, slow)]
    assert per_speed == pytest.approx([0.3, 0.3], rel=0.15)


def test_lever_arms() -> None:
    spec = robot(route("loop"), None, prism=(0.3, -0.2))
    data = simulate(replace(spec, station=replace(spec.station, noise=0.0)), 2)
    motion = data.motion_at(data.station_utime)
    cos, sin = np.cos(motion.yaw), np.sin(motion.yaw)
    prism = np.column_stack([motion.x + 0.3 * cos + 0.2 * sin, motion.y + 0.3 * sin - 0.2 * cos])
    apart = [np.linalg.norm(p[1:] - p[0], axis=1) for p in (data.station[:, :2], prism)]
    np.testing.assert_allclose(apart[0], apart[1], atol=1e-9)


def test_realism_is_told(shared: Path) -> None:
    """The command that compares simulated with real pieces; what is alike by construction is."""
    found = run_bench("realism.py", shared)
    wheels = found["wheel"]["simulated"], found["wheel"]["real CMU C.0"]
    for name in ("smallest step (mm)", "rate (Hz)"):
        assert wheels[0][name] == pytest.approx(wheels[1][name], rel=0.02)
    shaken = found["IMU"]["simulated"]
    # A one-sided density, so sqrt(2) of the two-sided one that a standard deviation goes by.
    assert shaken["gyro at rest (/√Hz)"] == pytest.approx(1.61e-4 * 1.41, rel=0.2)
    for name, line in found["radar"].items():
        assert 0.02 < line["decorrelates over (m)"] < 1.0, name
