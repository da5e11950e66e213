"""Recordings of real robots: their files, how good their truth is, and how they become logs.

The table is of the shared data (data/README.md and robots/SOURCES.txt there). Any other folder has
a description file, recordings.yaml, in it:

    NAME:
      source: where it is from             # optional
      accelerometer: FILE.csv              # of `gprodom convert tables`, in the folder
      gyroscope: FILE.csv
      wheel: FILE.csv                      # speeds, m/s
      position: FILE.csv                   # truth, m
      left: 1                              # optional: columns of the wheels of a side
      right: 2
      truth_sigma_m: 0.03                  # noise of a coordinate of the truth
      truth_delay_sigma_s: 0.03            # how well its clock agrees with the robot's
      points: true                         # false: the truth is good for the distance alone
      settings: [wheel.track=0.5]          # optional: what a user measures with a tape
    NAME:
      bag: FILE.bag                        # of `gprodom convert bag`, with topics
      imu: /imu/data
      wheel: /odom
      truth: /fix
      truth_sigma_m: 1.0
      truth_delay_sigma_s: 0.0
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import yaml

from gprodom.errors import Error
from gprodom.score.consistency import TruthError
from program import command

DESCRIPTION = "recordings.yaml"
TABLES = ("accelerometer", "gyroscope", "wheel", "position")
TOPICS = ("imu", "wheel", "truth")


@dataclass(frozen=True)
class Recording:
    """files: in its folder. options: of gprodom convert, after the files. settings: what a user
    measures with a tape. points: whether the truth tells positions, and not only how far the robot
    came. source: of `truth`."""

    files: tuple[str, ...]  # four tables, or a bag
    truth: TruthError
    source: str
    options: tuple[str, ...] = ()
    settings: tuple[str, ...] = ()
    points: bool = True


def _tables(folder: str, wheel: str, truth: TruthError, source: str) -> Recording:
    names = ("accelerometer.csv", "gyroscope.csv", wheel, "position.csv")
    return Recording(tuple(f"{folder}/{name}" for name in names), truth, source)


def _bag(path: str, imu: str, wheel: str, position: str, truth: TruthError) -> Recording:
    options = (f"--imu={imu}", f"--wheel={wheel}", f"--truth={position}")
    return Recording((path,), truth, "robot_localization, test data", options)


# Noise of a coordinate (m) and of the clock (s) of the truth, one standard deviation each. Clocks
# that the data shifted by correlation are as good as that fit.
RTK = TruthError(0.03, 0.03)  # a fix of some centimetres, and a twentieth of its interval of 0.2 s
LIDAR = TruthError(0.03, 0.1)  # scan matching; half an interval of its 4 to 5 Hz
# A particle filter: white noise of 0.02 m and jumps of 0.3 to 1.1 m, so that it is off by a third
# of these for a while; stamps of scans at 40 Hz, of a computer that was busy.
PARTICLES = TruthError(0.1, 0.05)
CAPTURE = TruthError(0.002, 0.05)  # motion capture; its clock was set by correlation, to 0.05 s
GPS = TruthError(1.0, 0.0)
POINT_GPS = TruthError(2.0, 0.0)  # single-point: 1.6 to 2.7 m by its own word
VISUAL = TruthError(5.0, 0.0)  # stereo odometry, which drifts

_WARTHOG = _tables("warthog_a", "wheels.csv", LIDAR, "norlab DRIVE")
_PAIR = replace(
    _WARTHOG,
    options=("--left=1", "--right=2"),
    settings=("wheel.drive=skid_steer", "wheel.track=1.08"),
)
_XSENS = ("/xsens/imu_data", "/wheel_odometry", "/stereo_odometer/odometry")
RECORDINGS = {
    "wid02": _tables("wid02", "wheel.csv", RTK, "ansfl WID, trial 02"),
    "wid09": _tables("wid09", "wheel.csv", RTK, "ansfl WID, trial 09"),
    "warthog_a": _WARTHOG,
    "warthog_a (pair)": _PAIR,
    "husky": _bag("husky.bag", "/imu/data", "/husky_velocity_controller/odom", "/fix", GPS),
    "f1tenth1": _tables("f1tenth1", "wheel.csv", PARTICLES, "FrictionMaps DS1"),
    "f1tenth2": _tables("f1tenth2", "wheel.csv", PARTICLES, "FrictionMaps DS2"),
    "f1tenth3": _tables("f1tenth3", "wheel.csv", PARTICLES, "FrictionMaps DS3"),
    "phil1": _tables("phil1", "wheels.csv", CAPTURE, "PHIL, turtlebot mocap 1"),
    "phil2": _tables("phil2", "wheels.csv", CAPTURE, "PHIL, turtlebot mocap 2"),
    "phil8": _tables("phil8", "wheels.csv", CAPTURE, "PHIL, turtlebot mocap 8"),
    "s5t1": _tables("s5t1", "wheels.csv", POINT_GPS, "corenav-GP"),
    "car": replace(_tables("car", "wheel_speed.csv", RTK, "comma2k19, example"), points=False),
    "xsens_skid": replace(_bag("xsens_skid/test1.bag", *_XSENS, VISUAL), points=False),
}


def recordings_of(folder: Path) -> dict[str, Recording]:
    """The recordings of a folder, by name: those of its description file; without one those of the
    table that are there."""
    described = folder / DESCRIPTION
    if described.is_file():
        return read_description(described)
    there = {
        name: recording
        for name, recording in RECORDINGS.items()
        if all((folder / file).is_file() for file in recording.files)
    }
    if not there:
        raise Error(f"{folder}: no recording that is known; describe them in {described}")
    return there


def chosen(folder: Path, only: Sequence[str]) -> dict[str, Recording]:
    """Those that --only names, or all of a folder."""
    known = recordings_of(folder)
    if unknown := [name for name in only if name not in known]:
        raise Error(f"--only {unknown[0]}: expected some of {', '.join(known)}")
    return {name: known[name] for name in only or known}


def read_description(path: Path) -> dict[str, Recording]:
    """Of a description file."""
    content = yaml.safe_load(path.read_text(encoding="utf-8"))
    if not isinstance(content, dict) or not content:
        raise Error(f"{path}: expected recordings by name")
    return {str(name): _described(f"{path}: {name}", each) for name, each in content.items()}


def _described(where: str, given: Any) -> Recording:
    if not isinstance(given, Mapping):
        raise Error(f"{where}: expected keys and values")
    rest = dict(given)

    def take(key: str, default: Any = None) -> Any:
        if key not in rest and default is None:
            raise Error(f"{where}: {key} is missing")
        return rest.pop(key, default)

    if "bag" in rest:
        files: tuple[str, ...] = (str(take("bag")),)
        options = tuple(f"--{name}={take(name)}" for name in TOPICS)
    else:
        files = tuple(str(take(name)) for name in TABLES)
        options = tuple(f"--{side}={rest.pop(side)}" for side in ("left", "right") if side in rest)
    try:
        truth = TruthError(float(take("truth_sigma_m")), float(take("truth_delay_sigma_s")))
    except (TypeError, ValueError):
        raise Error(f"{where}: truth_sigma_m and truth_delay_sigma_s: expected numbers") from None
    settings = tuple(str(setting) for setting in take("settings", []))
    source, points = str(take("source", "")), bool(take("points", True))
    if rest:
        raise Error(f"{where}: unknown key {next(iter(rest))}")
    return Recording(files, truth, source, options, settings, points)


def convert(recording: Recording, folder: Path, log: Path) -> None:
    """To an LCM log, by the command a user would give."""
    paths = [folder / file for file in recording.files]
    if len(paths) == len(TABLES):
        kinds = ("accelerometer", "gyroscope", "wheel-speed", "position")
        named = zip(kinds, paths, strict=True)
        given = ["tables", *(f"--{kind}={path}" for kind, path in named), *recording.options]
    else:
        given = ["bag", str(paths[0]), *recording.options]
    command("convert", *given, "-o", log)
