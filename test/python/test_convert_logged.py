"""Tables as loggers write them: all sensors in one, with empty cells, faults, restarts, gaps."""

import os
import sys
import threading
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from conftest import Cli, run_program
from gprodom.convert.rows import BLOCK_BYTES
from gprodom.convert.wheels import continued
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
