"""``gprodom export``: an estimate in the formats of other programs."""

import argparse
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from gprodom.arrays import Bools, Ints
from gprodom.config import Channels, read_antennas, read_channels, read_datum, read_lever_arm
from gprodom.console import tell
from gprodom.errors import Error, UsageError
from gprodom.files import OutputFile, OutputFolder
from gprodom.fixes.site import datum_of_log
from gprodom.geodesy import Datum
from gprodom.lcm import logs
from gprodom.lcm.antennas import counts, named, of_antenna
from gprodom.options import Subparsers, add_command, numbers
from gprodom.score.sources import FRAMES, read_estimate
from gprodom.trajectory import Trajectory, interpolate

DESCRIPTION = """\
Writes the estimate in a log of gprodom-replay, `gprodom run -o` or gprodomd:

  --geojson  the path as a line of longitude, latitude and height
  --gpx      the path as a track
  --csv      a row for each pose; with --datum latitude, longitude and height, too
  --traces   a row for each radar trace: time, x, y, z, sigma, antenna_id
  --segy     the traces with their coordinates, the antenna_id as the trace's number in its record
  --mcap     all of it for ROS 2 tools and Foxglove: odometry, path, transforms, status, radar
  --rosbag2  the same as the folder of a ROS 2 bag with SQLite, a new one
  --rosbag   the same as a ROS 1 bag
  --layout   panels for these in Foxglove: import it there (Layouts, Import from file)

The first two need a datum: the position of the frame's origin, in degrees and metres, and the
angle from east to its x axis, in degrees. Where fixes have tied map to site, poses and traces are
in site, and its datum is what the estimator's status, anchor.datum of the configuration or the
first fix in degrees (in OUT or the log of --radar) tells; --datum goes before that.

The place of a trace is that of its antenna, by gpr.antennas; where that is empty, of the first one
heard, at gpr.lever_arm (-c, --set). Traces of other antennas, and those outside the estimate's
time, are left out and counted; --antenna leaves out all but one. If OUT has no traces, --radar
names the log that has them (and the other sensors, for speeds and dead reckoning). GeoJSON, GPX
and SEG-Y need pyproj, gpxpy and segyio (the extra `export`; Debian has them), MCAP and bags need
rosbags (the extra `bag`).

examples:
  gprodom export out.lcmlog --datum 52.3906,13.0645,40 --geojson path.geojson --gpx path.gpx
  gprodom export out.lcmlog --radar in.lcmlog --traces traces.csv --segy survey.sgy
  gprodom export out.lcmlog --radar in.lcmlog --mcap drive.mcap --layout drive.json
"""

Place = tuple[float, float, float]  # m, in body

RECORDINGS = ("mcap", "rosbag2", "rosbag")
FOLDERS = ("rosbag2",)
OUTPUTS = ("geojson", "gpx", "csv", "traces", "segy", *RECORDINGS, "layout")


_DATUM = numbers(
    "LAT,LON[,HEIGHT[,YAW]] in degrees, m and degrees",
    lambda v: 2 <= len(v) <= 4 and abs(v[0]) <= 90 and abs(v[1]) <= 180 and np.isfinite(v).all(),
)


def parse_datum(text: str) -> Datum:
    """LAT,LON[,HEIGHT[,YAW]]."""
    return Datum(*_DATUM(text))


def add_parser(subparsers: Subparsers) -> None:
    """Adds ``export``."""
    parser = add_command(
        subparsers, "export", "write the estimate for other programs", DESCRIPTION, run
    )
    parser.operand("log", "OUT", "log with the estimate")
    for name in OUTPUTS:
        kind, metavar = (OutputFolder, "FOLDER") if name in FOLDERS else (OutputFile, "FILE")
        parser.option(f"--{name} {metavar}", kind, "see above")
    parser.choice("--frame", FRAMES, "map", "default %(default)s")
    parser.option("--datum LAT,LON[,HEIGHT[,YAW]]", parse_datum, "see above")
    parser.option("--radar LOG", Path, "log with the radar's traces")
    parser.option("--antenna ID", int, "of --traces and --segy: its traces alone")
    parser.common_options()


def run(args: argparse.Namespace) -> int:
    """Writes the requested files."""
    wanted = [name for name in OUTPUTS if getattr(args, name) is not None]
    if not wanted:
        raise UsageError(f"nothing to do: give some of {', '.join('--' + n for n in OUTPUTS)}")
    if args.rosbag2 and args.rosbag2.exists():
        raise UsageError(f"{args.rosbag2}: exists already; name a new folder for --rosbag2")
    from gprodom.export.layout import write_layout
    from gprodom.export.paths import write_csv, write_geojson, write_gpx, write_traces
    from gprodom.export.segy import write_segy

    channels = read_channels(args.configs, args.overrides)
    datum = args.datum
    if datum is None and args.frame == "map":
        configured = read_datum(args.configs, args.overrides)
        datum = datum_of_log(args.log, channels, configured, [args.radar] if args.radar else [])
    if datum is None and (args.geojson or args.gpx):
        raise UsageError(
            "--geojson and --gpx want --datum LAT,LON, where the frame's origin lies: no fixes "
            f"have tied {args.log} to a datum that it tells"
        )
    trajectory = read_estimate(args.log, args.frame, channels).trajectory
    facts: dict[str, object] = {"poses": len(trajectory)}
    if args.geojson:
        write_geojson(args.geojson, {args.log.stem: trajectory}, datum)
    if args.gpx:
        write_gpx(args.gpx, trajectory, datum, args.log.stem)
    if args.csv:
        write_csv(args.csv, trajectory, datum)
    if any(getattr(args, form) for form in RECORDINGS):
        facts["messages"] = _write_recordings(args, channels)
    if args.layout:
        write_layout(args.layout, trajectory)
    if args.traces or args.segy:
        radar = logs.need(
            logs.read_roles(args.radar or args.log, channels.of("gpr_trace")), "gpr_trace"
        )
        if args.antenna is not None:
            radar = of_antenna(radar, args.antenna)
        places = places_of(args, radar)
        known = np.isin(radar["antenna_id"], list(places))
        poses, kept = poses_of_traces(trajectory, radar, places)
        facts["traces"] = len(poses)
        facts["traces_without_pose"] = int(np.count_nonzero(known & ~kept))
        if not known.all():
            facts["traces_of_other_antennas"] = int(np.count_nonzero(~known))
        antennas = radar["antenna_id"][kept]
        if args.traces:
            write_traces(args.traces, poses, antennas)
        if args.segy:
            write_segy(args.segy, poses, *alike(radar, kept), antennas)
    words = ", ".join(f"{value} {name.replace('_', ' ')}" for name, value in facts.items())
    tell(args.json, facts, words)
    return 0


def _write_recordings(args: argparse.Namespace, channels: Channels) -> int:
    """Those for ROS; how many messages one holds."""
    from gprodom.drive.log import read_drive
    from gprodom.export.ros import write_ros

    roles = channels.of("odometry", "odometry_map", "correction", "status", "gpr_trace")
    found = logs.read_roles(args.log, roles)
    if args.radar:
        found |= logs.read_roles(args.radar, channels.of("gpr_trace"))
    drive = read_drive(args.log, channels, args.radar) if "odometry" in found else None
    paths = {form: getattr(args, form) for form in RECORDINGS}
    return max(write_ros(path, found, form, drive) for form, path in paths.items() if path)


def places_of(args: argparse.Namespace, radar: logs.Channel) -> dict[int, Place]:
    """Of the antennas in body, by the configuration as the estimator takes it."""
    alone = {next(iter(counts(radar))): read_lever_arm(args.configs, args.overrides)}
    return read_antennas(args.configs, args.overrides) or alone


def poses_of_traces(
    trajectory: Trajectory, radar: logs.Channel, places: Mapping[int, Place]
) -> tuple[Trajectory, Bools]:
    """Poses of the antennas at their traces' times, and which traces have one: those within the
    time of the estimate, of an antenna whose place in body is known.
    """
    time, antennas = radar["utime"], radar["antenna_id"]
    within = (time >= trajectory.time[0]) & (time <= trajectory.time[-1])
    kept = within & np.isin(antennas, list(places))
    if not kept.any():
        raise Error(
            "none of the traces was taken while there was an estimate"
            if not within.any()
            else f"gpr.antennas has the place of none of the antennas heard: {named(radar)}"
        )
    poses = interpolate(trajectory, time[kept])
    position = poses.position.copy()
    for antenna, place in places.items():
        mine = antennas[kept] == antenna
        if any(place) and mine.any():
            position[mine] = poses.select(mine).moved(np.array(place)).position
    return replace(poses, position=position), kept


def alike(radar: logs.Channel, kept: Bools) -> tuple[Ints, float]:
    """The samples (n, samples) of the traces that are kept, and the time between them, s: of SEG-Y
    the same for all."""
    intervals = np.unique(radar["sample_interval"][kept])
    samples = [radar["samples"][row] for row in np.flatnonzero(kept)]
    lengths = {len(trace) for trace in samples}
    if len(lengths) > 1 or len(intervals) > 1:
        raise Error(
            f"SEG-Y: traces of {len(lengths)} lengths and {len(intervals)} sample intervals do not "
            f"fit into one file; there are those of the antennas {named(radar)}: choose with "
            "--antenna"
        )
    return np.stack(samples), float(intervals[0])
