"""``gprodom convert tables``: tables of a vehicle's sensors to an LCM log."""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

from gprodom.arrays import Floats, Ints
from gprodom.config import read_channels
from gprodom.console import add_json_flag
from gprodom.convert.bag import imu_stream, truth_stream, wheel_distance, wheel_stream
from gprodom.convert.bag_command import write_and_tell
from gprodom.convert.source import File
from gprodom.convert.table import Table, parse
from gprodom.errors import Error
from gprodom.options import Subparsers, add_command, add_config_options

EXAMPLES = """\
  gprodom convert tables --accelerometer accelerometer.csv --gyroscope gyroscope.csv \\
    --wheel-speed wheel_speed.csv --position position.csv -o car.lcmlog
"""

DESCRIPTION = """\
Converts tables of one sensor each to an LCM log. Each has a header line, then lines of time
(seconds) and values: accelerometer (3, m/s^2), gyroscope (3, rad/s), wheel speed (one column a
wheel, m/s; their mean is taken and added up), position (3, m; optional). Acceleration is brought to
the gyroscope's times.
"""


def add_parser(formats: Subparsers) -> None:
    """Adds ``convert tables``."""
    parser = add_command(
        formats, "tables", "tables of accelerometer, gyroscope, wheels", DESCRIPTION, EXAMPLES
    )
    for name in ("accelerometer", "gyroscope", "wheel-speed"):
        parser.add_argument(f"--{name}", metavar="CSV", type=Path, required=True)
    parser.add_argument("--position", metavar="CSV", type=Path, help="the truth")
    parser.add_argument("-o", "--output", metavar="LOG", type=Path, required=True, help="LCM log")
    add_config_options(parser)
    add_json_flag(parser)
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Converts and prints what there is."""
    force = _read(args.accelerometer, range(4, 5), "time, acceleration x, y, z")
    rate = _read(args.gyroscope, range(4, 5), "time, angular rate x, y, z")
    wheel = _read(args.wheel_speed, range(2, 20), "time, speeds")
    channels = read_channels(args.config, args.overrides)
    streams = [
        imu_stream(channels.imu, rate.utime, _at(rate.utime, force), rate.values),
        wheel_stream(channels.wheel, wheel.utime, _travelled(wheel)),
    ]
    if args.position is not None:
        position = _read(args.position, range(4, 5), "time, x, y, z")
        streams.append(truth_stream(position.utime, position.values))
    write_and_tell(streams, args.output, args.json)
    return 0


def _read(path: Path, columns: range, what: str) -> Table:
    table = parse(File(str(path), path.read_bytes()), columns, what)
    if len(table.utime) < 2:
        raise Error(f"{path}: expected rows of {what}")
    return table


def _at(time: Ints, table: Table) -> Floats:
    return np.column_stack([np.interp(time, table.utime, column) for column in table.values.T])


def _travelled(wheel: Table) -> Floats:
    return wheel_distance(wheel.utime, [(value,) for value in wheel.values.mean(axis=1).tolist()])
