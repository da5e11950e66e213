"""The pose in map on simulated drives over ground seen again; statistics: bench/map_coverage.py."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

import gprodom

BENCH = Path(__file__).resolve().parents[2] / "bench" / "map_coverage.py"


@pytest.fixture(scope="module")
def bench() -> ModuleType:
    if not hasattr(gprodom, "Odometry"):
        pytest.skip("the extension gprodom._core is not built")
    spec = importlib.util.spec_from_file_location("map_coverage", BENCH)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


def error(bench: ModuleType, run: Any, poses: dict[str, Any]) -> float:
    """RMS of the position, once a second, where the truth is placed by its first pose."""
    every = np.append(0, np.arange(len(poses["time"]) // 2, len(poses["time"]), 200))
    off = poses["position"][every, :2] - bench.place(run, poses["time"][every])
    return float(np.sqrt(np.mean(np.sum(off[1:] ** 2, axis=1))))


@pytest.mark.parametrize("seed", [0, 1])
def test_revisits_help_and_wrong_ones_do_not_harm(bench: ModuleType, seed: int) -> None:
    run = bench.simulated(seed)
    [outputs] = bench.estimate(run, [], [])
    found = [told for told in outputs.displacements if told["source"] == "revisit"]
    assert len(found) > 30
    truth = run.motion_at(np.array([[t["from"], t["to"]] for t in found]).ravel() // 1000)
    apart = np.hypot(np.diff(truth.x)[::2], np.diff(truth.y)[::2])
    assert np.mean(apart < 0.1) > 0.98
    assert error(bench, run, outputs.odometry_map) < error(bench, run, outputs.odometry) + 0.01

    told = bench.wrong_revisits(run)
    *_, last = bench.estimate(run, [], told)
    values = last.status[-1]["values"]
    assert values["revisits.refused"] >= len(told)
    moved = last.odometry_map["position"][-1] - outputs.odometry_map["position"][-1]
    assert np.linalg.norm(moved) < 0.02


def test_without_ground_seen_again_map_is_odom(bench: ModuleType) -> None:
    run = bench.simulated(1)
    quarter = run.gpr_utime < run.gpr_utime[len(run.gpr_utime) // 6]
    estimator = gprodom.Odometry()
    until = run.gpr_utime[quarter][-1]
    imu, wheel = run.imu_utime < until, run.wheel_utime < until
    outputs = estimator.run(
        imu_time=run.imu_utime[imu] * 1000,
        acceleration=run.imu.acceleration[imu],
        angular_velocity=run.imu.angular_velocity[imu],
        wheel_time=run.wheel_utime[wheel] * 1000,
        wheel_distance=run.wheel.ticks[wheel] * run.spec.wheel.quantum,
        gpr_time=run.gpr_utime[quarter] * 1000,
        traces=run.traces[quarter],
    )
    assert outputs.corrections == []
    assert np.array_equal(outputs.odometry["position"], outputs.odometry_map["position"])


def test_the_solution_over_all_data_takes_revisits_in(bench: ModuleType) -> None:
    run = bench.simulated(0)
    smoothed = []
    for graph in ("true", "false"):
        estimator = gprodom.Odometry(set=[f"graph.enabled={graph}"])
        estimator.record()
        estimator.run(
            imu_time=run.imu_utime * 1000,
            acceleration=run.imu.acceleration,
            angular_velocity=run.imu.angular_velocity,
            wheel_time=run.wheel_utime * 1000,
            wheel_distance=run.wheel.ticks * run.spec.wheel.quantum,
            gpr_time=run.gpr_utime * 1000,
            traces=run.traces,
        )
        smoothed.append(estimator.smoothed())
    with_revisits, without = smoothed
    assert np.array_equal(with_revisits["time"], without["time"])
    moved = np.linalg.norm(with_revisits["position"] - without["position"], axis=1)
    assert 1e-4 < moved.max() < 0.3


def drive(estimator: Any, run: Any, shift: int = 0, wheel: float = 1.0, noise: float = 0.0) -> Any:
    """A whole drive, `shift` ns later than it was, by another wheel and with other noise."""
    random = np.random.RandomState(1)
    return estimator.run(
        imu_time=run.imu_utime * 1000 + shift,
        acceleration=run.imu.acceleration,
        angular_velocity=run.imu.angular_velocity,
        wheel_time=run.wheel_utime * 1000 + shift,
        wheel_distance=wheel * run.wheel.ticks * run.spec.wheel.quantum,
        gpr_time=run.gpr_utime * 1000 + shift,
        traces=run.traces + noise * random.standard_normal(run.traces.shape),
    )


@pytest.mark.parametrize("seed", [0, 1])
def test_after_a_reset_the_robot_is_located_on_the_ground_of_before(
    bench: ModuleType, tmp_path: Path, seed: int
) -> None:
    run = bench.simulated(seed)
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


def test_a_restart_goes_on_from_the_saved_pose(bench: ModuleType, tmp_path: Path) -> None:
    run = bench.simulated(1)
    kept = [f"state.directory={tmp_path}"]
    until = run.gpr_utime[len(run.gpr_utime) // 3]  # in mid-drive, and no slip
    outputs = []
    for part in (lambda t: t < until, lambda t: t > until + 2_000_000):  # two seconds are lost
        imu, wheel, gpr = part(run.imu_utime), part(run.wheel_utime), part(run.gpr_utime)
        outputs.append(
            gprodom.Odometry(set=kept).run(
                imu_time=run.imu_utime[imu] * 1000,
                acceleration=run.imu.acceleration[imu],
                angular_velocity=run.imu.angular_velocity[imu],
                wheel_time=run.wheel_utime[wheel] * 1000,
                wheel_distance=run.wheel.ticks[wheel] * run.spec.wheel.quantum,
                gpr_time=run.gpr_utime[gpr] * 1000,
                traces=run.traces[gpr],
            )
        )
    before, after = outputs
    assert any("resumed" in warning for warning in after.warnings)
    assert after.odometry["time"][0] <= (until + 2_050_000) * 1000  # at once, while driving
    moved = after.odometry["position"][400, :2] - before.odometry["position"][-1, :2]
    start, *between = (
        before.odometry["time"][0],
        before.odometry["time"][-1],
        after.odometry["time"][400],
    )
    truth = np.diff(bench.place(run, np.array([start, *between])), axis=0)[1]
    assert np.linalg.norm(moved - truth) < 0.3
