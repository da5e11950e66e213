"""A robot's own tables, in any order and unit; refused if they are clearly something else."""

from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from conftest import CHECKOUT, Cli, run_cli
from gprodom.geodesy import Datum
from gprodom.lcm.logs import read

START = 1_700_000_000.0
SPAN = 40.0  # s
COUNTS = 5200.0  # per metre
G = 9.80665


def drive() -> dict[str, np.ndarray]:
    """Back and forth at up to 1 m/s with turns: columns of time and values, SI."""
    rng = np.random.default_rng(3)
    t = np.arange(0, SPAN, 0.01)
    speed = np.sin(2 * np.pi * t / 10)
    force = np.column_stack([np.gradient(speed, t), 0 * t, 0 * t + 9.81])
    rate = np.column_stack([0 * t, 0 * t, 0.5 * np.cos(2 * np.pi * t / 7)])
    distance = 10 / (2 * np.pi) * (1 - np.cos(2 * np.pi * t / 10))
    return {
        "time": START + t,
        "force": force + rng.normal(0, 0.02, force.shape),
        "rate": rate + rng.normal(0, 0.001, rate.shape),
        "speed": speed,
        "distance": distance,
        "traces": rng.integers(-900, 900, (len(t) // 5, 12)),
    }


def table(path: Path, header: str, *columns: Any, mark: str = ",") -> Path:
    """A CSV of columns (n,) or (n, m); times with microseconds."""
    lines = [mark.join(f"{value:.6f}" for value in row) for row in np.column_stack(columns)]
    path.write_text("\n".join([*([header] if header else []), *lines]) + "\n")
    return path


def three(folder: Path, **changes: np.ndarray) -> list[str]:
    """Tables of one sensor each, and the arguments that convert them."""
    made = drive() | changes
    t = made["time"]
    table(folder / "a.csv", "t,x,y,z", made.get("force_time", t), made["force"])
    table(folder / "g.csv", "t,x,y,z", made.get("rate_time", t), made["rate"])
    table(folder / "w.csv", "t,v", made.get("speed_time", t)[::3], made["speed"][::3])
    names = (("accelerometer", "a"), ("gyroscope", "g"), ("wheel-speed", "w"))
    return [text for name, file in names for text in (f"--{name}", str(folder / f"{file}.csv"))]


def convert(folder: Path, *arguments: object) -> dict[str, Any]:
    """The log that comes of it."""
    log = folder / "out.lcmlog"
    run_cli("convert", "tables", *arguments, "-o", log)
    return read(log)


def told(folder: Path, cli: Cli, *arguments: object) -> str:
    """What is said of tables that make a log."""
    said: str = cli("convert", "tables", *arguments, "-o", folder / "out.lcmlog").err
    return said


def refused(folder: Path, cli: Cli, *arguments: object, code: int = 1) -> str:
    """What is said of tables that make no log."""
    log = folder / "none.lcmlog"
    said = cli.error("convert", "tables", *arguments, "-o", log, code=code)
    assert not log.exists()
    return said


def wheel_of(log: dict[str, Any]) -> np.ndarray:
    """Its distance (m)."""
    return np.asarray(log["WHEEL"]["ticks"] * log["WHEEL"]["metres_per_tick"])


def test_tables_as_they_were(tmp_path: Path, cli: Cli) -> None:
    assert told(tmp_path, cli, *three(tmp_path)) == ""
    log, made = read(tmp_path / "out.lcmlog"), drive()
    np.testing.assert_allclose(log["IMU"]["linear_acceleration"], made["force"], atol=1e-6)
    np.testing.assert_allclose(wheel_of(log), made["distance"][::3], atol=5e-3)


def test_nothing_is_extrapolated(tmp_path: Path, cli: Cli) -> None:
    """Where the accelerometer ends or pauses there is no IMU; where it has a fifth, no log."""
    made = drive()
    n = len(made["time"])
    part = np.r_[0:1000, 1500 : int(0.9 * n)]
    arguments = three(tmp_path, force=made["force"][part], force_time=made["time"][part])
    assert "rows of the gyroscope are left out" in told(tmp_path, cli, *arguments)
    time = read(tmp_path / "out.lcmlog")["IMU"]["utime"] * 1e-6 - START
    assert time[-1] == pytest.approx(0.9 * SPAN, abs=0.02)
    assert not np.any((time > 10.0) & (time < 14.99))
    fifth = slice(0, n // 5)
    arguments = three(tmp_path, force=made["force"][fifth], force_time=made["time"][fifth])
    assert "8.0 s in common, of 40.0 s" in refused(tmp_path, cli, *arguments)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        (lambda d: {"force": d["force"] / G}, "--acceleration-unit g"),
        (lambda d: {"force": d["force"] - [0, 0, 9.81]}, "expected gravity"),
        (lambda d: {"rate": np.degrees(d["rate"])}, "--rate-unit deg/s"),
        (lambda d: {"speed": 3000 * d["speed"]}, "in counts"),
        (lambda d: {"speed": 40 * d["speed"]}, "where the accelerometer feels"),
        (lambda d: {"speed": np.linspace(0, 50, len(d["time"]))}, "is it a distance or a count"),
        (lambda d: {"time": d["time"] * 1e3}, "--time-unit"),
        (lambda d: {"force_time": d["time"] * 1e3}, "--time-unit ms"),
        (lambda d: {"speed_time": d["time"] * 1e9}, "--time-unit ns"),
        (lambda d: {"speed_time": (d["time"] - START) * 1e3}, "wheel: 0.0333 messages a second"),
        (lambda d: {"force_time": d["time"] + 100}, "no time in common"),
        (lambda d: {"speed_time": d["time"] + 100}, "0.0 s in common"),
    ],
)
def test_what_is_plainly_wrong_is_refused(
    changes: Any, said: str, tmp_path: Path, cli: Cli
) -> None:
    assert said in refused(tmp_path, cli, *three(tmp_path, **changes(drive())))


def test_shaking_is_no_wrong_unit(tmp_path: Path) -> None:
    """A small car on rough ground: half of the samples show more than 11.4 m/s^2."""
    force = drive()["force"] + np.random.default_rng(1).normal(0.0, 5.0, drive()["force"].shape)
    assert np.median(np.linalg.norm(force, axis=1)) > 11.4
    convert(tmp_path, *three(tmp_path, force=force))


def test_what_is_doubtful_is_said(tmp_path: Path, cli: Cli) -> None:
    made = drive()
    stuck = made["force"].copy()
    stuck[1000:2500] = stuck[1000]
    for said, changes in (
        ("wheel: it never turns", {"speed": 0 * made["speed"]}),
        ("acceleration does not change at all for 15.0 s", {"force": stuck}),
        ("36.0 s in common, of 40.0 s", {"speed_time": made["time"] + 4}),
    ):
        assert said in told(tmp_path, cli, *three(tmp_path, **changes))


def test_a_first_line_that_is_no_header(tmp_path: Path, cli: Cli) -> None:
    arguments = three(tmp_path)
    rows = (tmp_path / "w.csv").read_text().splitlines()[1:]
    for first, said in (
        ("0,1,2", None),
        (rows[0].replace("1700000000.000000", "start"), "both numbers and words"),
    ):
        (tmp_path / "w.csv").write_text("\n".join([first, *rows]) + "\n")
        if said is not None:
            assert said in refused(tmp_path, cli, *arguments)
    (tmp_path / "w.csv").write_text("\n".join(rows) + "\n")  # none at all: every row is data
    assert len(convert(tmp_path, *arguments)["WHEEL"]["utime"]) == len(rows)
    for numbers in ("0,1,2,3", "1,2,3,4"):
        rows = (tmp_path / "a.csv").read_text().splitlines()[1:]
        (tmp_path / "a.csv").write_text("\n".join([numbers, *rows]) + "\n")
        assert "the numbers of columns" in refused(tmp_path, cli, *arguments)
        (tmp_path / "a.csv").write_text("\n".join(["t,x,y,z", *rows]) + "\n")
    rows = (tmp_path / "w.csv").read_text().splitlines()
    (tmp_path / "w.csv").write_text("\n".join(["0,1", *rows]) + "\n")
    assert "days between messages 1 and 2" in refused(tmp_path, cli, *arguments)


def own(folder: Path) -> tuple[Path, Path]:
    """One table with semicolons, decimal commas, other order and units, and one of a radar."""
    made = drive()
    ms = (made["time"] - START) * 1e3
    counts = np.rint(made["distance"][:, None] * COUNTS * [1.01, 0.99])
    header = "wl;wr;gz;gy;gx;az;ay;ax;ms"
    columns = counts, np.degrees(made["rate"][:, ::-1]), made["force"][:, ::-1] / G, ms
    all_in_one = table(folder / "drive.csv", header, *columns, mark=";")
    all_in_one.write_text(all_in_one.read_text().replace(".", ","))
    radar = folder / "radar.csv"
    stamps = [datetime.fromtimestamp(t, UTC).isoformat() for t in made["time"][::5] - START]
    lines = [
        ",".join([*map(str, trace), stamp])
        for stamp, trace in zip(stamps, made["traces"].tolist(), strict=True)
    ]
    radar.write_text("\n".join(lines) + "\n")
    return all_in_one, radar


LAYOUT = """\
delimiter: ";"
time_unit: ms
acceleration_unit: g
rate_unit: deg/s
counts_per_metre: 5200
sample_interval: 3.125e-10
imu: {columns: [ms, ax, ay, az, gx, gy, gz]}
wheel_counts: {columns: [ms, wl, wr]}
gpr: {file: radar.csv, columns: [13, 1-12], time_unit: iso, delimiter: ","}
"""


def test_own_tables_by_a_layout_and_by_options(tmp_path: Path) -> None:
    """Both ways make the same log, which is the drive."""
    one, _ = own(tmp_path)
    (tmp_path / "robot.yaml").write_text(LAYOUT)
    log, made = convert(tmp_path, str(one), "--layout", str(tmp_path / "robot.yaml")), drive()
    np.testing.assert_allclose(log["IMU"]["linear_acceleration"], made["force"], atol=1e-5)
    np.testing.assert_allclose(log["IMU"]["angular_velocity"], made["rate"], atol=1e-7)
    np.testing.assert_allclose(wheel_of(log), made["distance"], atol=3e-4)
    np.testing.assert_array_equal(log["GPR_TRACE"]["samples"], made["traces"])
    assert set(log["GPR_TRACE"]["sample_interval"]) == {3.125e-10}
    assert log["GPR_TRACE"]["utime"][1] == 50_000
    first = (tmp_path / "out.lcmlog").read_bytes()
    by_number = ["--imu-columns", "9,8,7,6,5,4,3", "--wheel-counts-columns", "ms,1-2"]
    units = ["--time-unit", "ms", "--acceleration-unit", "g", "--rate-unit", "deg/s"]
    rest = ["--counts-per-metre", "5200", "--sample-interval", "3.125e-10"]
    (tmp_path / "gpr.yaml").write_text(LAYOUT.splitlines()[-1] + "\n")
    convert(tmp_path, str(one), *by_number, *units, *rest, "--layout", str(tmp_path / "gpr.yaml"))
    assert (tmp_path / "out.lcmlog").read_bytes() == first


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (("wl, wr", "wl, left"), "no column 'left'; it has wl, wr, gz"),
        (("ms, wl, wr", "ms, 12"), "no column 12; it has 9"),
        (("unit: g", "unit: gees"), "acceleration_unit: 'gees': expected one of m/s2, g"),
        (("counts_per_metre: 5200\n", ""), "--counts-per-metre"),
        (("counts_per_metre", "counts_a_metre"), "unknown key counts_a_metre"),
        (("gx, gy, gz", "gx, gy"), "expected 7 columns"),
        (("{columns: [ms, wl, wr]}", "[ms, wl, wr]"), "wheel_counts: expected {file"),
    ],
)
def test_layouts_that_do_not_fit(
    change: tuple[str, str], said: str, tmp_path: Path, cli: Cli
) -> None:
    one, _ = own(tmp_path)
    layout = tmp_path / "robot.yaml"
    layout.write_text(LAYOUT.replace(*change))
    code = 2 if "--" in said else 1  # an option is missing
    assert said in refused(tmp_path, cli, one, "--layout", layout, code=code)


def test_positions_in_degrees(tmp_path: Path, cli: Cli) -> None:
    pytest.importorskip("pyproj")
    time = drive()["time"][::100]
    north = np.arange(len(time)) * 1e-5
    fixes = table(tmp_path / "p.csv", "t,lat,lon", time, 45 + north, 7 + 0 * north)
    arguments = [*three(tmp_path), "--position", str(fixes), "--position-unit", "degrees"]
    log = convert(tmp_path, *arguments)
    step = 1.1113  # m, of 1e-5 degrees of latitude at 45 degrees
    expected = np.column_stack([0 * north, step * np.arange(len(time)), 0 * north])
    np.testing.assert_allclose(log["TOTAL_STATION"]["position"], expected, atol=0.02)
    table(tmp_path / "p.csv", "t,lon,lat", time, 145 + north, 7 + 0 * north)
    assert "latitude and longitude" in refused(tmp_path, cli, *arguments)


def test_traces_of_a_survey_file(tmp_path: Path, cli: Cli) -> None:
    made = drive()
    (tmp_path / "l.rad").write_text("SAMPLES:12\nFREQUENCY:5000\nDISTANCE INTERVAL:0.05\n")
    made["traces"].astype("<i2").tofile(tmp_path / "l.rd3")
    times = table(tmp_path / "t.csv", "t", made["time"][::5])
    arguments = [*three(tmp_path), "--gpr", str(tmp_path / "l.rd3")]
    assert "--gpr-times" in refused(tmp_path, cli, *arguments, code=2)
    log = convert(tmp_path, *arguments, "--gpr-times", str(times))
    np.testing.assert_array_equal(log["GPR_TRACE"]["samples"], made["traces"])
    table(tmp_path / "t.csv", "t", made["time"][:50:5])
    said = refused(tmp_path, cli, *arguments, "--gpr-times", str(times))
    assert "800 traces, but 10 rows" in said


def iso(utime: np.ndarray) -> list[str]:
    """Stamps (us) as dates."""
    return [str(t) for t in utime.astype("datetime64[us]")]


def tables_of(log: dict[str, Any], folder: Path) -> list[str]:
    """A log as a robot's own tables, as docs/recordings.md has them: all sensors in one with
    semicolons and decimal commas, milliseconds, g, deg/s and counts; traces and degrees beside it.
    Returns the arguments that convert them by the layout in the docs."""
    text = (CHECKOUT / "docs" / "recordings.md").read_text()
    (folder / "robot.yaml").write_text(text.split("```yaml\n")[1].split("```")[0])
    imu, wheel, radar, station = (
        log[name] for name in ("IMU", "WHEEL", "GPR_TRACE", "TOTAL_STATION")
    )
    distance = wheel["ticks"] * wheel["metres_per_tick"]
    counts = np.rint(COUNTS * np.interp(imu["utime"], wheel["utime"], distance))
    rate, force = np.degrees(imu["angular_velocity"]), imu["linear_acceleration"] / G
    # Where both are: the table has a row for each IMU message.
    both = (imu["utime"] >= wheel["utime"][0]) & (imu["utime"] <= wheel["utime"][-1])
    columns = np.column_stack([imu["utime"] * 1e-3, counts, counts, rate, force])[both]
    drive = table(folder / "drive.csv", "stamp_ms;left;right;gx;gy;gz;ax;ay;az", columns, mark=";")
    drive.write_text(drive.read_text().replace(".", ","))
    rows = zip(iso(radar["utime"]), np.stack(list(radar["samples"])).tolist(), strict=True)
    (folder / "radar.csv").write_text(
        "".join(f"{stamp},{','.join(map(str, trace))}\n" for stamp, trace in rows)
    )
    fixes = Datum(52.39, 13.06, 40.0, 30.0).to_geographic(station["position"])
    rows = zip(iso(station["utime"]), fixes.tolist(), strict=True)
    (folder / "gps.csv").write_text(
        "time,latitude,longitude,height\n"
        + "".join(f"{stamp},{a:.10f},{b:.10f},{c:.4f}\n" for stamp, (a, b, c) in rows)
    )
    return ["--layout", str(folder / "robot.yaml"), str(drive)]


def test_own_tables_by_the_layout_in_the_docs_are_converted_and_run(
    sample_log: Path, tmp_path: Path, cli: Cli
) -> None:
    """The sample sequence, written as a robot's own tables, comes out as from itself."""
    pytest.importorskip("pyproj")
    log = convert(tmp_path, *tables_of(read(sample_log), tmp_path))
    assert set(log["GPR_TRACE"]["sample_interval"]) == {3.125e-10}
    error = {}
    for path in (sample_log, tmp_path / "out.lcmlog"):
        poses = tmp_path / "path.tum"
        cli("run", path, "--method", "gprodom_full", "--tum", poses)
        error[path.stem] = cli.json("score", poses, path)["ate_rmse_m"]
    assert error["sample"] < 0.1
    assert error["out"] == pytest.approx(error["sample"], rel=0.3)
