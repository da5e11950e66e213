"""Messages of logs, and in what those of two logs differ, and how far their poses are apart."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import numpy as np

from gprodom.config import STANDARD
from gprodom.files import replacing
from gprodom.lcm import EventLog, logs

Message = tuple[int, str, bytes]  # time (us), channel, content


def read_events(log: Path) -> list[Message]:
    """The messages of a log, in its order."""
    return [(event.timestamp, event.channel, event.data) for event in EventLog(str(log), "r")]


def write_events(events: Iterable[Message], log: Path) -> Path:
    """A log of messages, in their order."""
    with replacing(log) as part:
        made = EventLog(str(part), "w", overwrite=True)
        for event in events:
            made.write_event(*event)
        made.close()
    return log


def differences(one: Path, other: Path) -> list[str]:
    """By channel, how many messages of two logs are not the same, and from when on."""
    sides: list[dict[str, list[Message]]] = []
    for path in (one, other):
        by_channel: dict[str, list[Message]] = {}
        for event in read_events(path):
            by_channel.setdefault(event[1], []).append(event)
        sides.append(by_channel)
    first = min((events[0][0] for side in sides for events in side.values()), default=0)
    said = []
    for channel in sorted({*sides[0], *sides[1]}):
        a, b = (side.get(channel, []) for side in sides)
        off = [event for event, twin in zip(a, b, strict=False) if event != twin]
        off += [*a[len(b) :], *b[len(a) :]]
        if off:
            seconds = (off[0][0] - first) * 1e-6
            said.append(f"{channel}: {len(off)} of {max(len(a), len(b))} from {seconds:.1f} s on")
    return (said or ["the order of messages of different channels"]) + apart(one, other)


def apart(one: Path, other: Path) -> list[str]:
    """How far poses of the same time in two logs are apart (mm), by channel, where they are."""
    roles = STANDARD.of("odometry", "odometry_map")
    sides = [logs.read_roles(path, roles) for path in (one, other)]
    said = []
    for role in roles.keys() & sides[0].keys() & sides[1].keys():
        _, a, b = np.intersect1d(*(side[role]["utime"] for side in sides), return_indices=True)
        off = sides[0][role]["position"][a] - sides[1][role]["position"][b]
        far = 1e3 * np.linalg.norm(off, axis=1)
        if len(far) and far.max() > 0:
            said.append(
                f"{roles[role]}: {far.max():.3g} mm apart at most, {far[-1]:.3g} at the end"
            )
    return sorted(said)
