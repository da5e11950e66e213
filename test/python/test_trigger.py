"""gpr.trigger: traces that the wheel makes, one each so many centimetres and none at a stop, on
each ground that the simulator has, with slip."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from conftest import run_cli
from gprodom.config import STANDARD
from gprodom.doctor.radar import by_distance
from gprodom.errors import Error
from gprodom.ground.survey import shipped
from gprodom.lcm import logs
from gprodom.lcm.constants import flag, kind
from gprodom.odometry.replay import run_replay
from gprodom.simulate.wheel import trigger

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
