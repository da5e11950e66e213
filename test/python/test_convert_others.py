"""Conversion of bags, tables and survey files: real ones, and small ones made here."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from conftest import Cli
from dzt_file import dzt_file
from gprodom.convert.survey_files import read_line
from gprodom.convert.wheels import WheelSpec, added_up, along_poses, read_wheel, wheel_streams
from gprodom.errors import Error
from gprodom.geodesy import local_positions
from gprodom.ground.survey import read_survey
from gprodom.lcm.log_writer import Stream
from gprodom.lcm.logs import read
from gprodom.lcm.wire import decode
from ids_file import ids_file
from test_convert_tables import table

HUSKY = ("--imu", "/imu/data", "--wheel", "/husky_velocity_controller/odom", "--truth", "/fix")


def test_husky(shared: Path, tmp_path: Path, cli: Cli) -> None:
    """A rotated IMU, no standstill at the start: wheel and gyro within 3.1 m of the GPS."""
    log = tmp_path / "husky.lcmlog"
    bag = shared / "robots" / "husky.bag"
    channels = cli.json("convert", "bag", bag, "-o", log, *HUSKY)["channels"]
    counts = {name: channel["count"] for name, channel in channels.items()}
    assert counts == {"IMU": 11865, "WHEEL": 3952, "TOTAL_STATION": 989}
    score = cli.json("run", log, "--method", "wheel", "--truth", log)
    assert score["ate_rmse_m"] < 3.1
    assert score["excluded"] == 0
    said = cli.error("convert", "bag", bag, "-o", log, "--wheel", "/imu/data")
    assert "expected nav_msgs/msg/Odometry" in said


def test_car(shared: Path, tmp_path: Path, cli: Cli) -> None:
    """Scale fitted on the first half: distance of the second within 0.5 %."""
    car, log = shared / "robots" / "car", tmp_path / "car.lcmlog"
    names = ("accelerometer", "gyroscope", "wheel-speed", "position")
    tables = [f"--{name}={car / name.replace('-', '_')}.csv" for name in names]
    cli.json("convert", "tables", *tables, "-o", log)
    (rest,) = cli.json("calibrate", "wheel", log, "--fit-share", "0.5")["rest"]
    assert abs(rest["error_after_pct"]) < 0.5 < abs(rest["error_before_pct"])


def test_wheel_distance_of_poses_and_speeds() -> None:
    time = np.arange(5) * 1_000_000
    angle = np.arange(5) * 0.5
    arc = np.column_stack([2 * np.sin(angle), 2 - 2 * np.cos(angle), angle])
    chord = 4 * np.sin(0.25)
    np.testing.assert_allclose(along_poses(arc), chord * np.arange(5), atol=1e-12)
    back = arc + [0, 0, np.pi]
    np.testing.assert_allclose(along_poses(back)[-1], -4 * chord, atol=1e-12)
    speeds = np.array([0.0, 1.0, 1.0, -1.0, 0.0])
    np.testing.assert_allclose(added_up(time, speeds), [0, 0.5, 1.5, 1.5, 1.0])


def pair(streams: list[Stream]) -> tuple[np.ndarray, np.ndarray]:
    """Distances (m) of left and right in the one stream, which is of two sides."""
    (stream,) = streams
    assert stream.channel == "WHEELS"
    fields = decode("wheels_t", stream.payloads, "here")
    return tuple(fields[f"{side}_ticks"] * fields["metres_per_tick"] for side in ("left", "right"))


def test_two_sides_of_joints() -> None:
    """Two wheels a side, whose mean counts; a message of other joints says nothing."""
    spec = WheelSpec(radius=0.1, left=("fl", "rl"), right=("fr",))
    names = ["fr", "arm", "fl", "rl"]
    joints = [SimpleNamespace(name=names, position=[3.0 * k, 9.0, k, 1.5 * k]) for k in range(3)]
    kind = "sensor_msgs/msg/JointState"
    rows = [read_wheel(message, kind, spec) for message in joints]
    left, right = pair(wheel_streams(np.arange(3) * 1_000_000, rows, spec))
    np.testing.assert_allclose(left, [0, 0.125, 0.25])
    np.testing.assert_allclose(right, [0, 0.3, 0.6])
    assert read_wheel(SimpleNamespace(name=["arm"], position=[1.0]), kind, spec) is None


def test_two_sides_of_an_odometry() -> None:
    """On a circle of 2 m to the left the right side goes further by the track times the turn."""
    spec = WheelSpec(track=0.5)
    rows = []
    for angle in np.arange(5) * 0.1:
        pose = SimpleNamespace(
            position=SimpleNamespace(x=2 * np.sin(angle), y=2 - 2 * np.cos(angle)),
            orientation=SimpleNamespace(w=np.cos(angle / 2), x=0, y=0, z=np.sin(angle / 2)),
        )
        twist = SimpleNamespace(angular=SimpleNamespace(z=0.1))
        message = SimpleNamespace(
            pose=SimpleNamespace(pose=pose), twist=SimpleNamespace(twist=twist)
        )
        rows.append(read_wheel(message, "nav_msgs/msg/Odometry", spec))
    left, right = pair(wheel_streams(np.arange(5) * 1_000_000, rows, spec))
    np.testing.assert_allclose(right[-1] - left[-1], 0.5 * 0.4, atol=2e-5)
    np.testing.assert_allclose(0.5 * (left + right)[-1], 2 * 0.4, rtol=1e-3)
    (single,) = wheel_streams(np.arange(5) * 1_000_000, rows, WheelSpec())
    assert single.channel == "WHEEL"


def test_two_sides_of_tables(tmp_path: Path, cli: Cli) -> None:
    time, sensors = 0.02 * np.arange(101), []
    for name, values in (
        ("accelerometer", [0, 0, 9.8]),
        ("gyroscope", [0, 0, 0]),
        ("wheel-speed", [1, 2, 3, 4]),
    ):
        header, columns = "t,a,b,c,d"[: 1 + 2 * len(values)], np.tile(values, (len(time), 1))
        file = table(tmp_path / f"{name}.csv", header, 1_700_000_000 + time, columns)
        sensors += [f"--{name}", file]
    log = tmp_path / "pair.lcmlog"
    convert = ["convert", "tables", *sensors, "-o", log]
    cli(*convert, "--left", "1,3", "--right", "2,4")
    wheels = read(log)["WHEELS"]
    np.testing.assert_allclose(wheels["left_ticks"] * wheels["metres_per_tick"], 2 * time)
    np.testing.assert_allclose(wheels["right_ticks"] * wheels["metres_per_tick"], 3 * time)
    cli(*convert, "--left", "1,3", code=2)
    cli(*convert, "--left", "1", "--right", "5", code=2)


def test_local_positions() -> None:
    """An arc second of latitude at the equator and at the pole; longitude by its parallel."""
    pytest.importorskip("pyproj")
    second = 1 / 3600
    near = local_positions(np.array([[0.0, 10.0, 5.0], [second, 10.0 + second, 6.0]]))
    np.testing.assert_allclose(near[1], [30.922, 30.715, 1.0], atol=2e-3)
    north = local_positions(np.array([[60.0, 0.0, 0.0], [60.0 + second, second, 0.0]]))
    np.testing.assert_allclose(north[1], [15.500, 30.950, 0.0], atol=5e-3)


def test_real_survey_files(shared: Path) -> None:
    files = shared / "survey_files"
    beach = read_line(files / "beach_0001_0.iprb")
    with np.load(shared / "real_ground" / "seal_beach" / "line_01.npz") as known:
        np.testing.assert_array_equal(beach.traces, known["traces"])
        assert beach.spacing == pytest.approx(float(known["spacing"]))
        assert beach.sample_interval == pytest.approx(3.125e-10)
    yosemite = read_line(files / "YosemiteData.DT1")
    assert yosemite.traces.shape == (531, 1500)
    assert (yosemite.spacing, yosemite.sample_interval) == pytest.approx((0.6096, 8e-10))
    dune = read_line(shared / "real_ground" / "dune" / "DuneData.DZT")
    assert dune.traces.shape == (1040, 512)
    assert dune.spacing == pytest.approx(0.02)
    # A direct wave, the same everywhere, as real ground begins.
    for line in (yosemite, dune):
        mean = line.traces.mean(axis=0)
        assert np.abs(mean).max() > 3 * np.std(line.traces[:, -100:])


def test_real_ids_files(shared: Path, tmp_path: Path, cli: Cli) -> None:
    """Their headers contradict themselves: told with what the echoes say; the options decide."""
    paths = [str(shared / "survey_files" / f"LID1000{i}.dt") for i in (1, 2)]
    command = ["convert", "survey", *paths, "--aside", "0.1", "-o", str(tmp_path / "wall.npz")]
    said = cli.error(*command)
    assert "260.417 traces a metre (3.84 mm)" in said and "nominal step of 4 mm" in said
    said = cli.error(*command, "--spacing", "0.004")
    assert "echoes of 2.4 or 0.24 GHz, of an antenna of 3 GHz" in said
    assert "--sample-interval" in said
    facts = cli.json(*command, "--spacing", "0.004", "--sample-interval", "2.34375e-11")
    assert (facts["lines"], facts["traces"], facts["samples"]) == (2, 443, 512)
    assert (facts["spacing_m"], facts["sample_interval_s"]) == pytest.approx((0.004, 2.34375e-11))


def test_ids_file_is_read_or_refused(tmp_path: Path) -> None:
    path = tmp_path / "l.dt"
    traces = np.random.default_rng(1).integers(-3000, 3000, (5, 128))
    path.write_bytes(ids_file(traces))
    line = read_line(path)
    np.testing.assert_array_equal(line.traces, traces)
    assert (line.spacing, line.sample_interval) == pytest.approx((0.02, 2e-10))
    assert not any(line.contradictions.values())
    for data, said in (
        (ids_file(traces)[:-7], "cut short"),
        (ids_file(traces, counted=6), "header counts 6 traces, the file holds 5"),
        (ids_file(traces, channels=2), "2 channels"),
        (ids_file(traces[:, :64]), "cannot hold the 64 samples"),
        (b"H" + ids_file(traces)[1:], "does not begin with a row V"),
        (ids_file(traces).replace(b"    2.000000E-10", b"    0.000000E+00"), "number 10 of row H"),
    ):
        path.write_bytes(data)
        with pytest.raises(Error, match=said):
            read_line(path)


def write_mala(path: Path, traces: np.ndarray, **changes: str) -> Path:
    header = {"SAMPLES": "64", "FREQUENCY": "5000.0", "DISTANCE INTERVAL": "0.05"} | changes
    text = "".join(f"{key}:{value}\r\n" for key, value in header.items())
    path.with_suffix(".rad").write_text(text)
    traces.astype("<i2").tofile(path)
    return path


def test_survey_lines_become_ground(tmp_path: Path, cli: Cli) -> None:
    lines = np.random.default_rng(1).integers(-3000, 3000, (2, 100, 64))
    paths = [str(write_mala(tmp_path / f"l{i}.rd3", line)) for i, line in enumerate(lines)]
    out = tmp_path / "field.npz"
    arguments = ["convert", "survey", *paths, "--aside", "0.3", "--samples", "50", "-o", str(out)]
    assert cli.json(*arguments)["length_m"] == pytest.approx(4.95)
    survey = read_survey(out)
    np.testing.assert_array_equal(survey.lines, lines[:, :, :50])
    assert not survey.closed
    assert survey.sample_interval == pytest.approx(2e-10)
    seen = survey.traces(np.array([0.05, 4.95]), np.array([0.0, 0.3]))
    np.testing.assert_allclose(seen, [lines[0, 1, :50], lines[1, 99, :50]], atol=1e-2)
    with pytest.raises(Error, match=r"ends after 4\.95 m"):
        survey.traces(np.array([6.0]), np.array([0.0]))
    drive = ["simulate", "--ground", str(out), "--distance", "8", "--standstill", "1"]
    cli(*drive, "-o", tmp_path / "s.zip")


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"SAMPLES": "many"}, "expected a number"),
        ({"SAMPLES": "0"}, "expected 2 to"),
        ({"DISTANCE INTERVAL": "0"}, "no spacing"),
        ({"SAMPLES": "5000"}, "at least two traces"),
        ({"SAMPLES": "20000"}, "expected 2 to 16384"),  # no longer than the estimator takes
    ],
)
def test_survey_errors(tmp_path: Path, changes: dict[str, str], said: str) -> None:
    path = write_mala(tmp_path / "l.rd3", np.zeros((10, 64)), **changes)
    with pytest.raises(Error, match=said):
        read_line(path)


def test_survey_that_is_cut_short(tmp_path: Path) -> None:
    """Fewer traces than the header counts, or a part of one; more than it counts are all read."""
    traces = np.zeros((10, 64), np.int16)
    with pytest.raises(Error, match="header counts 11 traces, the file holds 10"):
        read_line(write_mala(tmp_path / "l.rd3", traces, **{"LAST TRACE": "11"}))
    path = write_mala(tmp_path / "l.rd3", traces, **{"LAST TRACE": "9"})
    assert len(read_line(path).traces) == 10
    with (tmp_path / "l.rd3").open("ab") as file:
        file.write(b"abc")
    with pytest.raises(Error, match="after 10 traces of 128 bytes there are 3 bytes more"):
        read_line(tmp_path / "l.rd3")
    (tmp_path / "l.iprb").write_bytes(traces.tobytes())
    text = (tmp_path / "l.rad").read_text()
    (tmp_path / "l.iprh").write_text(text.replace("LAST TRACE:9", "LAST TRACE: 12"))
    with pytest.raises(Error, match="header counts 12 traces"):
        read_line(tmp_path / "l.iprb")
    head = "NUMBER OF TRACES = 7\nNUMBER OF PTS/TRC = 64\nTOTAL TIME WINDOW = 50\n"
    (tmp_path / "l.hd").write_text(head + "STEP SIZE USED = 0.1\n")
    (tmp_path / "l.dt1").write_bytes(bytes(6 * (128 + 128)))
    with pytest.raises(Error, match="header counts 7 traces"):
        read_line(tmp_path / "l.dt1")


def test_dzt_with_a_part_of_a_trace(tmp_path: Path) -> None:
    path, whole = tmp_path / "l.dzt", dzt_file(np.zeros((1, 5, 64)), (50.0,))
    path.write_bytes(whole)
    assert len(read_line(path).traces) == 5
    path.write_bytes(whole + bytes(60))
    with pytest.raises(Error, match="cut short"):
        read_line(path)


def test_survey_too_coarse_for_its_wavelength(tmp_path: Path, cli: Cli) -> None:
    """Echoes of 500 MHz, 20 cm long in the ground: said at 10 cm between traces, not at 2 cm."""
    rng = np.random.default_rng(1)
    wave = np.sin(2 * np.pi * 500e6 * np.arange(64) * 2e-10)
    traces = 3000 * rng.standard_normal((50, 1)) * wave
    for spacing, said in (("0.10", True), ("0.02", False)):
        path = write_mala(tmp_path / "l.rd3", traces, **{"DISTANCE INTERVAL": spacing})
        told = cli("convert", "survey", path, "-o", tmp_path / "g.npz").err
        assert ("wavelength of 0.2 m" in told) is said


def test_survey_wants_its_header(tmp_path: Path) -> None:
    (tmp_path / "a.dt1").write_bytes(b"x" * 4000)
    with pytest.raises(Error, match=r"a\.hd beside it"):
        read_line(tmp_path / "a.dt1")
    with pytest.raises(Error, match="unknown kind"):
        read_line(tmp_path / "a.sgy")
