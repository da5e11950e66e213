"""Exported estimates, read back by the libraries of other programs."""

import json
import sqlite3
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest
import yaml

from conftest import Cli, rows_of, run_cli
from gprodom.convert.streams import gpr_stream
from gprodom.fixes.made import add_to_log
from gprodom.fixes.site import ORIGIN
from gprodom.geodesy import Datum
from gprodom.lcm.log_writer import Stream, write_log
from gprodom.lcm.logs import read
from packets import packet, status

START = 1_700_000_000_000_000
COUNT = 50  # poses, ten a second
DATUM = "52.3906,13.0645,40,90"  # x points north
INTERVAL = 3.125e-10  # s


def position(seconds: np.ndarray) -> np.ndarray:
    """The path (n, 3), m: straight ahead at 2 m/s, up by 0.1 m/s."""
    return np.column_stack([2.0 * seconds, 0.0 * seconds, 0.1 * seconds])


def orientation(seconds: np.ndarray) -> np.ndarray:
    """Along it (n, 4), w, x, y, z: turning about an axis of its own."""
    half = 0.1 * seconds[:, None]
    return np.hstack([np.cos(half), np.sin(half) * [0.48, -0.6, 0.64]])


def more() -> list[Stream]:
    """A status, an estimate in odom a bit off the one in map, and a correction."""
    place = {"position": [1 / 3, -2 / 7, 0.125], "orientation": [0.8, 0.0, 0.0, 0.6]}
    pose = packet("odometry_t", utime=START + 1, frame="odom", velocity=[0.5, 0.0, 0.0], **place)
    place = {"position": [0.1, 0.2, 0.3], "orientation": [0.6, 0.0, 0.0, 0.8]}
    sent = {
        "STATUS": status(START, {"solver.mean_ms": 1.5}, 1, ["no radar"]),
        "ODOMETRY": pose,
        "CORRECTION": packet("correction_t", utime=START + 2, **place),
    }
    return [
        Stream(name, np.array([START + i]), [data]) for i, (name, data) in enumerate(sent.items())
    ]


@pytest.fixture
def log(tmp_path: Path) -> Path:
    """An estimate, and traces at 20 Hz that begin a second before it."""
    time = START + 100_000 * np.arange(COUNT)
    seconds = (time - START) * 1e-6
    covariance = np.diag([0.01, 0.02, 0.06, 0, 0, 0]).ravel().tolist()
    common = {"frame": "map", "pose_covariance": covariance}
    path = zip(
        time.tolist(), position(seconds).tolist(), orientation(seconds).tolist(), strict=True
    )
    poses = [
        packet("odometry_t", utime=utime, position=place, orientation=turn, **common)
        for utime, place, turn in path
    ]
    traces = START - 1_000_000 + 50_000 * np.arange(60)
    samples = np.random.default_rng(1).integers(-30000, 30000, (60, 16))
    radar = gpr_stream("GPR_TRACE", traces, samples, INTERVAL, 0.0)
    write_log(tmp_path / "out.lcmlog", [Stream("ODOMETRY_MAP", time, poses), radar, *more()])
    return tmp_path / "out.lcmlog"


def export(log: Path, option: str, *more: object) -> Path:
    """The file that the option makes."""
    path = log.parent / f"made.{option}"
    run_cli("export", log, f"--{option}", path, *more)
    return path


def check_fixes(fixes: np.ndarray) -> None:
    """Longitude and latitude of the first and the last pose: 9.8 m to the north."""
    np.testing.assert_allclose(fixes[0, :2], [13.0645, 52.3906], atol=1e-8)
    metre = 1 / 111_271.0  # degrees of latitude there
    np.testing.assert_allclose(fixes[-1, :2], [13.0645, 52.3906 + 9.8 * metre], atol=1e-8)


def test_geojson(log: Path) -> None:
    pytest.importorskip("pyproj")
    content = json.loads(export(log, "geojson", "--datum", DATUM).read_text())
    (feature,) = content["features"]
    assert (content["type"], feature["geometry"]["type"]) == ("FeatureCollection", "LineString")
    fixes = np.array(feature["geometry"]["coordinates"])
    assert fixes.shape == (COUNT, 3)
    check_fixes(fixes)
    assert fixes[-1, 2] - fixes[0, 2] == pytest.approx(0.49, abs=1e-3)
    assert feature["properties"]["times"][1] == "2023-11-14T22:13:20.100000+00:00"


def test_the_datum_that_the_log_tells(log: Path) -> None:
    """An estimate that fixes have tied to site needs no --datum, and --datum goes before it."""
    pytest.importorskip("pyproj")
    tied = log.parent / "tied.lcmlog"
    told = status(START, dict(zip(ORIGIN, (52.3906, 13.0645, 40.0), strict=True)))
    add_to_log(log, tied, [Stream("STATUS", np.array([START]), [told])])
    bare = export(tied, "geojson").read_text()
    assert bare == export(tied, "geojson", "--datum", "52.3906,13.0645,40").read_text()
    assert bare != export(tied, "geojson", "--datum", DATUM).read_text()
    assert "latitude" in rows_of(export(tied, "csv"))[0]


def test_geojson_in_a_gis_library(log: Path) -> None:
    """By GDAL, where it is installed: in the package's tests it is."""
    ogr = pytest.importorskip("osgeo.ogr")
    pytest.importorskip("pyproj")
    source = ogr.Open(str(export(log, "geojson", "--datum", DATUM)))
    assert source.GetLayerCount() == 1
    layer = source.GetLayer(0)
    assert layer.GetSpatialRef().GetAuthorityCode(None) in ("4326", "4979")  # without, with height
    (feature,) = list(layer)
    path = feature.GetGeometryRef()
    assert path.GetGeometryName() == "LINESTRING"
    check_fixes(np.array(path.GetPoints()))
    assert path.GetPointCount() == COUNT


def test_gpx(log: Path) -> None:
    pytest.importorskip("pyproj")
    gpxpy = pytest.importorskip("gpxpy")
    (track,) = gpxpy.parse(export(log, "gpx", "--datum", DATUM).read_text()).tracks
    points = track.segments[0].points
    check_fixes(np.array([[p.longitude, p.latitude] for p in points]))
    assert points[1].time.timestamp() == pytest.approx(START * 1e-6 + 0.1)


def test_csv(log: Path) -> None:
    rows = rows_of(export(log, "csv"))
    assert list(rows[0]) == ["time", "x", "y", "z", "qw", "qx", "qy", "qz", "sigma"]
    np.testing.assert_allclose([float(row["x"]) for row in rows], 0.2 * np.arange(COUNT))
    assert rows[3]["time"] == "1700000000.300000"
    assert float(rows[0]["sigma"]) == pytest.approx(0.3)


def test_csv_with_a_datum(log: Path) -> None:
    pytest.importorskip("pyproj")
    rows = rows_of(export(log, "csv", "--datum", DATUM))
    check_fixes(np.array([[float(row["longitude"]), float(row["latitude"])] for row in rows]))


def test_a_row_for_each_trace(log: Path, cli: Cli) -> None:
    """The traces before the first pose are left out, and counted."""
    said = cli("export", log, "--traces", log.with_name("traces")).out
    assert "40 traces, 20 traces without pose" in said
    rows = rows_of(log.with_name("traces"))
    np.testing.assert_allclose([float(row["x"]) for row in rows], 0.1 * np.arange(40), atol=1e-9)
    assert rows[1]["time"] == "1700000000.050000"
    assert {row["antenna_id"] for row in rows} == {"0"}


def test_segy(log: Path) -> None:
    segyio = pytest.importorskip("segyio")
    with segyio.open(str(export(log, "segy")), ignore_geometry=True) as file:
        assert file.tracecount == 40
        np.testing.assert_array_equal(file.trace.raw[:], read(log)["GPR_TRACE"]["samples"][20:])
        header = file.header[21]
        assert header[segyio.TraceField.SourceGroupScalar] == -100
        assert header[segyio.TraceField.SourceX] == 210  # cm, after 1.05 s
        assert header[segyio.TraceField.ReceiverGroupElevation] == 10  # 10.5, rounded to even
        assert header[segyio.TraceField.TRACE_SAMPLE_INTERVAL] == 312  # ps
        assert header[segyio.TraceField.SecondOfMinute] == 21
        assert file.bin[segyio.BinField.Interval] == 312
        assert b"3.125e-10 s" in bytes(file.text[0])


def test_mcap_by_another_reader(log: Path) -> None:
    """The same poses, with stamps, frames and covariances."""
    pytest.importorskip("rosbags")
    pytest.importorskip("mcap_ros2")
    from mcap_ros2.reader import read_ros2_messages

    found: dict[str, list] = {}
    for each in read_ros2_messages(str(export(log, "mcap"))):
        found.setdefault(each.channel.topic, []).append(each.ros_msg)
    assert {topic: len(each) for topic, each in found.items()} == {
        "/gprodom/odometry_map": COUNT, "/gprodom/odometry": 1, "/gprodom/path": 1, "/tf": 2,
        "/diagnostics": 1, "/gprodom/path_odom": 1, "/gprodom/pose": COUNT, "/gprodom/standing": 1,
        "/gprodom/slipping": 1,
    }  # fmt: skip
    poses, seconds = found["/gprodom/odometry_map"], 0.1 * np.arange(COUNT)
    both = [(p.pose.pose.position, p.pose.pose.orientation) for p in poses]
    got = np.array([[p.x, p.y, p.z, q.w, q.x, q.y, q.z] for p, q in both])
    expected = np.hstack([position(seconds), orientation(seconds)])
    np.testing.assert_allclose(got, expected, rtol=0, atol=1e-9)
    assert poses[1].header.stamp.nanosec == 100_000_000
    assert (poses[0].header.frame_id, poses[0].child_frame_id) == ("map", "base_link")
    assert poses[0].pose.covariance[7] == 0.02
    (odom,) = found["/gprodom/odometry"]
    assert (odom.pose.pose.position.x, odom.pose.pose.orientation.z) == (1 / 3, 0.6)
    assert odom.twist.twist.linear.x == 0.5
    assert [t.transforms[0].header.frame_id for t in found["/tf"]] == ["odom", "map"]
    assert len(found["/gprodom/path"][0].poses) == COUNT
    assert found["/diagnostics"][0].status[0].message == "no radar"


def test_a_ros2_bag_is_a_folder_of_tables(log: Path, cli: Cli) -> None:
    """As SQLite itself reads it, beside its description; a folder that is there stays as it is."""
    pytest.importorskip("rosbags")
    made = export(log, "rosbag2")
    about = yaml.safe_load((made / "metadata.yaml").read_text())["rosbag2_bagfile_information"]
    assert (about["version"], about["storage_identifier"]) == (8, "sqlite3")
    assert about["relative_file_paths"] == ["made.rosbag2.db3"]
    # Of odometry_map and pose, and one or two of others.
    assert about["message_count"] == 2 * COUNT + 8
    with closing(sqlite3.connect(made / "made.rosbag2.db3")) as tables:
        rows = tables.execute(
            "SELECT topics.name, type, serialization_format, COUNT(*), MIN(timestamp) "
            "FROM messages JOIN topics ON topics.id = topic_id GROUP BY topics.name"
        ).fetchall()
    found = {name: rest for name, *rest in rows}
    assert found["/gprodom/odometry_map"] == ["nav_msgs/msg/Odometry", "cdr", COUNT, START * 1000]
    before = sorted(path.stat().st_mtime_ns for path in made.iterdir())
    assert "exists already" in cli.error("export", log, "--rosbag2", made, code=2)
    assert sorted(path.stat().st_mtime_ns for path in made.iterdir()) == before


@pytest.mark.parametrize("kind", ["mcap", "rosbag", "rosbag2"])
def test_recordings_for_ros(kind: str, log: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Read back by rosbags; the radar is a picture."""
    highlevel = pytest.importorskip("rosbags.highlevel")
    monkeypatch.setattr("gprodom.export.messages.SCAN_TRACES", 20)
    made = export(log, kind)
    if kind == "rosbag":
        made = made.rename(made.with_suffix(".bag"))
    with highlevel.AnyReader([made]) as reader:
        found = {c.topic: reader.deserialize(raw, c.msgtype) for c, _, raw in reader.messages()}
    assert found["/gprodom/odometry_map"].pose.pose.position.x == pytest.approx(9.8)
    assert found["/diagnostics"].status[0].level == 1
    scan = found["/gprodom/bscan"]
    assert (scan.height, scan.width, scan.encoding) == (16, 20, "mono8")
    assert len(scan.data) == 320


def test_there_and_back() -> None:
    pytest.importorskip("pyproj")
    datum = Datum(-33.9, 151.2, 12.0, 30.0)
    places = np.random.default_rng(1).normal(0, 500, (20, 3))
    np.testing.assert_allclose(datum.to_local(datum.to_geographic(places)), places, atol=1e-6)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ([], "nothing to do"),
        (["--gpx", "a.gpx"], "want --datum"),
        (["--geojson", "a", "--datum", "95,0"], "expected LAT,LON"),
    ],
)
def test_bad_usage(arguments: list[str], said: str, log: Path, cli: Cli) -> None:
    assert said in cli.error("export", log, *arguments, code=2)
