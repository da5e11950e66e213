"""Left and right wheels through the whole estimator, on simulated robots."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from conftest import run_cli
from gprodom import Odometry
from gprodom.config import STANDARD
from gprodom.doctor.radar import by_distance
from gprodom.errors import Error
from gprodom.ground.survey import shipped
from gprodom.lcm import logs
from gprodom.lcm.constants import flag, kind
from gprodom.odometry.replay import run_replay
from gprodom.simulate import Simulated
from gprodom.simulate.drives import robot_drive
from gprodom.simulate.recording import side_distances
from gprodom.simulate.robot import KINDS
from gprodom.simulate.wheel import trigger

GAP_S = 10.0


def run(
    simulated: Simulated,
    *settings: str,
    gap_from: float = np.inf,
    until: float = np.inf,
    sides: bool = True,
):
    """What the estimator makes of it until then (s), the IMU silent for `GAP_S` from `gap_from` (s)
    on."""
    seconds = (simulated.imu_utime - simulated.imu_utime[0]) * 1e-6
    heard = (seconds < until) & ((seconds < gap_from) | (seconds > gap_from + GAP_S))
    rolled = simulated.wheel_utime <= simulated.imu_utime[heard][-1]
    distance = side_distances(simulated)[rolled]
    estimator = Odometry(set=["gpr.enabled=false", "graph.enabled=false", *settings])
    return estimator.run(
        simulated.imu_utime[heard] * 1000,
        simulated.imu.acceleration[heard],
        simulated.imu.angular_velocity[heard],
        simulated.wheel_utime[rolled] * 1000,
        distance if sides else distance.mean(axis=1),
        np.zeros(0, np.int64),
        np.zeros((0, 0), np.float32),
    )


def error(simulated: Simulated, outputs) -> float:
    """RMS of the position (m), in the frame of the first pose."""
    odometry = outputs.odometry
    utime = odometry["time"] // 1000
    true = simulated.position_from(int(utime[0]), utime)
    return float(np.sqrt(np.mean(np.sum((odometry["position"][:, :2] - true) ** 2, axis=1))))


def values(outputs) -> dict[str, float]:
    """The newest figures of the status."""
    return outputs.status[-1]["values"]


DIFFERENTIAL = KINDS["cart"].settings


def test_ten_seconds_without_imu() -> None:
    """Left and right carry the heading: at most four times the error of a drive without a gap."""
    clean, gap, single = [], [], []
    for seed in range(4):
        simulated = robot_drive(seed, "cart")
        begin = 40.0 + 5 * seed
        clean.append(error(simulated, run(simulated, *DIFFERENTIAL)))
        gap.append(error(simulated, run(simulated, *DIFFERENTIAL, gap_from=begin)))
        single.append(error(simulated, run(simulated, gap_from=begin)))
    assert np.mean(gap) < 4 * np.mean(clean)
    assert np.mean(gap) < 0.25 * np.mean(single)


def test_track_and_radii_are_learnt_and_the_next_run_goes_on_with_them(tmp_path: Path) -> None:
    pair = replace(KINDS["cart"].pair, track_sigma=0.05, radii_sigma=0.02)
    simulated = robot_drive(7, "cart", pair=pair)
    kept = (*DIFFERENTIAL, f"state.directory={tmp_path}", "state.resume_within=0")
    learnt = values(run(simulated, *kept))
    track = simulated.pair.track * simulated.pair.scale
    assert abs(learnt["wheels.track_m"] - track) < 3 * learnt["wheels.track_sigma_m"]
    assert learnt["wheels.track_sigma_m"] < 0.02 * track
    assert learnt["wheels.radii_difference"] == pytest.approx(simulated.pair.radii, abs=0.005)
    # Runs that only stand.
    again, other = (
        values(run(simulated, *kept, *more, until=4.0)) for more in ((), ("wheel.track=0.6",))
    )
    assert again["wheels.track_m"] == pytest.approx(learnt["wheels.track_m"], abs=1e-9)
    assert again["wheels.radii_difference"] == learnt["wheels.radii_difference"]
    assert again["wheels.track_sigma_m"] < 0.3 * 0.05 * learnt["wheels.track_m"]
    assert other["wheels.track_m"] == 0.6


def test_effective_track_of_a_skid_steer_is_wider_than_the_geometric_one() -> None:
    simulated = robot_drive(3, "skid_steer")
    told = values(run(simulated, *KINDS["skid_steer"].settings))
    track = simulated.pair.track * simulated.pair.scale
    assert track > 1.6 * 1.08
    assert abs(told["wheels.track_m"] - track) < 3 * told["wheels.track_sigma_m"] < 0.15 * track


def test_one_side_that_slips_is_gone_by() -> None:
    simulated = robot_drive(11, "cart", slips=8)
    pair = run(simulated, *DIFFERENTIAL)
    assert np.any(pair.odometry["flags"] & (256 | 512))
    trusted = run(simulated, "wheel.slip_threshold=0")
    assert error(simulated, pair) < 0.2 * error(simulated, trusted)


def test_single_uses_the_mean_and_a_pair_takes_precedence() -> None:
    simulated = robot_drive(5, "cart")
    pair, mean = run(simulated), run(simulated, sides=False)
    np.testing.assert_array_equal(pair.odometry["position"], mean.odometry["position"])
    estimator = Odometry()
    estimator.add_imu(1_000_000_000, [0.0, 0.0, 9.8], [0.0, 0.0, 0.0])
    estimator.add_wheels(1_010_000_000, 0.0, 0.0)
    estimator.add_wheel(1_020_000_000, 0.0)
    assert any("messages of left and right wheels" in text for text in estimator.step().warnings)


# gpr.trigger: traces that the wheel makes, one each so many centimetres and none at a stop, on
# each ground that the simulator has, with slip.


GROUNDS = ("rays", *shipped())
SPACING = 0.02  # m
ROLES = STANDARD.of("odometry", "odometry_map", "displacement", "status")
DRIVES: dict[str, list[str]] = {
    "stops": ["--route", "stops", "--slips", "4"],
    "lasting slip": ["--route", "line", "--lasting", "ramps"],
    "two sides": ["--route", "line", "--robot", "cart", "--surface", "gravel", "--slips", "3"],
}


def simulated(folder: Path, *options: str, spacing: float = SPACING) -> Path:
    log = folder / "drive.lcmlog"
    more = ["--trigger-distance", str(spacing)] if spacing else []
    run_cli("simulate", "--seed", "11", *options, *more, "-o", log)
    return log


def replayed(log: Path, *settings: str) -> dict[str, Any]:
    """The estimate's messages by role."""
    output = log.with_name("out.lcmlog")
    run_replay(log, output, (), list(settings))
    return logs.read_roles(output, ROLES)


def error_m(found: dict[str, Any], log: Path) -> float:
    """RMS of the position in map, against the truth at its begin."""
    truth = np.load(log.with_suffix(".truth.npz"))
    pose = found["odometry_map"]
    seconds = (pose["utime"] - 1_700_000_000_000_000) * 1e-6
    there = np.column_stack([np.interp(seconds, truth["t"], truth[axis]) for axis in "xy"])
    yaw = float(np.interp(seconds[0], truth["t"], truth["yaw"]))
    turn = np.array([[np.cos(yaw), np.sin(yaw)], [-np.sin(yaw), np.cos(yaw)]])
    there = (there - there[0]) @ turn.T
    off = pose["position"][:, :2] - pose["position"][0, :2] - there
    return float(np.sqrt(np.mean(np.sum(off**2, axis=1))))


def told(found: dict[str, Any]) -> set[str]:
    """All reasons and names of counts of STATUS."""
    statuses = found["status"]["messages"]
    return {text for each in statuses for text in (*each.reasons, *each.names)}


def by_distance_of(found: dict[str, Any]) -> float:
    """What STATUS says of it at the end."""
    last = found["status"]["messages"][-1]
    return float(dict(zip(last.names, last.values, strict=True))["radar.by_distance"])


@pytest.mark.usefixtures("compiled")
@pytest.mark.parametrize("drive", DRIVES)
@pytest.mark.parametrize("ground", GROUNDS)
def test_traces_by_distance_are_no_trouble_and_revisits_are_found(
    ground: str, drive: str, tmp_path: Path
) -> None:
    log = simulated(tmp_path, "--ground", ground, *DRIVES[drive])
    sensors = logs.read_roles(log, STANDARD.of("gpr_trace", "wheel", "wheels"))
    assert by_distance(sensors), "the doctor knows such a log"
    robot = ["wheel.drive=differential", "wheel.track=0.5"] if drive == "two sides" else []
    without = replayed(log, "gpr.enabled=false", *robot)
    found = {way: replayed(log, f"gpr.trigger={way}", *robot) for way in ("distance", "auto")}
    for way, each in found.items():
        trouble = ("no data", "gap in traces", "gap: messages lost", "is reset", "immobilised")
        of_radar = {text for text in told(each) if not text.startswith(("IMU", "WHEEL"))}
        assert not [text for text in of_radar if any(word in text for word in trouble)], way
        assert not np.any(each["odometry"]["flags"] & flag("NO_RADAR")), way
        kinds = each["displacement"]["kind"]
        assert set(kinds.tolist()) == {kind("REVISIT")}, f"{way}: nothing of motion"
        assert np.count_nonzero(each["displacement"]["valid"]) >= 3, way
        # Standstills are seen by IMU and wheel, as without a radar.
        standing, as_known = (
            np.mean((one["odometry"]["flags"] & flag("STANDING")) != 0) for one in (each, without)
        )
        assert standing == pytest.approx(as_known, abs=0.01)
        assert error_m(each, log) < 1.1 * error_m(without, log) + 0.02, way
    assert by_distance_of(found["auto"]) == 1.0
    both = [error_m(found[way], log) for way in ("distance", "auto")]
    assert both[0] == pytest.approx(both[1], abs=0.02)


@pytest.mark.usefixtures("compiled")
def test_auto_is_time_where_traces_come_by_time(tmp_path: Path) -> None:
    """From the standstill at the start on, it is the same estimate."""
    log = simulated(tmp_path, *DRIVES["stops"], spacing=0)
    auto, time = replayed(log, "gpr.trigger=auto"), replayed(log)
    assert by_distance_of(auto) == 0.0
    assert "radar.by_distance" not in told(time)
    np.testing.assert_allclose(
        auto["odometry_map"]["position"], time["odometry_map"]["position"], atol=0.02
    )
    assert kind("MOTION") in auto["displacement"]["kind"]


@pytest.mark.usefixtures("compiled")
def test_what_contradicts_it_is_refused(tmp_path: Path) -> None:
    log = simulated(tmp_path, *DRIVES["stops"])
    with pytest.raises(Error, match="tell no speed"):
        replayed(log, "gpr.trigger=distance", "gpr.coherence.use=always")


def test_the_wheel_makes_a_trace_each_so_many_centimetres_either_way() -> None:
    t = np.linspace(0, 10, 501)
    counted = np.where(t < 4, 0.1 * t, np.where(t < 7, 0.4, 0.4 - 0.1 * (t - 7)))
    times = trigger(t, counted, 0.05)
    at = np.interp(times, t, counted)
    np.testing.assert_allclose(at, [*np.arange(0, 0.41, 0.05), *np.arange(0.35, 0.09, -0.05)])
    assert not np.any((times > 4.01) & (times < 7.01))


def test_simulated_traces_come_by_the_wheel_with_its_slip(tmp_path: Path) -> None:
    log = simulated(tmp_path, *DRIVES["stops"])
    content = logs.read_roles(log, STANDARD.of("gpr_trace", "wheel"))
    time, wheel = content["gpr_trace"]["utime"], content["wheel"]
    counted = np.interp(time, wheel["utime"], wheel["ticks"] * wheel["metres_per_tick"])
    np.testing.assert_allclose(np.abs(np.diff(counted)), SPACING, atol=1e-3)
    assert json.loads(log.with_suffix(".json").read_text())["spec"]["radar"]["spacing"] == SPACING
    for wrong in ("0.001", "2", "-1"):
        arguments = ["simulate", f"--trigger-distance={wrong}", "-o", str(tmp_path / "x.lcmlog")]
        run_cli(*arguments, code=2)
