"""The answers of a network to a recording, in a log that the estimator is then driven by."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import numpy as np

from gprodom.config import Channels
from gprodom.lcm import EventLog, logs
from gprodom.lcm.log_writer import Stream, write_log
from gprodom.learned.answers import TELLERS, Answer, encoded


def answers_to(
    log: Path, name: str, networks: Path, channels: Channels, poses: Path | None
) -> list[Answer]:
    """What the network `name` says of a log; `poses`: a replay of it, for the track."""
    teller = TELLERS[name](networks)
    heard = logs.need(logs.read_roles(log, channels.of("gpr_trace")), "gpr_trace")
    times: list[tuple[int, int, int]] = [(int(t), 1, i) for i, t in enumerate(heard["utime"])]
    track = None
    if poses is not None:
        track = logs.need(logs.read_roles(poses, channels.of("odometry")), "odometry")
        w, x, y, z = track["orientation"].T
        yaw = np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
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
    wanted = {*channels.of("imu", "wheel").values()}
    stamps = np.array([each.utime for each in answers], np.int64)
    told = Stream(channels.displacement_in, stamps, [encoded(each) for each in answers])
    streams = _streams(EventLog(str(log), "r"), wanted)
    write_log(output, [*streams, told] if answers else streams)


def _streams(events: Iterable[object], wanted: set[str]) -> list[Stream]:
    found: dict[str, tuple[list[int], list[bytes]]] = {}
    for event in events:
        channel = str(event.channel)  # type: ignore[attr-defined]
        if channel in wanted:
            stamps, payloads = found.setdefault(channel, ([], []))
            stamps.append(event.timestamp)  # type: ignore[attr-defined]
            payloads.append(event.data)  # type: ignore[attr-defined]
    return [Stream(name, np.array(t, np.int64), data) for name, (t, data) in found.items()]
