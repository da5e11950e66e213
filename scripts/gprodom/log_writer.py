"""Writes a whole LCM log from streams of messages: in time order, and entirely or not at all."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from gprodom.arrays import Ints
from gprodom.console import Progress
from gprodom.errors import Error
from gprodom.lcm import EventLog

_EVENT_HEADER = 28  # bytes of a log event before channel and data


@dataclass(frozen=True)
class Stream:
    """Messages of one channel, in time order."""

    channel: str
    utime: Ints  # (n,), us
    payloads: Sequence[bytes]  # n


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """A new file beside `path`: renamed to it when all went well, removed when not."""
    try:
        handle, name = tempfile.mkstemp(prefix=f".{path.name}.", suffix=".part", dir=path.parent)
    except FileNotFoundError:
        raise Error(f"{path}: the folder {path.parent} does not exist") from None
    os.close(handle)
    part = Path(name)
    try:
        yield part
        umask = os.umask(0)
        os.umask(umask)
        part.chmod(0o666 & ~umask)
        part.replace(path)
    finally:
        part.unlink(missing_ok=True)


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
