"""Fixes from bags and tables: their frame, quality and covariance, and what is told of them."""

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from conftest import Cli, run_cli
from gprodom.fixes.record import Fixes, Frame, Quality, read_fixes
from gprodom.fixes.ros import fixes_of, read_fix
from gprodom.fixes.trust import CODES

CHANNEL = "POSITION_FIX"
T0 = 1_700_000_000
NAVSAT, POSE = "sensor_msgs/msg/NavSatFix", "geometry_msgs/msg/PoseWithCovarianceStamped"
COUNT = 3000  # of the IMU's messages at 100 Hz


def navsat(status: int, covariance: Any, kind: int, latitude: float = 52.0) -> Any:
    return SimpleNamespace(
        latitude=latitude,
        longitude=13.0,
        altitude=40.0,
        status=SimpleNamespace(status=status),
        position_covariance=np.asarray(covariance, float).ravel(),
        position_covariance_type=kind,
    )


def pose(variance: float, heading_variance: float, yaw: float, norm: float = 1.0) -> Any:
    covariance = np.diag([variance, variance, 4 * variance, 1, 1, heading_variance])
    turned = SimpleNamespace(x=0.0, y=0.0, z=norm * np.sin(yaw / 2), w=norm * np.cos(yaw / 2))
    at = SimpleNamespace(position=SimpleNamespace(x=1.0, y=2.0, z=3.0), orientation=turned)
    return SimpleNamespace(pose=SimpleNamespace(pose=at, covariance=covariance.ravel()))


def made(kind: str, *messages: Any, quality: Quality | None = None) -> Any:
    values = [read_fix(message, kind) for message in messages]
    return fixes_of("/fix", kind, np.arange(len(values)), values, 0, quality)


def test_the_status_of_a_navsatfix_is_its_quality(capsys: pytest.CaptureFixture[str]) -> None:
    good, fair = np.diag([4e-4, 4e-4, 1e-3]), np.diag([0.04, 0.09, 0.2])
    q = Quality
    told = ((-1, fair, 2), (0, fair, 2), (1, good, 2), (2, good, 2), (2, fair, 2), (2, good, 0))
    expected = [q.NONE, q.SINGLE, q.SINGLE, q.FIXED, q.FLOAT, q.FLOAT, q.NONE]
    found = made(NAVSAT, *(navsat(*each) for each in told), navsat(0, fair, 2, np.nan))
    assert found.quality.tolist() == expected
    assert found.frame == Frame.GEODETIC
    assert np.isfinite(found.position).all()
    np.testing.assert_array_equal(found.covariance[4], fair)
    # The sixth has a fine covariance whose type is unknown: not believed, and told.
    np.testing.assert_allclose(np.diag(found.covariance[5]), [1, 1, 4])
    said = capsys.readouterr().err
    assert "/fix: 1 of 7 fixes do not tell their covariance" in said
    assert "quality float" in said


def test_a_pose_is_in_site_and_has_a_heading() -> None:
    found = made(POSE, pose(1e-4, 0.01, 0.7), pose(1.0, 0.0, 0.7), pose(1.0, 0.01, 0.7, norm=0.5))
    assert found.frame == Frame.SITE
    assert found.quality.tolist() == [Quality.FIXED, Quality.FLOAT, Quality.FLOAT]
    assert found.heading[0] == pytest.approx(0.7)
    assert found.heading_sigma[0] == pytest.approx(0.1)
    assert np.isnan(found.heading[1:]).all()  # a sigma of 0; a quaternion that is none
    np.testing.assert_array_equal(found.position[0], [1, 2, 3])
    marked = made(POSE, pose(1.0, 0.0, 0.7), quality=Quality.SURVEYED)
    assert marked.quality.tolist() == [Quality.SURVEYED]


def test_zeros_are_no_covariance(capsys: pytest.CaptureFixture[str]) -> None:
    found = made(POSE, pose(0.0, 0.0, 0.0))
    np.testing.assert_allclose(np.diag(found.covariance[0]), [1, 1, 4])
    assert "1 m is taken" in capsys.readouterr().err


def drive(folder: Path) -> list[str]:
    """Tables of IMU and wheel, and the arguments that convert them."""
    rng = np.random.default_rng(2)
    t = T0 + np.arange(COUNT) * 0.01
    imu = np.column_stack([t, rng.normal([0, 0, 9.81, 0, 0, 0], 0.02, (COUNT, 6))])
    np.savetxt(folder / "imu.csv", imu, "%.6f", ",")
    np.savetxt(folder / "w.csv", np.column_stack([t, np.zeros(COUNT)])[::5], "%.6f", ",")
    return ["--imu", str(folder / "imu.csv"), "--wheel-speed", str(folder / "w.csv")]


def command(folder: Path, rows: Any, *arguments: str) -> list[object]:
    """What converts those tables and one of fixes, once a second."""
    times = T0 + 1.0 + np.arange(len(rows))[:, None]
    np.savetxt(folder / "fix.csv", np.hstack([times, rows]), "%.9f", ",")
    given = [*drive(folder), "--fix", folder / "fix.csv", *arguments]
    return ["convert", "tables", *given, "-o", folder / "o.lcmlog"]


def converted(folder: Path, rows: Any, *arguments: str) -> Fixes:
    run_cli(*command(folder, rows, *arguments))
    [found] = read_fixes(folder / "o.lcmlog", CHANNEL)
    return found


def test_tables_with_standard_deviations_and_a_quality(tmp_path: Path) -> None:
    rows = [[52, 13, 40, 0.02, 0.03, 0.05, 4], [52.1, 13, 40, 1, 2, 3, 5], [0, 0, 0, 0, 0, 0, 0]]
    found = converted(tmp_path, rows, "--fix-unit", "degrees", "--fix-quality-code", "nmea")
    assert found.frame == Frame.GEODETIC
    assert found.quality.tolist() == [Quality.FIXED, Quality.FLOAT, Quality.NONE]
    np.testing.assert_allclose(found.position[:2], [[52, 13, 40], [52.1, 13, 40]])
    np.testing.assert_allclose(np.diag(found.covariance[1]), [1, 4, 9])
    assert found.utime[0] == (T0 + 1) * 1_000_000
    assert np.isnan(found.heading).all()


def test_tables_with_a_covariance_and_by_numbers_of_columns(tmp_path: Path) -> None:
    rows = [[1, 2, 3, 4e-4, 1e-4, 0, 9e-4, 0, 1e-2], [2, 2, 3, 4, 0, 0, 9, 0, 16]]
    found = converted(tmp_path, rows)
    assert found.frame == Frame.SITE
    expected = [[4e-4, 1e-4, 0], [1e-4, 9e-4, 0], [0, 0, 1e-2]]
    np.testing.assert_allclose(found.covariance[0], expected)
    assert found.quality.tolist() == [Quality.FIXED, Quality.FLOAT]
    found = converted(tmp_path, rows, "--fix-columns", "1-4", "--fix-sigma", "0.5")
    np.testing.assert_allclose(found.covariance[0], 0.25 * np.eye(3))


@pytest.mark.parametrize(
    ("row", "options", "said"),
    [
        ([1, 2, 3], (), "how good are the fixes?"),
        ([1, 2, 3, 7], (), "quality 7: expected one of 0, 1, 2, 3, 4"),
        ([113, 52, 3, 3], ("--fix-unit", "degrees"), "latitude and longitude in degrees"),
        ([1, 2, 3, 0.1, 0.0, 0.1], (), "standard deviations of 0"),
        ([1, 2, 3, 1, 3, 0, 1, 0, 1], (), "a covariance that is none"),
    ],
)
def test_tables_that_are_refused(
    row: list[float], options: tuple[str, ...], said: str, tmp_path: Path, cli: Cli
) -> None:
    assert said in cli.error(*command(tmp_path, [row, row], *options))


def test_every_code_has_only_our_qualities() -> None:
    for codes in CODES.values():
        assert set(codes.values()) <= set(Quality)
        assert codes[0] is Quality.NONE


def test_bags_give_fixes_of_what_is_named(tmp_path: Path, cli: Cli) -> None:
    """The same topic can be truth as well; other types are refused."""
    pytest.importorskip("rosbags")
    from test_convert_bags import bag, write_drive

    path = tmp_path / "drive.bag"
    with bag(path, "ros1") as (types, put):
        header = write_drive(types, put, "ros1", ())
        for i in range(5):
            time = T0 * 1_000_000_000 + i * 200_000_000
            fix = types[NAVSAT](
                header(time),
                types["sensor_msgs/msg/NavSatStatus"](status=0, service=1),
                52 + 1e-6 * i, 13.0, 40.0, np.diag([1.0, 1.0, 4.0]).ravel(), 2,
            )  # fmt: skip
            for topic in ("/front", "/rear"):
                put(topic, NAVSAT, fix, time)
    log = tmp_path / "o.lcmlog"
    given = ["convert", "bag", str(path), "-o", str(log), "--wheel-radius", "0.1"]
    chosen = ["--truth", "/rear", "--fix", "/front", "--fix", "/rear"]
    cli(*given, *chosen, "--fix-quality", "fixed")
    front, rear = read_fixes(log, CHANNEL)
    assert (front.antenna, rear.antenna, len(front), len(rear)) == (0, 1, 5, 5)
    assert set(rear.quality) == {Quality.FIXED}
    cli(*given, "--truth", "none")
    assert read_fixes(log, CHANNEL) == []
    said = cli.error(*given, "--truth", "none", "--fix", "/imu")
    assert "/imu is sensor_msgs/msg/Imu; expected sensor_msgs/msg/NavSatFix" in said
