"""The pose in map on simulated drives over ground seen again; statistics: bench/map_coverage.py."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gprodom
from gprodom.benchmark.monte_carlo import estimate_told
from gprodom.simulate.drives import drive_on_known_ground, wrong_revisits
from gprodom.simulate.recording import as_recording

pytestmark = pytest.mark.usefixtures("compiled")


def error(run: Any, poses: dict[str, Any]) -> float:
    """RMS of the position, once a second, where the truth is placed by its first pose."""
    every = np.append(0, np.arange(len(poses["time"]) // 2, len(poses["time"]), 200))
    time = poses["time"][every] // 1000
    off = poses["position"][every, :2] - run.position_from(time[0], time)
    return float(np.sqrt(np.mean(np.sum(off[1:] ** 2, axis=1))))


@pytest.mark.parametrize("seed", [0, 1])
def test_revisits_help_and_wrong_ones_do_not_harm(seed: int) -> None:
    run = drive_on_known_ground(seed)
    [outputs] = estimate_told(run)
    found = [told for told in outputs.displacements if told["source"] == "revisit"]
    assert len(found) > 30
    truth = run.motion_at(np.array([[t["from"], t["to"]] for t in found]).ravel() // 1000)
    apart = np.hypot(np.diff(truth.x)[::2], np.diff(truth.y)[::2])
    assert np.mean(apart < 0.1) > 0.98
    assert error(run, outputs.odometry_map) < error(run, outputs.odometry) + 0.01

    told = wrong_revisits(run)
    *_, last = estimate_told(run, told=told)
    values = last.status[-1]["values"]
    assert values["revisits.refused"] >= len(told)
    moved = last.odometry_map["position"][-1] - outputs.odometry_map["position"][-1]
    assert np.linalg.norm(moved) < 0.02


def test_without_ground_seen_again_map_is_odom() -> None:
    run = drive_on_known_ground(1)
    until = run.gpr_utime[len(run.gpr_utime) // 6]
    outputs = gprodom.Odometry().run(**as_recording(run).messages(until=until))
    assert outputs.corrections == []
    assert np.array_equal(outputs.odometry["position"], outputs.odometry_map["position"])


def test_the_solution_over_all_data_takes_revisits_in() -> None:
    run = drive_on_known_ground(0)
    smoothed = []
    for graph in ("true", "false"):
        estimator = gprodom.Odometry(set=[f"graph.enabled={graph}"])
        estimator.record()
        estimator.run(**as_recording(run).messages())
        smoothed.append(estimator.smoothed())
    with_revisits, without = smoothed
    assert np.array_equal(with_revisits["time"], without["time"])
    moved = np.linalg.norm(with_revisits["position"] - without["position"], axis=1)
    assert 1e-4 < moved.max() < 0.3


def drive(estimator: Any, run: Any, shift: int = 0, wheel: float = 1.0, noise: float = 0.0) -> Any:
    """A whole drive, `shift` ns later than it was, by another wheel and with other noise."""
    random = np.random.RandomState(1)
    told = as_recording(run).messages()
    for time in ("imu_time", "wheel_time", "gpr_time"):
        told[time] = told[time] + shift
    told["wheel_distance"] = wheel * told["wheel_distance"]
    told["traces"] = told["traces"] + noise * random.standard_normal(run.traces.shape)
    return estimator.run(**told)


@pytest.mark.parametrize("seed", [0, 1])
def test_after_a_reset_the_robot_is_located_on_known_ground(tmp_path: Path, seed: int) -> None:
    run = drive_on_known_ground(seed)
    estimator = gprodom.Odometry()
    first = drive(estimator, run)
    known = str(tmp_path / "ground.map")
    estimator.save_map(known)
    other = gprodom.Odometry()
    other.load_map(known)
    estimator.reset()
    for later, shift in ((estimator, 10**13), (other, -(10**13))):
        outputs = drive(later, run, shift, 1.01, 30.0)
        assert outputs.status[-1]["values"]["map.located"] == 1.0
        placed = outputs.odometry_map
        before = first.odometry_map
        end = [
            np.interp(placed["time"][-1] - shift, before["time"], before["position"][:, axis])
            for axis in (0, 1)
        ]
        assert np.hypot(*(placed["position"][-1, :2] - end)) < 0.2


def test_a_damaged_map_is_refused(tmp_path: Path) -> None:
    damaged = tmp_path / "damaged.map"
    damaged.write_bytes(b"gprodom ground map 1\n" + bytes(100))
    with pytest.raises(gprodom.FileError, match=r"damaged\.map"):
        gprodom.Odometry().load_map(str(damaged))


def test_a_restart_goes_on_from_the_saved_pose(tmp_path: Path) -> None:
    run = drive_on_known_ground(1)
    kept = [f"state.directory={tmp_path}"]
    until = run.gpr_utime[len(run.gpr_utime) // 3]  # in mid-drive, and no slip
    recording = as_recording(run)
    before, after = (
        gprodom.Odometry(set=kept).run(**recording.messages(*part))
        for part in ((0, until), (until + 2_000_000, 2**63 - 1))  # two seconds are lost
    )
    assert any("resumed" in warning for warning in after.warnings)
    # While driving, once a state is known that the IMU had a word in.
    assert after.odometry["time"][0] <= (until + 2_800_000) * 1000
    moved = after.odometry["position"][400, :2] - before.odometry["position"][-1, :2]
    start, last, later = (
        before.odometry["time"][0],
        before.odometry["time"][-1],
        after.odometry["time"][400],
    )
    places = run.position_from(start // 1000, np.array([last, later]) // 1000)
    truth = np.diff(places, axis=0)[0]
    assert np.linalg.norm(moved - truth) < 0.3
