"""Surveyed markers: their file, the fixes made of them, and residuals of an estimate."""

import re
from pathlib import Path

import numpy as np
import pytest

from conftest import Cli
from gprodom.config import STANDARD
from gprodom.errors import Error
from gprodom.fixes.made import add_to_log
from gprodom.fixes.markers import as_fixes, read_markers
from gprodom.fixes.record import Fixes, Frame, Quality, diagonal, read_fixes
from gprodom.fixes.site import ORIGIN, USED, datum_of_log
from gprodom.geodesy import Datum
from gprodom.lcm.log_writer import Stream, write_log
from gprodom.map.survey import compare, in_site
from gprodom.trajectory import Trajectory
from packets import packet, status

T0 = 1_700_000_000
SITE = """name, x, y, z, sigma, from, to, antenna
B, 10, 5, 0, 0.01, 1700000060, 1700000064, 0
A, 0, 0, 0, 0.02, 2023-11-14T22:13:30, 1700000014, 1
"""


def path(drift: float = 0.0, yaw: float = 0.0) -> Trajectory:
    """East at 1/6 m/s, which is `drift` m aside at its end; heading `yaw`."""
    t = np.linspace(0, 120, 1201)
    position = np.column_stack([t / 6, drift * t / 120, 0 * t])
    q = np.tile([np.cos(yaw / 2), 0, 0, np.sin(yaw / 2)], (len(t), 1))
    covariance = np.tile(0.0009 * np.eye(6), (len(t), 1, 1))
    return Trajectory((T0 * 1_000_000 + t * 1e6).astype(np.int64), position, q, covariance)


def test_markers_are_read_in_order_of_time(tmp_path: Path) -> None:
    file = tmp_path / "m.csv"
    file.write_text(SITE)
    first, second = read_markers(file)
    assert (first.name, first.antenna, first.middle) == ("A", 1, (T0 + 12) * 1_000_000)
    assert (second.name, second.position, second.sigma) == ("B", (10, 5, 0), 0.01)
    zero, one = as_fixes([first, second])
    assert (zero.antenna, one.antenna) == (0, 1)
    assert zero.quality.tolist() == [Quality.SURVEYED]
    np.testing.assert_allclose(one.covariance[0], 0.0004 * np.eye(3))


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (("name, x", "name, east"), "m.csv:1: expected columns"),
        (("antenna", "colour"), "m.csv:1: unknown column colour"),
        (("0.01", "nan"), "m.csv:2: sigma: expected a number"),
        (("0.01", "0"), "m.csv:2: sigma: expected a number from 0.0001 to 100"),
        (("1700000064", "1700000004"), "m.csv:2: expected `to` after `from`"),
        (("2023-11-14T22:13:30", "noon"), "m.csv:3: from: expected seconds"),
    ],
)
def test_markers_that_are_refused(change: tuple[str, str], said: str, tmp_path: Path) -> None:
    file = tmp_path / "m.csv"
    file.write_text(SITE.replace(*change))
    with pytest.raises(Error, match=re.escape(said)):
        read_markers(file)


def test_residuals_with_lever_arm_and_alignment(tmp_path: Path) -> None:
    file = tmp_path / "m.csv"
    file.write_text(SITE)
    markers = read_markers(file)
    places = in_site(markers, None)
    quarter = path(yaw=np.pi / 2)
    found = compare(quarter, markers, places, {1: (0.5, 0.0, 0.0)}, align=False)
    a, b = found.residuals
    # 12 s along, the antenna half a metre ahead of a robot that looks north; 62 s along.
    assert (a.x_m, a.y_m) == pytest.approx((2.0, 0.5), abs=1e-3)
    assert (b.x_m, b.y_m) == pytest.approx((62 / 6 - 10, -5), abs=1e-3)
    assert a.sigma_m == pytest.approx(np.hypot(0.03, 0.02), rel=1e-3)
    assert found.rms_m == pytest.approx(np.sqrt((a.off_m**2 + b.off_m**2) / 2))
    aligned = compare(quarter, markers, places, {}, align=True)
    apart = np.hypot(10, 5) - 50 / 6  # of the markers, less that of the path there
    assert aligned.rms_m == pytest.approx(apart / 2, abs=0.01)
    with pytest.raises(Error, match="none of the markers"):
        compare(path().select(np.arange(5)), markers, places, {}, align=False)


def test_the_command_adds_fixes_and_prints_residuals(tmp_path: Path, cli: Cli) -> None:
    file, log, tied = tmp_path / "m.csv", tmp_path / "a.lcmlog", tmp_path / "b.lcmlog"
    file.write_text(SITE)
    moving = path()
    poses = zip(moving.time, moving.position, moving.orientation, strict=True)
    payloads = [
        packet("odometry_t", utime=int(t), position=p.tolist(), orientation=q.tolist())
        for t, p, q in poses
    ]
    write_log(log, [Stream(STANDARD.odometry_map, moving.time, payloads)])
    cli("map", "survey", file, log, "--fixes", tied)
    assert [len(one) for one in read_fixes(tied, STANDARD.position_fix)] == [1, 1]
    picture = tmp_path / "r.png"
    facts = cli.json("map", "survey", file, log, "--picture", picture)
    assert [marker["name"] for marker in facts["markers"]] == ["A", "B"]
    assert facts["rms_m"] == pytest.approx(np.sqrt((2**2 + (1 / 3) ** 2 + 5**2) / 2), abs=0.01)
    assert picture.read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    ("values", "configured", "expected"),
    [
        (dict(zip(ORIGIN, (1.0, 2.0, 3.0), strict=True)), (7.0, 8.0, 9.0), Datum(1.0, 2.0, 3.0)),
        ({USED: 3.0}, (7.0, 8.0, 9.0), Datum(7.0, 8.0, 9.0)),
        ({USED: 3.0}, None, Datum(52.0, 13.0, 40.0)),
        ({USED: 0.0}, (7.0, 8.0, 9.0), None),
        ({}, None, None),
    ],
)
def test_the_datum_of_a_log(
    values: dict[str, float],
    configured: tuple[float, float, float] | None,
    expected: Datum | None,
    tmp_path: Path,
) -> None:
    """Not the first message, which has no position, but the first fix that has one."""
    log, both = tmp_path / "s.lcmlog", tmp_path / "both.lcmlog"
    utime = np.array([T0, T0 + 1]) * 1_000_000
    write_log(log, [Stream(STANDARD.status, utime, [status(int(t), values) for t in utime])])
    position = np.array([[0.0, 0, 0], [52, 13, 40], [53, 13, 40]])
    quality = np.array([Quality.NONE, Quality.SINGLE, Quality.FIXED], np.int64)
    time = T0 * 1_000_000 + np.arange(3)
    fixes = Fixes(time, Frame.GEODETIC, position, diagonal(np.ones((3, 3))), quality)
    add_to_log(log, both, [fixes.stream(STANDARD.position_fix)])
    assert datum_of_log(both, STANDARD, configured) == expected
    assert datum_of_log(log, STANDARD, configured, [both]) == expected
