"""Fixes made from truth: their noise, their faults, and logs that they are added to."""

from pathlib import Path

import numpy as np
import pytest

from gprodom.fixes import made
from gprodom.fixes.made import CENTIMETRES, DATUM, ENDS, METRES, Noise
from gprodom.fixes.record import Fixes, Frame, Quality, read_fixes
from gprodom.lcm import EventLog, logs
from gprodom.lcm.log_writer import Stream, write_log
from gprodom.lcm.wire import encode
from gprodom.trajectory import Trajectory

pytest.importorskip("pyproj")

SECOND = 1_000_000


def truth(seconds: int = 200) -> Trajectory:
    """Straight on at 1 m/s, which stands for the first 20 s; 10 Hz."""
    t = np.arange(10 * seconds)
    x = np.maximum(0.1 * t - 20, 0.0)
    return Trajectory(t * SECOND // 10, np.column_stack([x, 0 * x, 0 * x]))


def test_noise_is_as_large_and_as_long_as_told() -> None:
    utime = np.arange(200_000) * 200_000  # 40,000 s at 5 Hz
    white, slow = (made.errors(utime, noise, 1) for noise in (CENTIMETRES, METRES))
    np.testing.assert_allclose(white.std(axis=0), [0.03, 0.03, 0.06], rtol=0.02)
    assert abs(np.corrcoef(white[:-1, 0], white[1:, 0])[0, 1]) < 0.02
    np.testing.assert_allclose(slow[:, :2].std(axis=0), 1.0, rtol=0.15)
    after = np.corrcoef(slow[:-500, 0], slow[500:, 0])[0, 1]  # 100 s apart
    assert after == pytest.approx(np.exp(-1), abs=0.15)
    np.testing.assert_array_equal(slow, made.errors(utime, METRES, 1))
    assert (slow != made.errors(utime, METRES, 2)).all()


def test_fixes_of_the_ends_of_the_way() -> None:
    fixes = made.fixes_of_truth(truth(), Noise(0.0), 1, interval_s=1.0)
    assert len(fixes) == 200
    ends = fixes.select(made.within(made.share_of_way(truth(), fixes.utime), ENDS))
    x = ends.position[:, 0]
    assert ((x <= 18.5) | (x >= 161.5)).all()
    assert np.count_nonzero(x < 18.5) == pytest.approx(38, abs=1)  # the standstill is in it
    assert np.count_nonzero(x > 161.5) == pytest.approx(18, abs=1)


def local(fixes: Fixes) -> np.ndarray:
    return DATUM.to_local(fixes.position)[:, :2]


@pytest.mark.parametrize("fault", made.FAULTS)
def test_a_fault_is_there_while_it_lasts_and_no_longer(fault: str) -> None:
    fixes = made.fixes_of_truth(truth(), Noise(1e-9), 1, interval_s=1.0)
    begin, end = 80 * SECOND, 120 * SECOND
    faulty = made.with_fault(fixes, fault, begin, end, 3)
    assert faulty.frame == Frame.GEODETIC
    healthy = made.in_degrees(fixes)
    before, after = fixes.utime < begin, fixes.utime >= end
    np.testing.assert_allclose(local(faulty)[before], local(healthy)[before], atol=1e-6)
    if fault != "datum":
        np.testing.assert_allclose(local(faulty)[after], local(healthy)[after], atol=1e-6)
    inside = np.flatnonzero(~before & ~after)
    off = np.linalg.norm(local(faulty) - local(healthy), axis=1)[inside]
    lost = faulty.quality[inside] == Quality.NONE
    if fault == "outage":
        assert lost.all()
    elif fault == "reacquisition":
        assert lost[:20].all() and not lost[20:].any()
        assert off[20] == pytest.approx(made.WALK_M) and off[-1] < 0.4 * made.WALK_M
    elif fault == "swapped":
        assert (off > 1e5).all()
    else:
        last = {"jump": 3, "drag_1": 0.39, "drag_10": 3.9, "replay": 30, "datum": 147.05}[fault]
        assert off[-1] == pytest.approx(last, abs=0.01)


def test_fixes_are_added_to_a_log_where_they_belong(tmp_path: Path) -> None:
    before, after = tmp_path / "a.lcmlog", tmp_path / "b.lcmlog"
    utime = np.arange(0, 10) * SECOND
    ticks = {"utime": utime, "ticks": np.arange(10), "metres_per_tick": 1.0}
    write_log(before, [Stream("WHEEL", utime, encode("wheel_t", ticks, 10))])
    fixes = made.fixes_of_truth(truth(20), CENTIMETRES, 1, interval_s=3.0)
    made.add_to_log(before, after, [fixes.stream("POSITION_FIX")])
    stamps = [event.timestamp for event in EventLog(str(after), "r")]
    assert stamps == sorted(stamps) and len(stamps) == 10 + len(fixes)
    [found] = read_fixes(after, "POSITION_FIX")
    np.testing.assert_array_equal(found.position, fixes.position)
    np.testing.assert_array_equal(found.covariance, fixes.covariance)
    np.testing.assert_array_equal(logs.read(after)["WHEEL"]["ticks"], np.arange(10))
    assert read_fixes(before, "POSITION_FIX") == []
