"""Left and right wheels through the whole estimator, on simulated robots."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from gprodom import Odometry
from gprodom.simulate import Simulated
from gprodom.simulate.drives import robot_drive
from gprodom.simulate.recording import side_distances
from gprodom.simulate.robot import KINDS

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
    warnings = estimator.step().warnings
    assert any("messages of left and right wheels" in text for text in warnings)
