"""Runs one method on one sequence (zip, folder or log) and returns the trajectory."""

import argparse
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from pkgutil import resolve_name

import numpy as np

from gprodom.arrays import Floats
from gprodom.config import STANDARD, Channels, Configs, read_channels
from gprodom.convert.cmu import read_recording
from gprodom.convert.plausible import check_streams
from gprodom.convert.streams import streams
from gprodom.errors import Error
from gprodom.files import temporary_folder
from gprodom.lcm import logs
from gprodom.lcm.log_writer import write_log
from gprodom.odometry.dead_reckoning import wheel_and_gyro
from gprodom.odometry.displacement import reckon, sequential
from gprodom.odometry.method import Method
from gprodom.odometry.methods import METHODS
from gprodom.odometry.replay import run_replay
from gprodom.score.answered import Answered, answered
from gprodom.score.frames import FrameStart
from gprodom.score.jumps import MapJumps
from gprodom.score.sources import kind_of, read_estimate
from gprodom.trajectory import Trajectory, read_tum

OnProgress = Callable[[float], None]
OnWarning = Callable[[str], None]


@dataclass(frozen=True)
class FixAntenna:
    """place: in body, m. delay: of its positions, s."""

    place: Floats
    delay: float

    def track(self, body: Trajectory) -> Trajectory:
        """Of the antenna, with the stamps that its positions have."""
        moved = body.moved(self.place)
        return replace(moved, time=moved.time + round(self.delay * 1e6))


@dataclass(frozen=True)
class Estimate:
    """The result of a method on a log.

    trajectory: as published (causal).
    jumps: of `map`, if a replay has them.
    frame: where the last frame of the trajectory begins; None: all of it is in one.
    antennas: of position fixes by their ids, as `smoothed` finds them.
    smoothed: from one solution over all data, if requested and if the method has one.
    answered: how often the radar had an answer, where the estimator was told any.
    """

    trajectory: Trajectory
    jumps: MapJumps | None = None
    smoothed: Trajectory | None = None
    answered: Answered | None = None
    frame: FrameStart | None = None
    antennas: Mapping[int, FixAntenna] = field(default_factory=dict)


def as_log(
    source: Path, folder: Path, sample_interval: float | None = None, channels: Channels = STANDARD
) -> Path:
    """`source` itself where it is a log; a sequence is converted into `folder`, to `channels`.

    sample_interval: s, of the radar; None: what the sequence says.
    """
    kind = kind_of(source)
    if kind == "log":
        return source
    if kind != "sequence":
        raise Error(f"{source}: expected a sequence (directory or zip) or an LCM log")
    log = folder / "input.lcmlog"
    recording = read_recording(source)
    made = streams(recording, sample_interval or recording.sample_interval, channels)
    check_streams(made)
    write_log(log, made)
    return log


def read_sensors(args: argparse.Namespace, source: Path, *roles: str) -> logs.Log:
    """The channels of those roles of a sequence (converted for it) or log, by role.


    `args`: of a command with `gprodom.options.add_config_options` and, if it likes, a
    `sample_interval`.
    """
    channels = read_channels(args.configs, args.overrides)
    interval = getattr(args, "sample_interval", None)
    with temporary_folder() as folder:
        return logs.read_roles(as_log(source, folder, interval, channels), channels.of(*roles))


def estimate(
    log: Path,
    method: Method,
    configs: Configs,
    overrides: Sequence[str],
    output: Path,
    on_progress: OnProgress | None = None,
    smooth: bool = False,
    on_warning: OnWarning | None = None,
) -> Estimate:
    """Runs `method` on `log`. A replay writes its log to `output`; `wheel` needs none.

    `smooth`: solve over all data, too. Dead reckoning has no such solution.
    `on_warning` is called with each warning of the estimator.
    """
    channels = read_channels(configs, [*method.overrides, *overrides])
    sensors = channels.of("imu", "wheel")
    if method.reckoned == "wheel":
        return Estimate(wheel_and_gyro(logs.read_roles(log, sensors)))
    with temporary_folder() as folder:
        tum = folder / "smoothed.tum" if smooth and not method.reckoned else None
        if method.teller:
            log = _with_answers(log, method, configs, overrides, folder)
        stats = run_replay(
            log,
            output,
            configs,
            [*method.overrides, *overrides],
            on_progress,
            tum,
            on_warning,
            poses_needed=not method.reckoned,
        )
        if method.reckoned == "displacements":
            found = logs.read_roles(output, channels.of("displacement"))
            displacements = sequential(found, method.front_end)
            return Estimate(reckon(logs.read_roles(log, sensors), displacements))
        published = read_estimate(output, channels=channels)
        role = "displacement_in" if method.teller else "displacement"
        told = logs.read_roles(log if method.teller else output, channels.of(role)).get(role)
        heard = answered(told, published.trajectory.time)
        smoothed = None if tum is None else read_tum(tum)
    antennas = {
        int(name): FixAntenna(np.array(found["place"]), found["delay"])
        for name, found in stats["antennas"].items()
    }
    return Estimate(
        published.trajectory, published.jumps, smoothed, heard, published.frame, antennas
    )


def _with_answers(
    log: Path, method: Method, configs: Configs, overrides: Sequence[str], folder: Path
) -> Path:
    """A log in `folder` in which the method's teller has answered the traces. Its
    track, where it needs one, is that of IMU and wheel."""
    from gprodom.lcm.answers import answers_to, with_answers

    channels = read_channels(configs, [*method.overrides, *overrides])
    track = folder / "track.lcmlog" if method.tracked else None
    if track is not None:
        run_replay(log, track, configs, [*overrides, *METHODS["imu_wheel"].overrides])
    answers = answers_to(log, resolve_name(method.teller)(method.source), channels, track)
    told = folder / "answers.lcmlog"
    with_answers(log, answers, channels, told)
    return told
