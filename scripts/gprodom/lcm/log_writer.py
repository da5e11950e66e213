"""Writes a whole LCM log from streams of messages: in time order, and entirely or not at all."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from gprodom.arrays import Ints
from gprodom.console import Progress
from gprodom.errors import Error
from gprodom.files import replacing
from gprodom.lcm import EventLog
from gprodom.lcm.wire import encode

_EVENT_HEADER = 28  # bytes of a log event before channel and data


@dataclass(frozen=True)
class Stream:
    """Messages of one channel, in time order."""

    channel: str
    utime: Ints  # (n,), us
    payloads: Sequence[bytes]  # n
    out_of_order: int = 0  # messages that stood after later ones where they were read
    antenna_id: int = 0  # whose traces they are; a channel has a stream for each antenna

    @property
    def name(self) -> str:
        """By which it is told: its channel, with the id of an antenna other than 0."""
        return f"{self.channel} {self.antenna_id}" if self.antenna_id else self.channel


def encoded(channel: str, name: str, utime: Ints, **fields: npt.ArrayLike) -> Stream:
    """Messages of type `name` at `utime` (n,), us; each field: one value for all, or (n, ...)."""
    return Stream(channel, utime, encode(name, {"utime": utime, **fields}, len(utime)))


def write_log(path: Path, streams: Sequence[Stream]) -> int:
    """Writes the streams merged by time; at equal times in the order given. Returns the count."""
    utime = np.concatenate([stream.utime for stream in streams])
    source = np.repeat(np.arange(len(streams)), [len(stream.utime) for stream in streams])
    order = np.lexsort((source, utime))  # stable: messages of one stream keep their order
    queues = [iter(stream.payloads) for stream in streams]
    channels = [stream.channel for stream in streams]
    expected = 0
    with replacing(path) as part:
        log = EventLog(part, "w", overwrite=True)
        with Progress("writing", len(order)) as progress:
            for time, index in zip(utime[order].tolist(), source[order].tolist(), strict=True):
                data = next(queues[index])
                log.write_event(time, channels[index], data)
                expected += _EVENT_HEADER + len(channels[index]) + len(data)
                progress.advance()
        log.close()
        if part.stat().st_size != expected:  # liblcm does not report what fails on closing
            raise Error(f"{path}: could not be written in full; is the disk full?")
    return len(order)
