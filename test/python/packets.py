"""Messages and logs, made for tests field by field."""

from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np

from gprodom.lcm import EventLog
from gprodom.lcm.messages import message


def packet(name: str, package: str = "gprodom", **fields: object) -> bytes:
    """An encoded message of that type."""
    sent = message(name, package)()
    for field, value in fields.items():
        setattr(sent, field, value)
    return bytes(sent.encode())


def status(
    utime: int, values: dict[str, float], health: int = 0, reasons: Sequence[str] = ()
) -> bytes:
    """A message of STATUS."""
    names, figures, told = list(values), list(values.values()), list(reasons)
    counts = {"num_values": len(names), "num_reasons": len(told)}
    return packet(
        "status_t", utime=utime, health=health, names=names, values=figures, reasons=told, **counts
    )


def pose(utime: int, x: float, y: float, variance: float, **fields: object) -> bytes:
    """A level pose in map, whose covariance is that many times one."""
    place, turn = [x, y, 0.0], [1.0, 0.0, 0.0, 0.0]
    covariance = (variance * np.eye(6)).ravel().tolist()
    common = {"frame": "map", "position": place, "orientation": turn}
    return packet("odometry_t", utime=utime, pose_covariance=covariance, **common, **fields)


def correction(utime: int, x: float = 0.0, y: float = 0.0) -> bytes:
    """A message of CORRECTION that moves `map` by x and y."""
    turn, place = [1.0, 0.0, 0.0, 0.0], [x, y, 0.0]
    return packet("correction_t", utime=utime, position=place, orientation=turn)


def write_events(path: Path, events: Iterable[tuple[int, str, bytes]]) -> Path:
    """A log of events (us, channel, message), which are sorted by time."""
    log = EventLog(str(path), "w", overwrite=True)
    for event in sorted(events, key=lambda event: event[0]):
        log.write_event(*event)
    log.close()
    return path
