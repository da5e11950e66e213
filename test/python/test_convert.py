"""gprodom convert cmu: variants of the dataset's files, and files that must be refused."""

import random
import re
import zipfile
from decimal import ROUND_HALF_UP, Decimal
from pathlib import Path

import numpy as np
import pytest

from conftest import Cli, run_cli
from gprodom.convert import source
from gprodom.convert.cmu import read_recording
from gprodom.convert.quantum import find_quantum
from gprodom.ground.survey import Survey, write_survey
from gprodom.lcm import EventLog
from gprodom.lcm.logs import read
from gprodom.times import to_microseconds

START = 1_611_959_465
IMU = "t_stamp,a_x,a_y,a_z,g_x,g_y,g_z,w,x,y,z"
ROWS = 40


def stamp(microseconds: int) -> str:
    return f"{START + microseconds // 1_000_000}.{microseconds % 1_000_000:06d}"


def tables() -> dict[str, list[str]]:
    """The lines of a small sequence; IMU, wheel and radar share every tenth stamp."""
    imu = [
        f"{stamp(5000 * i)},0.1,-0.2,9.79,{0.001 * i:.6f},0.02,-0.03,1.0,0.0,0.0,0.0"
        for i in range(ROWS)
    ]
    wheel = [f"{stamp(50_000 * i)},{-0.0005 * i * i:.6f}" for i in range(4)]
    gpr = [f"{stamp(50_000 * i)},{','.join(str(100 * i - j) for j in range(12))}" for i in range(4)]
    truth = [f"{stamp(50_000 * i)},{i}.5,-2.25,1.125" for i in range(4)]
    return {
        "imu_meas.csv": [IMU, *imu],
        "we_odom_meas.csv": ["Time[s],Range[m]", *wheel],
        "gpr_meas.csv": ["t_stamp," + ",".join(f"amp_{i + 1}" for i in range(12)), *gpr],
        "ts_meas.csv": ["Time[s],Px[m],Py[m],Pz[m]", *truth],
    }


def write(folder: Path, files: dict[str, list[str]], end: str = "\r\n") -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    for name, lines in files.items():
        (folder / name).write_bytes("".join(line + end for line in lines).encode())
    return folder


def pack(path: Path, folder: Path, prefix: str = "") -> Path:
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for file in sorted(folder.iterdir()):
            archive.writestr(prefix + file.name, file.read_bytes())
    return path


def convert(sequence: Path, *arguments: str) -> Path:
    log = sequence.parent / f"{sequence.name}.lcmlog"
    run_cli("convert", "cmu", sequence, "-o", log, *arguments)
    return log


@pytest.fixture
def reference(tmp_path: Path) -> bytes:
    return convert(write(tmp_path / "reference", tables())).read_bytes()


def test_content_and_order(tmp_path: Path) -> None:
    log = read(convert(write(tmp_path / "a", tables()), "--sample-interval", "3e-10"))
    imu, wheel, gpr, truth = (log[c] for c in ("IMU", "WHEEL", "GPR_TRACE", "TOTAL_STATION"))
    assert imu["utime"].tolist() == [START * 1_000_000 + 5000 * i for i in range(ROWS)]
    np.testing.assert_array_equal(imu["linear_acceleration"][7], [0.1, -0.2, 9.79])
    np.testing.assert_array_equal(imu["angular_velocity"][7], [0.007, 0.02, -0.03])
    assert imu["has_orientation"].all()
    assert wheel["metres_per_tick"].tolist() == [0.0005] * 4
    assert wheel["ticks"].tolist() == [0, -1, -4, -9]
    assert gpr["samples"].dtype == np.int32
    assert gpr["samples"][2].tolist() == [200 - j for j in range(12)]
    assert gpr["seq"].tolist() == [0, 1, 2, 3]
    assert set(gpr["sample_interval"]) == {3e-10}
    np.testing.assert_array_equal(truth["position"][3], [3.5, -2.25, 1.125])
    events = [(e.timestamp - START * 1_000_000, e.channel) for e in EventLog(tmp_path / "a.lcmlog")]
    assert [time for time, _ in events] == sorted(time for time, _ in events)
    same = [channel for time, channel in events if time == 50_000]
    assert same == ["IMU", "WHEEL", "GPR_TRACE", "TOTAL_STATION"]


@pytest.mark.parametrize(
    "variant",
    ["lf", "nested", "zip", "nested_zip", "we_odom", "gyro_first", "headers", "no_header", "bom"],
)
def test_variants_give_the_same_log(variant: str, tmp_path: Path, reference: bytes) -> None:
    files = tables()
    if variant == "we_odom":
        files["we_odom.csv"] = files.pop("we_odom_meas.csv")
    elif variant == "gyro_first":
        cells = [row.split(",") for row in files["imu_meas.csv"][1:]]
        swapped = [",".join([c[0], *c[4:7], *c[1:4], *c[7:]]) for c in cells]
        files["imu_meas.csv"] = [IMU, *swapped]
    elif variant == "headers":
        files = {name: ["alpha beta, what", *lines[1:]] for name, lines in files.items()}
    elif variant == "no_header":
        files = {name: [*lines[1:], "", " "] for name, lines in files.items()}
    elif variant == "bom":
        files = {name: ["\ufeff" + lines[0], *lines[1:]] for name, lines in files.items()}
    sequence = write(tmp_path / "v", files, "\n" if variant == "lf" else "\r\n")
    if variant == "nested":
        write(tmp_path / "outer" / "inner", files)
        (tmp_path / "outer" / "camera").mkdir()
        sequence = tmp_path / "outer"
    elif variant == "zip":
        sequence = pack(tmp_path / "v.zip", sequence)
    elif variant == "nested_zip":
        sequence = pack(tmp_path / "v.zip", sequence, "1611959465-0-gates_g-cmu-gpr/")
        with zipfile.ZipFile(sequence, "a") as archive:
            archive.writestr("__MACOSX/1611959465-0-gates_g-cmu-gpr/imu_meas.csv", b"junk")
    assert convert(sequence).read_bytes() == reference


@pytest.mark.parametrize("content", [None, b"", b"Time[s],Px[m],Py[m],Pz[m]\r\n"])
def test_truth_may_be_missing_or_empty(content: bytes | None, tmp_path: Path) -> None:
    sequence = write(tmp_path / "a", tables())
    (sequence / "ts_meas.csv").unlink()
    if content is not None:
        (sequence / "ts_meas.csv").write_bytes(content)
    assert set(read(convert(sequence))) == {"IMU", "WHEEL", "GPR_TRACE"}


@pytest.mark.parametrize(("columns", "flagged"), [("", 0), (",0.3,0.1,-0.5,0.2", 0), (None, ROWS)])
def test_orientation_has_unit_norm(columns: str | None, flagged: int, tmp_path: Path) -> None:
    files = tables()
    if columns is not None:
        rows = [",".join(row.split(",")[:7]) + columns for row in files["imu_meas.csv"]]
        files["imu_meas.csv"] = rows
    assert read_recording(write(tmp_path / "a", files)).has_orientation.sum() == flagged


def test_times_are_exact_to_the_microsecond() -> None:
    assert to_microseconds(b"1611959465.5713053") == 1_611_959_465_571_305
    assert to_microseconds(b" 1611959465.9999995") == 1_611_959_466_000_000
    assert to_microseconds(b"1.6119594655713053e+09") == 1_611_959_465_571_305
    generator = random.Random(1)
    for _ in range(2000):
        text = f"{generator.randrange(10**10)}.{generator.randrange(10**9):0{9}d}"
        text = text[: generator.randrange(len(text) - 9, len(text) + 1)]
        exact = (Decimal(text) * 1_000_000).to_integral_value(ROUND_HALF_UP)
        assert to_microseconds(text.encode()) == exact
    for text in (b"", b"abc", b"-1.5", b"nan", b"1e30", b"1,5", b"\xff"):
        with pytest.raises(ValueError, match="not a time"):
            to_microseconds(text)


def test_rows_out_of_order_are_sorted_and_counted(tmp_path: Path, cli: Cli) -> None:
    files = tables()
    rows = files["imu_meas.csv"]
    rows[10], rows[11], rows[20] = rows[11], rows[10], rows[19]
    log = tmp_path / "a.lcmlog"
    summary = cli.json("convert", "cmu", write(tmp_path / "a", files), "-o", log)
    content = read(log)["IMU"]
    assert (np.diff(content["utime"]) >= 0).all()
    assert content["angular_velocity"][9:11, 0].tolist() == [0.009, 0.010]
    imu = summary["sensors"]["imu"]
    assert (imu["count"], imu["out_of_order"], imu["equal_times"]) == (ROWS, 1, 1)
    assert imu["rate_hz"] == pytest.approx(200)
    assert summary["duration_s"] == pytest.approx(0.195)


def test_gaps_are_counted(tmp_path: Path, cli: Cli) -> None:
    files = tables()
    del files["imu_meas.csv"][15:30]
    command = ["convert", "cmu", write(tmp_path / "a", files), "-o", tmp_path / "a.lcmlog"]
    imu = cli.json(*command)["sensors"]["imu"]
    assert (imu["gaps"], imu["longest_interval_s"]) == (1, pytest.approx(0.08))


@pytest.mark.parametrize(
    ("file", "line", "text", "message"),
    [
        ("imu_meas.csv", 5, "1611959465.1,1,2", r"expected 11 columns \(.*\), got 3"),
        ("imu_meas.csv", 7, "1611959465.1,1,2,x" + ",0" * 7, "finite number in column 4, got 'x'"),
        ("imu_meas.csv", 7, "1611959465.1,nan" + ",0" * 9, "finite number in column 2, got 'nan'"),
        ("imu_meas.csv", 7, "1611959465.1,1_0" + ",0" * 9, "finite number in column 2, got '1_0'"),
        ("imu_meas.csv", 2, "1611959465.1,1,2", "expected 11 or 7 columns"),
        ("we_odom_meas.csv", 3, "yesterday,1", "expected a time in seconds.*'yesterday'"),
        ("we_odom_meas.csv", 4, "1611959465.1,\x00\xff", "expected a finite number"),
        ("gpr_meas.csv", 3, "1611959465.1" + ",1.5" * 12, "whole number of 32 bits in column 2"),
        ("gpr_meas.csv", 4, "1611959465.1" + ",0" * 11 + ",2147483648", "32 bits in column 13"),
        ("gpr_meas.csv", 2, "1611959465.1,1,2", "expected 9 or more columns"),
        ("ts_meas.csv", 5, "1611959465.1,1,2,inf", "finite number in column 4, got 'inf'"),
    ],
)
@pytest.mark.parametrize("zipped", [False, True])
def test_malformed_row_leaves_nothing_behind(
    file: str, line: int, text: str, message: str, zipped: bool, tmp_path: Path, cli: Cli
) -> None:
    files = tables()
    files[file][line - 1] = text
    sequence = write(tmp_path / "in" / "a", files)
    if zipped:
        sequence = pack(tmp_path / "in" / "a.zip", sequence, "a/")
    label = f"{sequence}/{'a/' if zipped else ''}{file}"
    fails(sequence, f"{re.escape(label)}:{line}: .*{message}", cli)


def fails(sequence: Path, message: str, cli: Cli) -> None:
    """In one line, and nothing is left behind."""
    out = sequence.parent / "out"
    out.mkdir(exist_ok=True)
    error = cli.error("convert", "cmu", sequence, "-o", out / "log")
    assert re.fullmatch(rf"gprodom: error: .*{message}.*\n", error), error
    assert list(out.iterdir()) == []


def test_incomplete_or_doubtful_sequences(tmp_path: Path, cli: Cli) -> None:
    fails(tmp_path / "nowhere", "no such sequence", cli)
    fails(write(tmp_path / "empty", {}), "not a CMU-GPR sequence", cli)
    (tmp_path / "text").write_text("hello")
    fails(tmp_path / "text", "expected a directory or a zip", cli)
    files = tables()
    imu = files.pop("imu_meas.csv")
    fails(write(tmp_path / "a", files), "missing imu_meas.csv", cli)
    fails(write(tmp_path / "b", {**files, "imu_meas.csv": [IMU]}), "expected rows of data", cli)
    still = [row.replace("9.79", "0.5") for row in imu]
    fails(write(tmp_path / "c", {**files, "imu_meas.csv": still}), "show gravity", cli)
    both = {**tables(), "we_odom.csv": files["we_odom_meas.csv"]}
    fails(write(tmp_path / "d", both), "expected one wheel file", cli)
    write(tmp_path / "e" / "one", tables())
    write(tmp_path / "e" / "two", tables())
    fails(tmp_path / "e", "expected one sequence, got 2", cli)


def test_unsafe_zips_are_refused(tmp_path: Path, cli: Cli, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = write(tmp_path / "a", tables())
    for prefix in ("../", "/", "x/../"):
        fails(pack(tmp_path / "escape.zip", folder, prefix), "unsafe path", cli)
    whole = pack(tmp_path / "whole.zip", folder)
    data = bytearray(whole.read_bytes())
    data[60:90] = bytes(30)
    (tmp_path / "damaged.zip").write_bytes(data)
    fails(tmp_path / "damaged.zip", "damaged or unreadable zip", cli)
    with pytest.warns(UserWarning, match="Duplicate"), zipfile.ZipFile(whole, "a") as archive:
        archive.writestr("imu_meas.csv", b"")
    fails(whole, "twice in the zip", cli)
    bomb = pack(tmp_path / "bomb.zip", folder)
    monkeypatch.setattr(source, "MAX_BYTES", 10)
    monkeypatch.delattr("zipfile.ZipFile.open")  # refused before a byte is unpacked
    fails(bomb, "refused, unpacks to more than 10 bytes", cli)


def test_failed_write_keeps_the_old_log(
    tmp_path: Path, cli: Cli, monkeypatch: pytest.MonkeyPatch
) -> None:
    sequence = write(tmp_path / "a", tables())
    log = convert(sequence)
    before = log.read_bytes()
    monkeypatch.setattr("gprodom.lcm.log_writer._EVENT_HEADER", 29)  # as if bytes had been lost
    assert "disk full" in cli.error("convert", "cmu", sequence, "-o", log)
    assert log.read_bytes() == before
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a", "a.lcmlog"]
    cli("convert", "cmu", sequence, "-o", tmp_path, code=2)
    cli("convert", "cmu", sequence, "-o", log, "--sample-interval", "0", code=2)


@pytest.mark.parametrize("quantum", [0.000181609, 0.0005, 0.00314159265, 1 / 1024])
@pytest.mark.parametrize("decimals", [6, 9, 17])
def test_quantum_is_found(quantum: float, decimals: int) -> None:
    ticks = np.cumsum(np.random.default_rng(3).integers(-8, 60, 20_000)) + 3
    distances = np.round(ticks * quantum, decimals)
    found = find_quantum(distances, decimals)
    assert found is not None
    np.testing.assert_array_equal(np.rint(distances / found), ticks)
    np.testing.assert_allclose(ticks * found, distances, atol=0.51 * 10.0**-decimals + 1e-9)


def test_no_quantum_in_values_off_any_grid() -> None:
    assert find_quantum(np.cumsum(np.random.default_rng(3).uniform(0, 0.01, 500)), 17) is None
    assert find_quantum(np.zeros(100), 6) is None


def test_real_wheel_and_truth(shared: Path, tmp_path: Path) -> None:
    sequence = write(tmp_path / "a", tables())
    for name in ("we_odom_meas.csv", "ts_meas.csv"):
        (sequence / name).write_bytes((shared / "cmu_real" / name).read_bytes())
    log = read(convert(sequence))
    assert "TOTAL_STATION" not in log
    wheel = log["WHEEL"]
    rows = (shared / "cmu_real" / "we_odom_meas.csv").read_text().split()[1:]
    texts = [row.split(",") for row in rows]
    micro = Decimal("0.000001")
    exact = [int(Decimal(time).quantize(micro, ROUND_HALF_UP) * 10**6) for time, _ in texts]
    assert wheel["utime"].tolist() == exact
    assert wheel["metres_per_tick"][0] == pytest.approx(0.0001816, rel=1e-3)
    distance = wheel["ticks"] * wheel["metres_per_tick"]
    np.testing.assert_allclose(distance, [float(value) for _, value in texts], atol=1e-8)


def simulated(folder: Path, *arguments: str) -> Path:
    """A short simulated drive."""
    made = folder / "1700000000-0-yard-cmu-gpr.zip"
    short = ["simulate", "--distance", "2", "--standstill", "1", "-o", str(made)]
    run_cli(*short, *arguments)
    return made


def interval(log: Path) -> float:
    """Of all its traces."""
    (found,) = set(read(log)["GPR_TRACE"]["sample_interval"])
    return float(found)


def test_sample_interval_comes_with_the_sequence(tmp_path: Path, cli: Cli) -> None:
    """Ground of another interval than the dataset's: no option is needed to convert it."""
    lines = np.random.default_rng(1).integers(-900, 900, (1, 300, 16)).astype(np.int16)
    ground = Survey("g", lines, 0.05, np.zeros(1), 3.125e-10, 0.0, closed=False)
    write_survey(tmp_path / "g.npz", ground)
    made = simulated(tmp_path, "--ground", str(tmp_path / "g.npz"))
    assert interval(convert(made)) == 3.125e-10
    assert interval(convert(made, "--sample-interval", "1e-10")) == 1e-10
    # Without the file in the zip, what stands beside it is taken, and said.
    with zipfile.ZipFile(made) as archive:
        files = {Path(name).name: archive.read(name) for name in archive.namelist()}
    del files["gpr_meas.json"]
    older = tmp_path / "1700000001-0-yard-cmu-gpr.zip"
    with zipfile.ZipFile(older, "w") as archive:
        for name, data in files.items():
            archive.writestr(name, data)
    assert interval(convert(older)) == 2e-10
    beside = older.with_suffix(".json")
    beside.write_text('{"gpr_sample_interval": 3.125e-10, "scale": "of no concern"}')
    said = cli("convert", "cmu", older, "-o", tmp_path / "b.lcmlog").err
    assert f"3.125e-10 s taken from {beside.name}" in said
    assert interval(tmp_path / "b.lcmlog") == 3.125e-10
    beside.write_text('{"gpr_sample_interval": "soon"}')
    fails(older, "gpr_sample_interval: expected seconds", cli)


def test_a_drive_without_radar_is_read(tmp_path: Path) -> None:
    log = read(convert(simulated(tmp_path, "--ground", "none")))
    assert set(log) == {"IMU", "WHEEL", "TOTAL_STATION"}


@pytest.mark.parametrize("packed", [False, True])
def test_traces_of_further_antennas(packed: bool, tmp_path: Path) -> None:
    files = tables()
    header, *rows = files["gpr_meas.csv"]
    later = [f"{stamp(50_000 * i + 4000)}{',7' * 12}" for i in range(3)]
    files["gpr_meas_1.csv"] = [header, *later]
    sequence = write(tmp_path / "two", files)
    if packed:
        sequence = pack(tmp_path / "two.zip", sequence, "two/")
    gpr = read(convert(sequence))["GPR_TRACE"]
    assert gpr["antenna_id"].tolist() == [0, 1, 0, 1, 0, 1, 0]
    assert gpr["seq"].tolist() == [0, 0, 1, 1, 2, 2, 3]
    assert gpr["samples"][1].tolist() == [7] * 12
    assert len(rows) == 4
    assert read_recording(sequence).out_of_order["gpr 1"] == 0
