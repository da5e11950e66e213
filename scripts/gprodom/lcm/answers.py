"""Displacements that are told to the estimator from outside: by a network, or a map of pipes. They
are put into a log that then drives the estimator."""

from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

import numpy as np

from gprodom import rotation
from gprodom.arrays import Floats
from gprodom.config import Channels
from gprodom.lcm import logs
from gprodom.lcm.antennas import choose
from gprodom.lcm.log_scan import events
from gprodom.lcm.log_writer import Stream, write_log
from gprodom.lcm.messages import message


@dataclass(frozen=True)
class Answer:
    """A displacement_t to be sent; times in microseconds, metres."""

    utime: int
    utime_from: int
    utime_to: int
    source: str
    kind: int
    distance: float
    sigma: float
    mirrored: bool = False
    score: float = 0.0


def encoded(answer: Answer) -> bytes:
    """Its displacement_t."""
    told = message("displacement_t")()
    for name, value in vars(answer).items():
        setattr(told, name, value)
    told.valid, told.scale = True, 1.0
    data: bytes = told.encode()
    return data


class Teller(Protocol):
    """What hears and tells."""

    def trace(self, utime: int, samples: Floats, sample_interval: float) -> list[Answer]:
        """Hears a trace."""

    def pose(self, utime: int, x: float, y: float, yaw: float) -> list[Answer]:
        """Hears a pose of the track, m and rad."""


def answers_to(log: Path, teller: Teller, channels: Channels, poses: Path | None) -> list[Answer]:
    """What the teller says of a log, by the antenna that is heard first; `poses`: a replay of it,
    for the track."""
    heard = choose(logs.need(logs.read_roles(log, channels.of("gpr_trace")), "gpr_trace"), None)
    times: list[tuple[int, int, int]] = [(int(t), 1, i) for i, t in enumerate(heard["utime"])]
    track = None
    if poses is not None:
        track = logs.need(logs.read_roles(poses, channels.of("odometry")), "odometry")
        yaw = rotation.yaw_of(track["orientation"])
        times += [(int(t), 0, i) for i, t in enumerate(track["utime"])]
    answers = []
    for utime, what, i in sorted(times):
        if what == 1:
            interval = float(heard["sample_interval"][i])
            answers += teller.trace(utime, np.asarray(heard["samples"][i], np.float64), interval)
        elif track is not None:
            x_m, y_m = track["position"][i, :2]
            answers += teller.pose(utime, float(x_m), float(y_m), float(yaw[i]))
    return answers


def with_answers(log: Path, answers: list[Answer], channels: Channels, output: Path) -> None:
    """The log without its traces and any other's displacements, with the answers: the estimator
    gets nothing else of the radar."""
    found: dict[str, list[tuple[int, bytes]]] = {}
    for channel, stamp, data in events(log, channels.of("imu", "wheel").values()):
        found.setdefault(channel, []).append((stamp, data))
    if answers:
        found[channels.displacement_in] = [(each.utime, encoded(each)) for each in answers]
    streams = [
        Stream(name, np.array([stamp for stamp, _ in sent], np.int64), [data for _, data in sent])
        for name, sent in found.items()
    ]
    write_log(output, streams)
