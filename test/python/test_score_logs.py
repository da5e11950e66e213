"""Scores and pictures of logs: frames, covariances, jumps of `map`, flags, observability."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure

from conftest import line
from gprodom.calibrate.k import Shifts
from gprodom.cli import main
from gprodom.lcm import EventLog
from gprodom.lcm.constants import kind
from gprodom.lcm.messages import message
from gprodom.plot.observability import measure, observe, pool
from gprodom.score.answered import answered

START = 1_700_000_000_000_000
JUMP_AT, JUMP_M = 12.0, 0.5


@pytest.fixture
def log(tmp_path: Path) -> Path:
    """20 s along x at 0.5 m/s in `odom`; after 12 s a correction moves `map` by 0.5 m along y.

    The truth agrees with `odom` but for a place and heading of its own. Standing in the first 4 s.
    """
    path = tmp_path / "out.lcmlog"
    out = EventLog(str(path), "w", overwrite=True)
    for i in range(1001):
        seconds = 0.02 * i
        utime = START + 20_000 * i
        moved = seconds >= JUMP_AT
        x = 0.5 * max(seconds - 4, 0)
        if abs(seconds - JUMP_AT) < 1e-9:
            out.write_event(utime, "CORRECTION", correction(utime))
        for channel, y in (("ODOMETRY", 0.0), ("ODOMETRY_MAP", JUMP_M * moved)):
            out.write_event(utime, channel, odometry(utime, x, y, standing=seconds < 4))
        wheel = message("wheel_t")()
        wheel.utime, wheel.ticks, wheel.metres_per_tick = utime, round(1000 * x), 0.001
        out.write_event(utime, "WHEEL", wheel.encode())
        if i % 5 == 0:
            truth = message("position_truth_t")()
            truth.utime, truth.position = utime, [3.0, 2.0 + x, 1.0]
            out.write_event(utime, "TOTAL_STATION", truth.encode())
    out.close()
    return path


def correction(utime: int) -> bytes:
    sent = message("correction_t")()
    sent.utime, sent.position, sent.orientation = utime, [0.0, JUMP_M, 0.0], [1.0, 0.0, 0.0, 0.0]
    sent.covariance = [0.0] * 36
    data: bytes = sent.encode()
    return data


def odometry(utime: int, x: float, y: float, standing: bool) -> bytes:
    sent = message("odometry_t")()
    sent.utime, sent.frame = utime, "map"
    sent.position, sent.orientation = [x, y, 0.0], [1.0, 0.0, 0.0, 0.0]
    sent.velocity = [0.0 if standing else 0.5, 0.0, 0.0]
    sent.pose_covariance = (0.01 * np.eye(6)).ravel().tolist()
    sent.flags = 1 if standing else 0
    data: bytes = sent.encode()
    return data


def score(log: Path, capsys: pytest.CaptureFixture[str], *options: str) -> dict[str, float]:
    assert main(["score", str(log), str(log), "--json", *options]) == 0
    figures: dict[str, float] = json.loads(capsys.readouterr().out)
    return figures


def test_map_is_scored_as_published_with_its_jump(
    log: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    figures = score(log, capsys, "--align", "first")
    assert figures["map_jumps"] == 1
    assert figures["map_jump_max_m"] == pytest.approx(JUMP_M)
    assert figures["end_m"] == pytest.approx(JUMP_M, abs=1e-6)
    assert figures["nees_xy"] > 3  # 0.5 m of error, variance 0.01 m^2; the placing takes a part
    assert figures["nees_yaw"] is None  # truth of points


def test_odom_does_not_jump(log: Path, capsys: pytest.CaptureFixture[str]) -> None:
    figures = score(log, capsys, "--align", "first", "--frame", "odom")
    assert figures["ate_rmse_m"] == pytest.approx(0, abs=1e-9)
    assert figures["map_jumps"] is None


def test_a_log_without_poses_says_what_to_give(
    log: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    bare = tmp_path / "bare.lcmlog"
    out = EventLog(str(bare), "w", overwrite=True)
    for event in EventLog(str(log), "r"):
        if event.channel in ("WHEEL", "TOTAL_STATION"):
            out.write_event(event.timestamp, event.channel, event.data)
    out.close()
    assert main(["score", str(bare), str(log)]) == 1
    assert "gprodom run" in capsys.readouterr().err


def test_plot_log_tells_the_flags(
    log: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], drawn: list[Figure]
) -> None:
    picture = tmp_path / "log.png"
    assert main(["plot", "log", str(log), "--wheel", str(log), "-o", str(picture), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["flags"]["standing"] == pytest.approx(0.2, abs=0.01)
    [figure] = drawn
    assert picture.is_file()
    speed, position, heading, flags = figure.axes
    for name in ("wheel", "estimate"):  # 4 s of standstill, then 0.5 m/s
        seconds, drawn_speed = line(speed, name)
        np.testing.assert_allclose(drawn_speed[seconds < 3.5], 0.0, atol=1e-9)
        np.testing.assert_allclose(drawn_speed[(seconds > 4.5) & (seconds < 19)], 0.5, atol=0.01)
    for axis, sigma in ((position, np.sqrt(0.02)), (heading, np.degrees(0.1))):
        np.testing.assert_allclose(axis.get_lines()[0].get_ydata(), sigma)
    bars = [np.vstack([path.vertices for path in each.get_paths()] or [np.zeros((0, 2))])
            for each in flags.collections]  # fmt: skip
    assert [len(bar) > 0 for bar in bars] == [True] + [False] * (len(bars) - 1)
    assert (bars[0][:, 0].min(), bars[0][:, 0].max()) == pytest.approx((0.0, 4.0), abs=0.03)
    assert flags.get_yticklabels()[0].get_text() == "standing"


def test_plot_trajectory(log: Path, tmp_path: Path, drawn: list[Figure]) -> None:
    picture = tmp_path / "paths.png"
    arguments = ["plot", "trajectory", str(log), "--truth", str(log), "-o", str(picture)]
    assert main(arguments) == 0
    [figure] = drawn
    assert picture.is_file()
    truth, estimate = line(figure.axes[0], "truth"), line(figure.axes[0], "estimate")
    np.testing.assert_allclose(truth, [np.full(len(truth[0]), 3.0), truth[1]])
    assert np.ptp(truth[1]) == pytest.approx(8.0)
    # Aligned to it: off by the jump of map, of which the fit takes a part.
    assert 0.05 < np.linalg.norm(estimate - truth, axis=0).max() < JUMP_M


def test_observability_distinguishes_a_constant_from_a_measurement() -> None:
    """One front end sees the motion, forwards and back; the other always the same shift."""
    rng = np.random.default_rng(5)
    n = 200
    time = START + 500_000 * np.arange(n + 1)
    step = rng.uniform(-0.3, 0.3, n)
    wheel = np.concatenate([[0.0], np.cumsum(step)])
    distance = np.abs(step)
    distance[7] = np.nan  # without truth

    def windows(shift: np.ndarray) -> object:
        return observe(Shifts(time[:-1], time[1:], shift, distance), time, wheel)

    constant = measure(pool([windows(np.full(n, -5.0))]))  # type: ignore[list-item]
    seeing = measure(pool([windows(step / 0.02)]))  # type: ignore[list-item]
    assert (constant.windows, constant.commonest_shift, constant.commonest_share) == (199, -5, 1.0)
    assert constant.correlation is None
    assert constant.residual_rms_m == pytest.approx(constant.constant_rms_m, rel=0.1)
    assert seeing.correlation == pytest.approx(1)
    assert seeing.k == pytest.approx(0.02)
    assert seeing.residual_rms_m == pytest.approx(0, abs=1e-9)
    assert seeing.displacement_min_m == pytest.approx(step.min())


def test_answers_cover_the_time_once() -> None:
    """Overlaps count once, revisits and invalid ones not at all, what lies outside is cut off."""
    seconds = [(0, 2), (1, 3), (1, 2), (5, 6), (9, 12), (0, 10), (4, 5)]
    kinds = [kind("MOTION")] * 5 + [kind("REVISIT"), kind("MOTION")]
    told = {
        "utime_from": 1_000_000 * np.array([begin for begin, _ in seconds]),
        "utime_to": 1_000_000 * np.array([end for _, end in seconds]),
        "kind": np.array(kinds),
        "valid": np.array([True] * 6 + [False]),
    }
    poses = np.arange(0, 10_000_001, 100_000)
    found = answered(told, poses)
    assert found is not None
    assert found.share == pytest.approx((3 + 1 + 1) / 10)
    assert found.revisits == 1
    assert answered(None, poses) is None
