"""Walks through the events of an LCM log without copying those that nobody asked for.

A log of an hour has some millions of events, of which a picture wants few. A damaged log gives what
LCM's own reader, and so a replay, takes from it: all before the damage. Only names of channels that
are no text are an error there, and none here.
"""

import mmap
import struct
from collections.abc import Collection, Iterator, Mapping
from os import PathLike
from pathlib import Path

_HEAD = struct.Struct(">IqqII")  # sync word, number, stamp (us), lengths of channel and data
_SYNC = 0xEDA1DA01
_SYNC_BYTES = _SYNC.to_bytes(4, "big")
_LONGEST_CHANNEL = 1000  # bytes, in LCM's reader

Event = tuple[str, int, bytes]  # channel, the log's stamp (us), data


def events(
    path: str | PathLike[str],
    channels: Collection[str] | None = None,
    every_us: Mapping[str, int] | None = None,
) -> Iterator[Event]:
    """The events of `channels` (all where None), in the log's order.

    every_us: of each channel named there at most one in so many microseconds of the log's stamps,
    and its first after a step back in time.
    """
    if Path(path).stat().st_size == 0:
        return
    with (
        Path(path).open("rb") as file,
        mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as data,
    ):
        yield from _events(data, channels, every_us or {})


def _events(
    data: mmap.mmap, channels: Collection[str] | None, every_us: Mapping[str, int]
) -> Iterator[Event]:
    wanted = None if channels is None else {name.encode() for name in channels}
    periods = {name.encode(): period for name, period in every_us.items()}
    last: dict[bytes, int] = {}
    at, size, head = 0, len(data), _HEAD.size
    read_head = _HEAD.unpack_from
    while at + head <= size:
        sync, _, stamp, name_length, length = read_head(data, at)
        if sync != _SYNC:  # as at the begin of a log that was cut out of another
            at = data.find(_SYNC_BYTES, at + 1)
            if at < 0:
                return
            continue
        begin = at + head + name_length
        at = begin + length
        if not 0 < name_length < _LONGEST_CHANNEL or not 0 < length < 1 << 31 or at > size:
            return
        if data[at : at + 4] != _SYNC_BYTES and at + 4 <= size:
            return
        name = data[begin - name_length : begin]
        if wanted is not None and name not in wanted:
            continue
        period = periods.get(name)
        if period is not None:
            since = stamp - last.get(name, stamp - period)
            if 0 <= since < period:
                continue
            last[name] = stamp
        yield name.decode("utf-8", "replace"), stamp, data[begin:at]
