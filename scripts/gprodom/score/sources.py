"""Reads trajectories from a log, a TUM file, a total station's CSV or a sequence."""

import re
import zipfile
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, get_args

from gprodom.config import STANDARD, TRUTH_CHANNEL, Channels
from gprodom.convert.cmu import parse_truth
from gprodom.convert.source import TRUTH, File, read_files
from gprodom.errors import Error
from gprodom.lcm import logs
from gprodom.score.frames import FrameStart, frame_start
from gprodom.score.jumps import MapJumps, find_jumps, summarise
from gprodom.trajectory import Trajectory, read_tum, without_repeats

Frame = Literal["map", "odom"]
FRAMES: tuple[Frame, ...] = get_args(Frame)
ROLES: dict[Frame, str] = {"map": "odometry_map", "odom": "odometry"}

LOG_MAGIC = b"\xed\xa1\xda\x01"
Kind = Literal["log", "tum", "csv", "sequence"]


class NoTruthError(Error):
    """The recording has no truth: it is valid, but cannot be scored."""


@dataclass(frozen=True)
class Source:
    """A trajectory, where it came from, and what a log tells: the jumps of `map`, and where the
    last frame of the trajectory begins (None: all of it is in one)."""

    path: Path
    kind: Kind
    trajectory: Trajectory
    jumps: MapJumps | None = None
    frame: FrameStart | None = None


def kind_of(path: Path) -> Kind:
    """What a file is, by its content."""
    if path.is_dir():
        return "sequence"
    if not path.exists():
        raise Error(f"{path}: no such file")
    with path.open("rb") as file:
        head = file.read(4096)
    if head.startswith(LOG_MAGIC):
        return "log"
    if zipfile.is_zipfile(path):
        return "sequence"
    line = _first_data_line(head)
    if line.count(",") == 3:
        return "csv"
    if len(line.replace(",", " ").split()) == 8:
        return "tum"
    raise Error(
        f"{path}: not a kind that can be scored; expected an LCM log, a TUM file "
        "(t x y z qx qy qz qw), a ts_meas.csv (Time[s],Px[m],Py[m],Pz[m]) or a sequence"
    )


def _first_data_line(head: bytes) -> str:
    for line in head.decode("utf-8", errors="replace").splitlines():
        if re.match(r"\s*[-+0-9.]", line):
            return line.strip()
    # A CSV with its header alone is still a total station's, only empty.
    first = head.decode("utf-8", errors="replace").splitlines()[:1]
    return first[0] if first and first[0].count(",") == 3 else ""


def read_estimate(path: Path, frame: Frame = "map", channels: Channels = STANDARD) -> Source:
    """The trajectory to be scored; from a log, that of `frame` as published."""
    kind = kind_of(path)
    if kind != "log":
        return Source(path, kind, _read_file(path, kind))
    found = logs.read_roles(path, channels.of(*ROLES.values(), "correction", "status"))
    if ROLES[frame] not in found:
        raise Error(
            f"{path}: holds no {getattr(channels, ROLES[frame])} messages; "
            + (
                f"score the other frame with --frame {'odom' if frame == 'map' else 'map'}"
                if any(role in found for role in ROLES.values())
                else "expected an output of gprodom run or gprodom-replay, or a record of gprodomd"
            )
        )
    trajectory = odometry(found[ROLES[frame]])
    if ROLES["odom"] not in found:
        return Source(path, kind, trajectory)
    odom = found[ROLES["odom"]]
    if frame == "odom":
        return Source(path, kind, trajectory, frame=frame_start(odom, None, []))
    jumps = find_jumps(found.get("correction"), odometry(odom))
    start = frame_start(odom, found.get("status"), jumps)
    return Source(path, kind, trajectory, summarise(jumps, start.utime if start else None), start)


def read_truth(path: Path, frame: Frame | None = "map", channels: Channels = STANDARD) -> Source:
    """The trajectory to score against.

    From a log: TOTAL_STATION, otherwise the estimate in `frame`; with None only TOTAL_STATION.
    """
    kind = kind_of(path)
    if kind != "log":
        return Source(path, kind, _read_file(path, kind))
    estimates = [] if frame is None else [getattr(channels, ROLES[frame])]
    found = logs.read(path, [TRUTH_CHANNEL, *estimates])
    if TRUTH_CHANNEL in found:
        content = found[TRUTH_CHANNEL]
        points = Trajectory(content["utime"], content["position"])
        return Source(path, kind, without_repeats(points))
    for channel in estimates:
        if channel in found:
            return Source(path, kind, odometry(found[channel]))
    wanted = " or ".join([TRUTH_CHANNEL, *estimates])
    raise NoTruthError(f"{path}: holds no {wanted} messages to score against")


def known_truth(path: Path) -> Trajectory | None:
    """The positions that a recording has beside it, if it has any."""
    try:
        return read_truth(path, frame=None).trajectory
    except NoTruthError:
        return None


def _read_file(path: Path, kind: Kind) -> Trajectory:
    if kind == "tum":
        return read_tum(path)
    if kind == "csv":
        file = File(str(path), path.read_bytes())
    else:
        files = read_files(path)
        if TRUTH not in files:
            raise NoTruthError(f"{path}: the sequence has no {TRUTH}, so no truth to score against")
        file = files[TRUTH]
    table = parse_truth(file)
    if table.utime.size == 0:
        raise NoTruthError(f"{file.label}: is empty: this sequence was recorded without truth")
    return without_repeats(Trajectory(table.utime, table.values))


def odometry(content: logs.Channel) -> Trajectory:
    """The trajectory of a channel of odometry_t messages."""
    count = content["utime"].size
    trajectory = Trajectory(
        content["utime"],
        content["position"],
        content["orientation"],
        content["pose_covariance"].reshape(count, 6, 6),
    )
    return without_repeats(trajectory)
