"""One long drive of a short log: its rounds follow each other, for soaks of the live daemon.

The log begins and ends at a standstill. Stamps and the wheel's count go on from round to round.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from gprodom.console import Progress
from gprodom.errors import Error
from gprodom.lcm.messages import message
from log_events import Message, read_events, write_events

TYPES = {"IMU": "imu_t", "WHEEL": "wheel_t", "GPR_TRACE": "gpr_trace_t"}
IMU_PERIOD_US = 5000  # between the last message of a round and the first of the next


def repeat(source: Path, output: Path, seconds: float) -> None:
    """Writes `output`."""
    if not source.is_file():
        raise Error(f"{source}: no such log")
    events = [event for event in read_events(source) if event[1] in TYPES]
    if not events:
        raise Error(f"{source}: no IMU, WHEEL or GPR_TRACE messages")
    write_events(rounds(events, seconds), output)


def rounds(events: list[Message], seconds: float) -> Iterator[Message]:
    """The messages of one round after the other."""
    messages = [message(TYPES[channel]).decode(data) for _, channel, data in events]
    first = messages[0].utime
    period = max(m.utime for m in messages) - first + IMU_PERIOD_US
    ticks = next((m.ticks for m in reversed(messages) if hasattr(m, "ticks")), 0)
    with Progress("writing", seconds) as progress:
        while True:
            for (_, channel, _), m in zip(events, messages, strict=True):
                if m.utime - first > 1e6 * seconds:
                    return
                yield m.utime, channel, m.encode()
                m.utime += period
                if hasattr(m, "ticks"):
                    m.ticks += ticks
            progress.update(min(seconds, (m.utime - period - first) * 1e-6))
