"""Scores and pictures of logs: frames, covariances, jumps of `map`, flags, observability."""

from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure

from conftest import Cli, line, run_cli
from gprodom.calibrate.k import Shifts
from gprodom.lcm import EventLog
from gprodom.lcm.constants import kind
from gprodom.plot.observability import measure, observe, pool
from gprodom.score.answered import answered
from packets import correction, packet, pose, write_events

START = 1_700_000_000_000_000
JUMP_AT, JUMP_M = 12.0, 0.5


@pytest.fixture
def log(tmp_path: Path) -> Path:
    """20 s along x at 0.5 m/s in `odom`; after 12 s a correction moves `map` by 0.5 m along y.

    The truth agrees with `odom` but for a place and heading of its own. Standing in the first 4 s.
    """
    events = []
    for i in range(1001):
        seconds = 0.02 * i
        utime = START + 20_000 * i
        moved, standing = seconds >= JUMP_AT, seconds < 4
        x = 0.5 * max(seconds - 4, 0)
        if abs(seconds - JUMP_AT) < 1e-9:
            events.append((utime, "CORRECTION", correction(utime, 0.0, JUMP_M)))
        motion = {"velocity": [0.0 if standing else 0.5, 0.0, 0.0], "flags": int(standing)}
        for channel, y in (("ODOMETRY", 0.0), ("ODOMETRY_MAP", JUMP_M * moved)):
            events.append((utime, channel, pose(utime, x, y, 0.01, **motion)))
        ticks = round(1000 * x)
        events.append(
            (utime, "WHEEL", packet("wheel_t", utime=utime, ticks=ticks, metres_per_tick=0.001))
        )
        if i % 5 == 0:
            truth = packet("position_truth_t", utime=utime, position=[3.0, 2.0 + x, 1.0])
            events.append((utime, "TOTAL_STATION", truth))
    return write_events(tmp_path / "out.lcmlog", events)


def score(log: Path, cli: Cli, *options: str) -> dict[str, float]:
    figures: dict[str, float] = cli.json("score", log, log, *options)
    return figures


def test_map_is_scored_as_published_with_its_jump(log: Path, cli: Cli) -> None:
    figures = score(log, cli, "--align", "first")
    assert figures["map_jumps"] == 1
    assert figures["map_jump_max_m"] == pytest.approx(JUMP_M)
    assert figures["end_m"] == pytest.approx(JUMP_M, abs=1e-6)
    assert figures["nees_xy"] > 3  # 0.5 m of error, variance 0.01 m^2; the placing takes a part
    assert figures["nees_yaw"] is None  # truth of points


def test_odom_does_not_jump(log: Path, cli: Cli) -> None:
    figures = score(log, cli, "--align", "first", "--frame", "odom")
    assert figures["ate_rmse_m"] == pytest.approx(0, abs=1e-9)
    assert figures["map_jumps"] is None


def test_a_log_without_poses_says_what_to_give(log: Path, tmp_path: Path, cli: Cli) -> None:
    bare = [
        (event.timestamp, event.channel, event.data)
        for event in EventLog(str(log), "r")
        if event.channel in ("WHEEL", "TOTAL_STATION")
    ]
    write_events(tmp_path / "bare.lcmlog", bare)
    assert "gprodom run" in cli.error("score", tmp_path / "bare.lcmlog", log)


def test_plot_log_tells_the_flags(log: Path, tmp_path: Path, cli: Cli, drawn: list[Figure]) -> None:
    picture = tmp_path / "log.png"
    assert cli.json("plot", "log", log, "--wheel", log, "-o", picture)["flags"][
        "standing"
    ] == pytest.approx(0.2, abs=0.01)
    [figure] = drawn
    assert picture.is_file()
    speed, position, heading, flags = figure.axes
    for name in ("wheel", "estimate"):  # 4 s of standstill, then 0.5 m/s
        seconds, drawn_speed = line(speed, name)
        np.testing.assert_allclose(drawn_speed[seconds < 3.5], 0.0, atol=1e-9)
        np.testing.assert_allclose(drawn_speed[seconds > 4.5], 0.5, atol=0.01)
    styles = [each.get_linestyle() for each in speed.get_lines()]
    assert len(set(styles)) == len(styles) == 2  # told apart without colour
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
    run_cli(*arguments)
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
