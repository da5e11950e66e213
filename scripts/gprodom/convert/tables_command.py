"""``gprodom convert tables``: a robot's own tables to an LCM log."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from gprodom.arrays import Floats, Ints
from gprodom.config import Channels, read_channels
from gprodom.console import add_json_flag, warn
from gprodom.convert.any_table import read_source
from gprodom.convert.bag import (
    gpr_stream,
    imu_stream,
    truth_stream,
)
from gprodom.convert.bag_command import write_and_tell
from gprodom.convert.layout import (
    CHOICES,
    NUMBERS,
    SOURCES,
    TIME_UNITS,
    Layout,
    Source,
    read_layout,
)
from gprodom.convert.sampling import sample_interval
from gprodom.convert.survey_files import SUFFIXES, decide, read_line
from gprodom.convert.table import Table
from gprodom.convert.wheels import added_up, continued, pair_stream, wheel_stream
from gprodom.errors import Error, UsageError
from gprodom.files import OutputFile
from gprodom.fixes.table import WIDTHS, fixes_of_table
from gprodom.geodesy import local_positions
from gprodom.lcm.log_writer import Stream
from gprodom.options import Subparsers, add_command, add_config_options

EXAMPLES = """\
  gprodom convert tables --accelerometer accelerometer.csv --gyroscope gyroscope.csv \\
    --wheel-speed wheel_speed.csv --position position.csv -o car.lcmlog
  gprodom convert tables drive.csv --imu-columns stamp,ax,ay,az,gx,gy,gz --acceleration-unit g \\
    --rate-unit deg/s --wheel-counts-columns stamp,left,right --counts-per-metre 5200 -o d.lcmlog
  gprodom convert tables --layout robot.yaml drive.csv -o drive.lcmlog
"""

DESCRIPTION = (
    """\
Converts tables (CSV) of a robot's sensors to an LCM log. All may be in one TABLE, or each in a file
of its own. --imu-columns and so on say which columns are what, by name or by number from 1, the
time first; 2-202 is a range of numbers. Where nothing is said they are the first, in this order:

"""
    + "\n".join(f"  --{name.replace('_', '-'):<15} time, {what}" for name, what in SOURCES.items())
    + """

A wheel and either --imu or both --accelerometer and --gyroscope are wanted; acceleration is then
brought to the gyroscope's times, where both are there. Of several wheels the mean is taken, or that
of each side where --left and --right say which wheels, counted from 1, are on it. The radar (--gpr)
is a table, or a survey file (DT1, DZT, RD3, RD7, IPRB with their headers) with --gpr-times.
Positions in degrees (--position-unit degrees) become metres from the first.

Fixes (--fix) have three columns of the position: x, y, z in site, or with --fix-unit degrees
latitude, longitude, height; then none, three standard deviations or the six values xx, xy, xz, yy,
yz, zz of a covariance (m, m^2; of degrees' fixes east, north, up), and perhaps the quality as
--fix-quality-code tells. Without a quality, 5 cm and less are `fixed`, more is `float`.

--layout takes the same from a YAML file, with the same names and underscores:

  acceleration_unit: g
  rate_unit: deg/s
  counts_per_metre: 5200
  imu: {columns: [stamp, ax, ay, az, gx, gy, gz]}
  wheel_counts: {columns: [stamp, left, right]}
  gpr: {file: radar.csv, columns: [t, 2-202], time_unit: ms}

In a table of all sensors a slower one leaves its cells empty. Lines that cannot be used (a comment,
a cell without a number, a last line cut short) are left out and counted; a counter that starts
again at zero, or overflows, is carried on. Rows are sorted by time, and repeated ones left out.

What is plainly not a robot's (g for m/s^2, degrees, counts for a speed, stamps in another unit,
sensors without a time in common) is refused; what is doubtful is said.
"""
)
_MAX_GAP = 5.0  # times its median interval, across which the accelerometer is not interpolated
_WHEELS = ("wheel_speed", "wheel_distance", "wheel_counts")


def add_parser(formats: Subparsers) -> None:
    """Adds ``convert tables``."""
    parser = add_command(formats, "tables", "a robot's own tables", DESCRIPTION, EXAMPLES)
    parser.add_argument("table", metavar="TABLE", type=Path, nargs="?", help="see above")
    parser.add_argument(
        "-o", "--output", metavar="LOG", type=OutputFile, required=True, help="LCM log"
    )
    parser.add_argument("--layout", metavar="YAML", type=Path, help="see above")
    for name in SOURCES:
        option = "--" + name.replace("_", "-")
        parser.add_argument(option, metavar="FILE", type=Path, help="see above")
        parser.add_argument(f"{option}-columns", metavar="TIME,A,..", help=argparse.SUPPRESS)
    parser.add_argument(
        "--time-unit", choices=list(TIME_UNITS), help="unit of the times (default s)"
    )
    for key, choices in CHOICES.items():
        default = next(iter(choices))
        parser.add_argument(
            "--" + key.replace("_", "-"), choices=list(choices), help=f"default {default}"
        )
    for side in ("left", "right"):
        parser.add_argument(
            f"--{side}",
            metavar="WHEELS",
            type=_wheel_numbers,
            default=[],
            help=f"wheels of the {side} side by their columns, such as 1,3",
        )
    parser.add_argument(
        "--counts-per-metre", metavar="N", type=float, help="counts of --wheel-counts per metre"
    )
    parser.add_argument(
        "--sample-interval",
        metavar="S",
        type=sample_interval,
        help="seconds between radar samples (default: the survey file's)",
    )
    parser.add_argument(
        "--gpr-scale",
        metavar="N",
        type=float,
        help="counts per unit of the samples of --gpr, where they are no whole numbers (volts)",
    )
    parser.add_argument(
        "--fix-sigma",
        metavar="M",
        type=float,
        help="standard deviation of each axis of --fix, where its table has no column of it",
    )
    parser.add_argument(
        "--strict",
        action="store_true",
        help="refuse a table with a line that cannot be used, instead of leaving it out",
    )
    parser.add_argument(
        "--delimiter", metavar="C", help="default: semicolon or tab if there is one, else comma"
    )
    add_config_options(parser)
    add_json_flag(parser)
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Converts and prints what there is."""
    layout = read_layout(args.layout, _options(args), args.table)
    channels = read_channels(args.configs, args.overrides)
    strict: bool = args.strict
    streams = [
        _imu(layout, channels, strict),
        _wheel(layout, channels, args.left, args.right, strict),
    ]
    if "gpr" in layout.sources:
        streams.append(_gpr(layout, channels, strict))
    if "position" in layout.sources:
        streams.append(_position(layout, strict))
    if "fix" in layout.sources:
        streams.append(_fixes(layout, channels, strict))
    write_and_tell(streams, args.output, args.json)
    return 0


def _options(args: argparse.Namespace) -> dict[str, Any]:
    """What was given on the command line, with the keys of a layout."""
    keys = ("time_unit", *CHOICES, *NUMBERS, "delimiter")
    options: dict[str, Any] = {key: getattr(args, key) for key in keys}
    for name in SOURCES:
        file, columns = getattr(args, name), getattr(args, f"{name}_columns")
        given: dict[str, Any] = {} if file is None else {"file": file}
        if columns is not None:
            given["columns"] = columns.split(",")
        if given:
            options[name] = given
    return options


def _read(layout: Layout, name: str, widths: Sequence[int], strict: bool, **options: Any) -> Table:
    """The table of a source, by its name."""
    what = ", ".join(filter(None, ("time", SOURCES[name])))
    return read_source(layout.sources[name], widths, what, strict=strict, **options)


def _imu(layout: Layout, channels: Channels, strict: bool) -> Stream:
    sources = layout.sources
    if "imu" in sources:
        table = _read(layout, "imu", (7,), strict)
        time, force, rate = table.utime, table.values[:, :3], table.values[:, 3:]
        late = table.out_of_order
    elif "accelerometer" in sources and "gyroscope" in sources:
        felt = _read(layout, "accelerometer", (4,), strict)
        turned = _read(layout, "gyroscope", (4,), strict)
        late = felt.out_of_order + turned.out_of_order
        kept = covered(turned.utime, felt.utime)
        if not kept.any():
            raise Error(
                "accelerometer and gyroscope have no time in common: are their stamps alike?"
            )
        if not kept.all():
            warn(
                f"IMU: {np.count_nonzero(~kept)} of {len(kept)} rows of the gyroscope are left "
                "out: the accelerometer has none there"
            )
        time, rate = turned.utime[kept], turned.values[kept]
        force = np.column_stack([np.interp(time, felt.utime, axis) for axis in felt.values.T])
    else:
        raise UsageError(
            "give --imu, or --accelerometer and --gyroscope (or name them in --layout)"
        )
    force, rate = force * layout.factor("acceleration_unit"), rate * layout.factor("rate_unit")
    return replace(imu_stream(channels.imu, time, force, rate), out_of_order=late)


def covered(time: Ints, by: Ints) -> Floats:
    """Which of `time` (n,) lie between two stamps of `by` (m,) without a gap between them."""
    right = np.searchsorted(by, time, side="left")
    exact = (right < len(by)) & (by[np.minimum(right, len(by) - 1)] == time)
    inside = (right > 0) & (right < len(by))
    step = by[np.minimum(right, len(by) - 1)] - by[np.maximum(right - 1, 0)]
    return np.asarray(exact | (inside & (step <= _MAX_GAP * max(np.median(np.diff(by)), 1))))


def _wheel(
    layout: Layout, channels: Channels, left: list[int], right: list[int], strict: bool
) -> Stream:
    given = [name for name in _WHEELS if name in layout.sources]
    if len(given) != 1:
        options = ", ".join("--" + name.replace("_", "-") for name in _WHEELS)
        raise UsageError(f"one of {options} is wanted, got {len(given)}")
    (name,) = given
    source = layout.sources[name]
    table = _read(layout, name, range(2, 20), strict)
    travelled = table.values
    if name != "wheel_speed":
        travelled = _continued(source, table)
    if name == "wheel_speed":
        _check_speed(source, table)
        travelled = added_up(table.utime, travelled * layout.factor("speed_unit"))
    elif name == "wheel_counts":
        if "counts_per_metre" not in layout.settings:
            raise UsageError("--wheel-counts: how many make a metre? Give --counts-per-metre N")
        travelled = travelled / float(layout.settings["counts_per_metre"])
    travelled = travelled - travelled[0]
    if not left and not right:
        stream = wheel_stream(channels.wheel, table.utime, travelled.mean(axis=1))
        return replace(stream, out_of_order=table.out_of_order)
    wheels = travelled.shape[1]
    if not left or not right or max(left + right) > wheels:
        raise UsageError(f"--left and --right: expected wheels 1 to {wheels} for both sides")
    sides = (travelled[:, [wheel - 1 for wheel in side]].mean(axis=1) for side in (left, right))
    stream = pair_stream(channels.wheels, table.utime, *sides)
    return replace(stream, out_of_order=table.out_of_order)


def _continued(source: Source, table: Table) -> Floats:
    """The values (n, wheels) of counters that went on where they began again; that is told."""
    columns = [continued(table.utime, column) for column in table.values.T]
    for wheel, column in enumerate(columns, start=1):
        for count, how in ((column.restarts, "starts again at zero"), (column.wraps, "overflows")):
            if count:
                warn(
                    f"{source.file}: the counter of wheel {wheel} {how} {count} times, first "
                    f"{column.first_s:.1f} s after its first row: it is carried on there"
                )
    return np.column_stack([column.values for column in columns])


def _wheel_numbers(text: str) -> list[int]:
    try:
        numbers = [int(part) for part in text.split(",")]
    except ValueError:
        numbers = [0]
    if min(numbers) < 1:
        raise argparse.ArgumentTypeError(f"{text!r}: expected numbers of wheels, from 1")
    return numbers


def _check_speed(source: Source, table: Table) -> None:
    """Detects a column of speed that is a distance or a count: it never falls."""
    lasts = float(table.utime[-1] - table.utime[0]) * 1e-6
    for column in table.values.T:
        steps = np.diff(column)
        if lasts > 10 and np.all(steps >= 0) and np.count_nonzero(steps) > 0.2 * len(steps):
            raise Error(
                f"{source.file}: the wheel's speed grows for {lasts:.0f} s and never falls: is it "
                "a distance or a count (--wheel-distance, --wheel-counts with --counts-per-metre)?"
            )


def _gpr(layout: Layout, channels: Channels, strict: bool) -> Stream:
    source = layout.sources["gpr"]
    interval = layout.settings.get("sample_interval")
    assert source.file is not None
    if source.file.suffix.lower() not in SUFFIXES:
        if interval is None:
            raise UsageError(
                "--gpr: what is the time between its samples? Give --sample-interval S, such as "
                "2e-10 (s)"
            )
        scale = layout.settings.get("gpr_scale")
        table = _read(layout, "gpr", range(9, 16_385), strict, integers=True, scale=scale)
        stream = gpr_stream(channels.gpr_trace, table.utime, table.values, interval, 0.0)
        return replace(stream, out_of_order=table.out_of_order)
    line = decide(read_line(source.file), source.file, sample_interval=interval)
    if "gpr_times" not in layout.sources:
        raise UsageError(f"{source.file}: holds no times: give --gpr-times, a row for each trace")
    times = _read(layout, "gpr_times", (1,), strict=True)  # a row for each trace, none left out
    if len(times.utime) != len(line.traces):
        raise Error(
            f"{source.file}: {len(line.traces)} traces, but {len(times.utime)} rows in "
            f"{layout.sources['gpr_times'].file}"
        )
    return gpr_stream(
        channels.gpr_trace, times.utime, line.traces, line.sample_interval, line.time_zero
    )


def _position(layout: Layout, strict: bool) -> Stream:
    table = _read(layout, "position", (4, 3), strict)
    position = table.values
    if position.shape[1] == 2:
        position = np.column_stack([position, np.zeros(len(position))])
    if layout.settings.get("position_unit") == "degrees":
        if np.abs(position[:, 0]).max() > 90 or np.abs(position[:, 1]).max() > 180:
            raise Error(
                f"{layout.sources['position'].file}: expected latitude and longitude in degrees, "
                "in this order"
            )
        position = local_positions(position)
    return replace(truth_stream(table.utime, position), out_of_order=table.out_of_order)


def _fixes(layout: Layout, channels: Channels, strict: bool) -> Stream:
    table = _read(layout, "fix", [1 + width for width in WIDTHS], strict)
    code = str(layout.settings.get("fix_quality_code", next(iter(CHOICES["fix_quality_code"]))))
    found = fixes_of_table(
        str(layout.sources["fix"].file),
        table.utime,
        table.values,
        layout.settings.get("fix_unit") == "degrees",
        code,
        layout.settings.get("fix_sigma"),
    )
    return replace(found.stream(channels.position_fix), out_of_order=table.out_of_order)
