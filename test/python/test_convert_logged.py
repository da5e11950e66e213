"""Tables as loggers write them: all sensors in one, with empty cells, faults, restarts, gaps."""

import os
import sys
import threading
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from conftest import Cli, run_program
from dzt_file import dzt_file
from gprodom.convert.rows import BLOCK_BYTES
from gprodom.convert.survey_files import read_line, read_lines
from gprodom.convert.wheels import continued
from gprodom.errors import Error
from gprodom.ground.survey import read_survey
from gprodom.lcm.antennas import apart
from gprodom.lcm.logs import read
from test_convert_tables import (
    COUNTS,
    SPAN,
    START,
    convert,
    drive,
    refused,
    table,
    three,
    told,
    wheel_of,
)

WIDE = ["--imu-columns", "t,ax,ay,az,gx,gy,gz", "--wheel-distance-columns", "t,d"]
RADAR = ["--gpr-columns", "t,9-20", "--sample-interval", "2e-10"]


def wide(path: Path, change: Callable[[list[str]], list[str]] = list) -> list[str]:
    """One table: IMU at 100 Hz, wheel in every third row, a trace in every fifth; the lines of it
    changed. Returns the arguments that convert it."""
    made = drive()
    names = "t,ax,ay,az,gx,gy,gz,d," + ",".join(f"s{i}" for i in range(12))
    lines = [names]
    for i, t in enumerate(made["time"]):
        imu = ",".join(f"{value:.6f}" for value in (*made["force"][i], *made["rate"][i]))
        wheel = f"{made['distance'][i]:.6f}" if i % 3 == 0 else ""
        trace = ",".join(map(str, made["traces"][i // 5])) if i % 5 == 0 else "," * 11
        lines.append(f"{t:.6f},{imu},{wheel},{trace}")
    path.write_text("\n".join(change(lines)) + "\n")
    return [str(path), *WIDE, *RADAR]


def test_slower_sensors_leave_their_cells_empty(tmp_path: Path, cli: Cli) -> None:
    assert told(tmp_path, cli, *wide(tmp_path / "all.csv")) == ""
    log, made = read(tmp_path / "out.lcmlog"), drive()
    np.testing.assert_allclose(log["IMU"]["linear_acceleration"], made["force"], atol=1e-6)
    np.testing.assert_allclose(wheel_of(log), made["distance"][::3], atol=1e-5)
    np.testing.assert_array_equal(log["GPR_TRACE"]["samples"], made["traces"])
    times = np.rint(made["time"][::5] * 1e6).astype(np.int64)
    np.testing.assert_array_equal(log["GPR_TRACE"]["utime"], times)


def spoilt(lines: list[str]) -> list[str]:
    """A comment, an IMU that is not a number, a word, and a last line cut short by a power cut."""
    cells = lines[100].split(",")
    cells[2] = "nan"
    lines[100] = ",".join(cells)
    lines[200] = lines[200].replace(",", ",x", 1)
    lines[-1] = lines[-1][:30]
    return [*lines[:50], "# marked by hand", *lines[50:]]


def test_lines_that_cannot_be_used_are_left_out_and_counted(tmp_path: Path, cli: Cli) -> None:
    path = tmp_path / "all.csv"
    arguments = wide(path, spoilt)
    path.write_bytes(path.read_bytes().rstrip(b"\n"))
    said, made = told(tmp_path, cli, *arguments), drive()
    log = read(tmp_path / "out.lcmlog")
    kept = np.ones(len(made["time"]), bool)
    kept[[99, 199, -1]] = False
    np.testing.assert_allclose(log["IMU"]["linear_acceleration"], made["force"][kept], atol=1e-6)
    assert "4 lines left out, 1 of them comments, of 4001 with acceleration" in said
    assert "line 102, expected a finite number in column 3, got 'nan'" in said
    strict = refused(tmp_path, cli, *arguments, "--strict")
    assert "all.csv:51: expected numbers, got a comment" in strict


def test_a_row_cut_short_by_a_power_cut_is_no_row(tmp_path: Path) -> None:
    """Its last number has lost digits, though it still is one."""
    arguments = three(tmp_path)
    whole = convert(tmp_path, *arguments)["WHEEL"]["ticks"]
    path = tmp_path / "w.csv"
    path.write_text(path.read_text() + f"{START + SPAN + 0.02:.6f}")
    np.testing.assert_array_equal(convert(tmp_path, *arguments)["WHEEL"]["ticks"], whole)


def test_lines_of_windows_and_a_pipe(tmp_path: Path) -> None:
    """CRLF, and a table that can be read only once."""
    arguments = three(tmp_path)
    same = convert(tmp_path, *arguments)["IMU"]
    path = tmp_path / "g.csv"
    data = path.read_bytes().replace(b"\n", b"\r\n")
    path.unlink()
    os.mkfifo(path)
    writer = threading.Thread(target=path.write_bytes, args=(data,))
    writer.start()
    found = convert(tmp_path, *arguments)["IMU"]
    writer.join()
    for name in ("utime", "angular_velocity"):
        np.testing.assert_array_equal(found[name], same[name])


def test_names_may_stand_in_a_comment(tmp_path: Path) -> None:
    arguments = wide(
        tmp_path / "all.csv", lambda lines: ["% made today", "#" + lines[0], *lines[1:]]
    )
    assert len(convert(tmp_path, *arguments)["IMU"]["utime"]) == len(drive()["time"])


def test_a_table_of_which_most_is_unusable_is_refused(tmp_path: Path, cli: Cli) -> None:
    """Columns are numbered as in the file. Samples that are no counts: a scale is wanted."""
    path = tmp_path / "all.csv"
    arguments = wide(path)
    rows = [line.split(",") for line in path.read_text().splitlines()]
    for row in rows[1:]:
        row[8:] = [f"{int(cell) / 1000}" if cell else "" for cell in row[8:]]
    path.write_text("\n".join(map(",".join, rows)) + "\n")
    said = refused(tmp_path, cli, *arguments)
    assert "all.csv:2: expected a whole number of 32 bits in column 9" in said
    assert "--gpr-scale" in said
    log = convert(tmp_path, *arguments, "--gpr-scale", "1000")
    np.testing.assert_array_equal(log["GPR_TRACE"]["samples"], drive()["traces"])


def test_disorder_and_duplicates_are_told(tmp_path: Path, cli: Cli) -> None:
    def disordered(lines: list[str]) -> list[str]:
        lines[10], lines[20] = lines[20], lines[10]
        other = lines[31].replace(lines[31].split(",")[1], "0.5", 1)
        return [*lines[:31], lines[30], lines[31], other, *lines[32:]]

    log = tmp_path / "out.lcmlog"
    said = cli("convert", "tables", *wide(tmp_path / "all.csv", disordered), "-o", log)
    times = read(log)["IMU"]["utime"]
    assert np.all(np.diff(times) >= 0)
    assert len(times) == len(drive()["time"]) + 1
    assert "10 rows stood after later ones: sorted into place" in said.err
    assert "1 rows repeat another, time and values: left out" in said.err
    assert "1 rows have the time of another, with other values: kept" in said.err
    [imu] = [line.split() for line in said.out.splitlines() if line.startswith("IMU")]
    assert imu[-2:] == ["1", "10"]  # equal, out of order


@pytest.mark.parametrize(
    ("bits", "signed", "began", "times"),
    [(0, False, 0, 1), (16, False, 65_000, 2), (16, True, 32_000, 2), (32, False, 2**32 - 500, 1)],
)
def test_a_counter_that_begins_again_is_carried_on(
    bits: int, signed: bool, began: int, times: int, tmp_path: Path, cli: Cli
) -> None:
    """At zero after its power was cut, or by an overflow."""
    made = drive()
    made["distance"] = 0.5 * (made["time"] - START)
    made["speed"] = 0 * made["time"] + 0.5
    true = np.rint(made["distance"] * COUNTS).astype(np.int64)
    counts = true + began
    if bits:
        counts = counts % (1 << bits)
        counts[signed & (counts >= 1 << (bits - 1))] -= 1 << bits
    else:
        counts[2500:] -= counts[2500]
    arguments = three(tmp_path)[:4]
    path = table(tmp_path / "c.csv", "t,c", made["time"], counts)
    arguments += ["--wheel-counts", str(path), "--counts-per-metre", str(COUNTS)]
    how = "overflows" if bits else "starts again at zero"
    assert f"the counter of wheel 1 {how} {times} times" in told(tmp_path, cli, *arguments)
    np.testing.assert_allclose(wheel_of(read(tmp_path / "out.lcmlog")), made["distance"], atol=0.01)


def test_a_wheel_that_drives_back_to_zero_has_not_begun_again() -> None:
    time = np.arange(4000) * 10_000
    for counts in (
        np.rint(3000 * np.abs(np.sin(time * 2e-6))),  # with a sharp turn at zero
        np.concatenate([np.zeros(2000), np.arange(1000), np.arange(1000)[::-1]]).astype(float),
        np.concatenate([np.arange(2000), 10_000 + np.arange(2000)]).astype(float),  # a jump ahead
    ):
        found = continued(time, counts)
        assert (found.restarts, found.wraps) == (0, 0)
        np.testing.assert_allclose(found.values, counts)


def test_a_gap_is_a_gap(tmp_path: Path, cli: Cli) -> None:
    """Not a sensor whose values do not change."""
    made = drive()
    kept = (made["time"] < START + 10) | (made["time"] > START + 30)
    changes = {name: made[name][kept] for name in ("force", "rate")}
    changes |= dict.fromkeys(("force_time", "rate_time"), made["time"][kept])
    said = told(tmp_path, cli, *three(tmp_path, **changes))
    assert "IMU: no messages for 20.0 s, from 10.0 s after its first on" in said
    assert "does not change" not in said


@pytest.mark.parametrize(
    ("interval", "said"),
    [("0.25", "is it in nanoseconds? Then write 2.5e-10"), ("2.5e-8", "1e-12 to 1e-08"),
     ("250", "in picoseconds? Then write 2.5e-10"), (None, "Give --sample-interval")],
)  # fmt: skip
def test_a_sample_interval_of_no_radar(
    interval: str | None, said: str, tmp_path: Path, cli: Cli
) -> None:
    arguments = wide(tmp_path / "all.csv")[:-2]
    if interval is None:
        assert said in refused(tmp_path, cli, *arguments, code=2)
        return
    assert said in refused(tmp_path, cli, *arguments, "--sample-interval", interval, code=2)
    layout = tmp_path / "robot.yaml"
    layout.write_text(f"sample_interval: {float(interval)!r}\n")
    assert said in refused(tmp_path, cli, *arguments, "--layout", str(layout))


@pytest.mark.parametrize(("unit", "factor"), [("ms", 10**3), ("us", 10**6), ("ns", 10**9)])
def test_stamps_of_today_in_smaller_units(unit: str, factor: int, tmp_path: Path, cli: Cli) -> None:
    def smaller(lines: list[str]) -> list[str]:
        rows = [line.split(",", 1) for line in lines[1:]]
        return [lines[0], *(f"{round(float(t) * 1e3) * factor // 1000},{rest}" for t, rest in rows)]

    arguments = wide(tmp_path / "all.csv", smaller)
    assert f"Give --time-unit {unit}" in refused(tmp_path, cli, *arguments)
    log = convert(tmp_path, *arguments, "--time-unit", unit)
    expected = np.rint(drive()["time"] * 1e6).astype(np.int64)
    np.testing.assert_array_equal(log["IMU"]["utime"], expected)


def test_a_large_table_is_read_in_little_memory(tmp_path: Path) -> None:
    """Some times what its numbers take, not what its lines and cells do as objects of Python."""
    rows, samples = 12_000, 201
    traces = np.random.default_rng(1).integers(-30_000, 30_000, (rows, samples)).tolist()
    path = tmp_path / "radar.csv"
    with path.open("w") as file:
        for i, trace in enumerate(traces):
            file.write(f"{START + 0.05 * i:.6f},{','.join(map(str, trace))}\n")
    code = f"""
from pathlib import Path
from gprodom.convert.any_table import read_source
from gprodom.convert.layout import Source
def highest():  # of this program alone, where getrusage counts what was before exec as well
    return int(Path("/proc/self/status").read_text().split("VmHWM:")[1].split()[0])
before = highest()
table = read_source(Source(Path({str(path)!r})), range(9, 999), "time, samples", integers=True)
assert table.values.shape == ({rows}, {samples})
print(highest() - before)
"""
    grown = 1024 * int(run_program(sys.executable, "-c", code).stdout)
    numbers = rows * samples * np.dtype(np.int32).itemsize
    # Twice, when blocks are joined; and of the block at hand its lines, as objects, and numbers.
    assert grown < 2 * numbers + 12 * BLOCK_BYTES


# Files of several channels, and tables of several antennas.


def three_channels(path: Path) -> np.ndarray:
    """A file of three; the last header is empty. Their traces (3, 6, 32), without the marks."""
    traces = np.random.default_rng(1).integers(-3000, 3000, (3, 6, 32))
    path.write_bytes(dzt_file(traces, (64.0, 32.0, 0.0)))
    traces[:, :, :2] = traces[:, :, 2:3]
    return traces


def test_channels_of_a_dzt(tmp_path: Path) -> None:
    traces = three_channels(tmp_path / "a.dzt")
    lines = read_lines(tmp_path / "a.dzt")
    np.testing.assert_array_equal([line.traces for line in lines], traces)
    assert [line.sample_interval for line in lines] == pytest.approx([2e-9, 1e-9, 1e-9])
    np.testing.assert_array_equal(read_line(tmp_path / "a.dzt").traces, traces[0])


def test_headers_of_channels_that_cannot_lie_in_turn(tmp_path: Path) -> None:
    (tmp_path / "a.dzt").write_bytes(dzt_file(np.zeros((2, 5, 32)), (50.0, 50.0), (32, 64)))
    with pytest.raises(Error, match="channel 1 has 64 samples of 16 bits a trace, channel 0 32"):
        read_lines(tmp_path / "a.dzt")


def test_survey_of_chosen_channels(tmp_path: Path, cli: Cli) -> None:
    """Each a line, in the order given; without the option the first, as before, which is told."""
    traces, ground = three_channels(tmp_path / "a.dzt"), tmp_path / "g.npz"
    command = ["convert", "survey", tmp_path / "a.dzt", "-o", ground]
    assert cli.json(*command, "--channels", "2,1", "--aside", "0.08")["lines"] == 2
    survey = read_survey(ground)
    np.testing.assert_array_equal(survey.lines, traces[[2, 1]])
    np.testing.assert_allclose(survey.aside, [0, 0.08])
    assert "holds 3 channels; 0 is taken" in cli(*command).err
    np.testing.assert_array_equal(read_survey(ground).lines, traces[:1])
    assert "lines of different sampling" in cli.error(*command, "--channels", "0,1")
    said = cli.error(*command, "--channels", "3")
    assert "holds 3 channels, 0 to 2; --channels asks for 3" in said
    for wrong in ("0,0", "-1", "a"):
        cli(*command, f"--channels={wrong}", code=2)


def test_channels_become_antennas(tmp_path: Path, cli: Cli) -> None:
    """All, or those asked for, with the numbers they have in the file; those of the next file are
    counted on."""
    traces = three_channels(tmp_path / "a.dzt")
    times = table(tmp_path / "t.csv", "t", drive()["time"][:60:10])
    base = [*three(tmp_path), "--gpr-times", str(times), "--gpr", str(tmp_path / "a.dzt")]
    radar = convert(tmp_path, *base)["GPR_TRACE"]
    assert radar["antenna_id"].tolist() == [0, 1, 2] * 6
    assert radar["seq"].tolist() == [i // 3 for i in range(18)]
    for antenna, interval in enumerate((2e-9, 1e-9, 1e-9)):
        mine = apart(radar)[antenna]
        np.testing.assert_array_equal(mine["samples"], traces[antenna])
        assert mine["sample_interval"] == pytest.approx(interval)
    assert set(convert(tmp_path, *base, "--channels", "2")["GPR_TRACE"]["antenna_id"]) == {2}
    twice = apart(convert(tmp_path, *base, "--gpr", tmp_path / "a.dzt")["GPR_TRACE"])
    assert sorted(twice) == [0, 1, 2, 3, 4, 5]
    np.testing.assert_array_equal(twice[4]["samples"], traces[1])
    said = refused(tmp_path, cli, *three(tmp_path), "--gpr", times, "--channels", "0", code=2)
    assert "this is a table" in said


INTERVAL = ("--sample-interval", "2e-10")


def radar_tables(folder: Path) -> tuple[np.ndarray, list[str]]:
    """Traces (2, n, 12) of two antennas in a table each, and the options that name them."""
    made = drive()
    traces = np.stack([made["traces"], -made["traces"]])
    files = [
        table(folder / f"r{i}.csv", "", made["time"][::5], each) for i, each in enumerate(traces)
    ]
    return traces, [text for file in files for text in ("--gpr", str(file))]


def test_a_table_of_each_antenna(tmp_path: Path, cli: Cli) -> None:
    traces, options = radar_tables(tmp_path)
    command = ["convert", "tables", *three(tmp_path), *options, *INTERVAL]
    counted = cli.json(*command, "-o", tmp_path / "out.lcmlog")["channels"]
    assert counted["GPR_TRACE"]["count"] == counted["GPR_TRACE 1"]["count"] == len(traces[0])
    layout = tmp_path / "robot.yaml"
    layout.write_text("gpr: {file: [r0.csv, r1.csv]}\nsample_interval: 2.0e-10\n")
    for radar in (
        convert(tmp_path, *three(tmp_path), *options, *INTERVAL)["GPR_TRACE"],
        convert(tmp_path, *three(tmp_path), "--layout", str(layout))["GPR_TRACE"],
    ):
        found = apart(radar)
        np.testing.assert_array_equal([found[i]["samples"] for i in (0, 1)], traces)
    (tmp_path / "r1.csv").write_text((tmp_path / "r1.csv").read_text().replace("17000", "19000"))
    said = refused(tmp_path, cli, *three(tmp_path), *options, *INTERVAL)
    assert "IMU and radar 1 have 0.0 s in common" in said


@pytest.mark.parametrize("scale", [None, 0.01, 1000.0])
def test_a_column_of_antennas(scale: float | None, tmp_path: Path, cli: Cli) -> None:
    """Ids are not scaled as samples are."""
    traces, _ = radar_tables(tmp_path)
    time = drive()["time"][::5]
    told = np.repeat([3, 1], len(time))
    samples = np.concatenate(traces) / (scale or 1.0)
    header = "t,id," + ",".join(f"s{i}" for i in range(12))
    table(tmp_path / "r.csv", header, np.tile(time, 2), told, samples)
    options = ["--gpr", str(tmp_path / "r.csv"), "--gpr-antenna", "id", *INTERVAL]
    options += [] if scale is None else ["--gpr-scale", str(scale)]
    assert "Give --gpr-columns" in refused(tmp_path, cli, *three(tmp_path), *options, code=2)
    options += ["--gpr-columns", "t,3-14"]
    radar = convert(tmp_path, *three(tmp_path), *options)["GPR_TRACE"]
    for antenna, expected in zip((3, 1), traces, strict=True):
        mine = apart(radar)[antenna]
        np.testing.assert_array_equal(mine["samples"], expected)
        assert mine["seq"].tolist() == list(range(len(time)))
    said = refused(tmp_path, cli, *three(tmp_path), *options, "--gpr", tmp_path / "r.csv", code=2)
    assert "not of several" in said
    table(tmp_path / "r.csv", header, np.tile(time, 2), told + 0.5, samples)
    said = refused(tmp_path, cli, *three(tmp_path), *options, "--strict")
    assert "a whole number of 32 bits in column 2" in said
