"""``gprodom convert tables``: a robot's own tables to an LCM log."""

import argparse
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from gprodom.arrays import Floats, Ints
from gprodom.config import Channels, read_channels
from gprodom.console import warn
from gprodom.convert.any_table import read_named, read_source
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
from gprodom.convert.sampling import add_sample_interval_option
from gprodom.convert.streams import gpr_stream, imu_stream, truth_stream
from gprodom.convert.survey_files import SUFFIXES, channel_numbers, chosen, decide, read_lines
from gprodom.convert.wheels import wheels_of_tables
from gprodom.errors import Error, UsageError
from gprodom.fixes.table import WIDTHS, fixes_of_table
from gprodom.geodesy import local_positions
from gprodom.lcm.log_writer import Stream
from gprodom.options import Subparsers, add_command, numbers

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
is a table, or a survey file (DT1, DZT, RD3, RD7, IPRB with their headers) with --gpr-times. Several
antennas are several --gpr, with antenna_id 0, 1, ... in the order given; or a column of ids, named
by --gpr-antenna; or the channels of a DZT, each with its number, all or those of --channels.
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

examples:
  gprodom convert tables --accelerometer accelerometer.csv --gyroscope gyroscope.csv \\
    --wheel-speed wheel_speed.csv --position position.csv -o car.lcmlog
  gprodom convert tables drive.csv --imu-columns stamp,ax,ay,az,gx,gy,gz --acceleration-unit g \\
    --rate-unit deg/s --wheel-counts-columns stamp,left,right --counts-per-metre 5200 -o d.lcmlog
  gprodom convert tables --layout robot.yaml drive.csv -o drive.lcmlog
"""
)
_MAX_GAP = 5.0  # times its median interval, across which the accelerometer is not interpolated


def add_parser(formats: Subparsers) -> None:
    """Adds ``convert tables``."""
    parser = add_command(formats, "tables", "a robot's own tables", DESCRIPTION, run)
    parser.operand("table", "TABLE", "see above", nargs="?")
    parser.output("LOG", "LCM log")
    parser.option("--layout YAML", Path, "see above")
    for name in SOURCES:
        option = "--" + name.replace("_", "-")
        several: dict[str, Any] = {"action": "append"} if name == "gpr" else {}
        parser.option(f"{option} FILE", Path, "see above", **several)
        parser.option(f"{option}-columns TIME,A,..", str, argparse.SUPPRESS)
    parser.choice("--time-unit", list(TIME_UNITS), None, "unit of the times (default s)")
    for key, choices in CHOICES.items():
        default = next(iter(choices))
        parser.choice("--" + key.replace("_", "-"), list(choices), None, f"default {default}")
    for side in ("left", "right"):
        parser.option(
            f"--{side} WHEELS",
            numbers("numbers of wheels, from 1", lambda values: min(values) >= 1, int),
            f"wheels of the {side} side by their columns, such as 1,3",
            default=[],
        )
    parser.option("--counts-per-metre N", float, "counts of --wheel-counts per metre")
    add_sample_interval_option(parser, "seconds between radar samples (default: the survey file's)")
    parser.option(
        "--gpr-scale N",
        float,
        "counts per unit of the samples of --gpr, where they are no whole numbers (volts)",
    )
    parser.option(
        "--gpr-antenna COLUMN",
        str,
        "that of --gpr which tells the antenna_id of each trace, with --gpr-columns",
    )
    parser.option(
        "--channels N,..", channel_numbers, "of a survey file given to --gpr (default: all)"
    )
    parser.option(
        "--fix-sigma M",
        float,
        "standard deviation of each axis of --fix, where its table has no column of it",
    )
    parser.flag(
        "--strict", "refuse a table with a line that cannot be used, instead of leaving it out"
    )
    parser.option("--delimiter C", str, "default: semicolon or tab if there is one, else comma")
    parser.common_options()


def run(args: argparse.Namespace) -> int:
    """Converts and prints what there is."""
    layout = read_layout(args.layout, _options(args), args.table)
    channels = read_channels(args.configs, args.overrides)
    strict: bool = args.strict
    streams = [
        _imu(layout, channels, strict),
        wheels_of_tables(layout, channels, args.left, args.right, strict),
    ]
    if "gpr" in layout.sources:
        streams += _gpr(layout, channels, strict)
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
        if name == "gpr":
            chosen = {
                "antenna": args.gpr_antenna,
                "channels": args.channels and list(args.channels),
            }
            given |= {key: value for key, value in chosen.items() if value is not None}
        if given:
            options[name] = given
    return options


def _imu(layout: Layout, channels: Channels, strict: bool) -> Stream:
    sources = layout.sources
    if "imu" in sources:
        table = read_named(layout, "imu", (7,), strict)
        time, force, rate = table.utime, table.values[:, :3], table.values[:, 3:]
        late = table.out_of_order
    elif "accelerometer" in sources and "gyroscope" in sources:
        felt = read_named(layout, "accelerometer", (4,), strict)
        turned = read_named(layout, "gyroscope", (4,), strict)
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


def _gpr(layout: Layout, channels: Channels, strict: bool) -> list[Stream]:
    """Of each antenna."""
    source = layout.sources["gpr"]
    assert source.file is not None
    if source.antenna and source.more:
        raise UsageError("--gpr-antenna: a column tells the antennas of one --gpr, not of several")
    made: list[Stream] = []
    antenna = 0
    for file in (source.file, *source.more):
        of_one = replace(source, file=file)
        if file.suffix.lower() in SUFFIXES:
            antenna += _add_lines(made, of_one, layout, channels, antenna)
        elif source.channels:
            raise UsageError(f"{file}: --channels are those of a survey file; this is a table")
        else:
            made += _table_traces(of_one, layout, channels, antenna, strict)
            antenna += 1
    return made


def _table_traces(
    source: Source, layout: Layout, channels: Channels, antenna: int, strict: bool
) -> list[Stream]:
    """Of the one antenna, or of those that a column tells."""
    interval = layout.settings.get("sample_interval")
    if interval is None:
        raise UsageError(
            "--gpr: what is the time between its samples? Give --sample-interval S, such as "
            "2e-10 (s)"
        )
    keys = 1 if source.antenna else 0
    if keys and not source.columns:
        raise UsageError("--gpr-antenna: which columns are time and samples? Give --gpr-columns")
    columns = (*source.columns[:1], *([source.antenna] if keys else []), *source.columns[1:])
    table = read_source(
        replace(source, columns=columns), range(9 + keys, 16_385 + keys),
        f"time, {'antenna, ' if keys else ''}{SOURCES['gpr'].partition(';')[0]}",
        integers=True, strict=strict, scale=layout.settings.get("gpr_scale"), keys=keys,
    )  # fmt: skip
    of = table.values[:, 0].astype(int) if keys else np.full(len(table.utime), antenna)
    return [
        replace(
            gpr_stream(
                channels.gpr_trace, table.utime[of == id_], table.values[of == id_, keys:],
                interval, 0.0, antenna_id=id_,
            ),
            out_of_order=table.out_of_order,
        )
        for id_ in np.unique(of).tolist()
    ]  # fmt: skip


def _add_lines(
    made: list[Stream], source: Source, layout: Layout, channels: Channels, antenna: int
) -> int:
    """The antennas of a survey file, the first of which has the id `antenna`; how many it has."""
    assert source.file is not None
    lines = read_lines(source.file)
    if "gpr_times" not in layout.sources:
        raise UsageError(f"{source.file}: holds no times: give --gpr-times, a row for each trace")
    times = read_named(layout, "gpr_times", (1,), strict=True)  # none left out
    if len(times.utime) != len(lines[0].traces):
        raise Error(
            f"{source.file}: {len(lines[0].traces)} traces, but {len(times.utime)} rows in "
            f"{layout.sources['gpr_times'].file}"
        )
    interval = layout.settings.get("sample_interval")
    for channel, line in chosen(source.file, source.channels or range(len(lines))).items():
        known = decide(line, source.file, sample_interval=interval)
        made.append(
            gpr_stream(
                channels.gpr_trace, times.utime, known.traces, known.sample_interval,
                known.time_zero, antenna_id=antenna + channel,
            )
        )  # fmt: skip
    return len(lines)


def _position(layout: Layout, strict: bool) -> Stream:
    table = read_named(layout, "position", (4, 3), strict)
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
    table = read_named(layout, "fix", [1 + width for width in WIDTHS], strict)
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
