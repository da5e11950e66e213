"""Reads LCM logs as numpy arrays."""

from collections import Counter
from collections.abc import Collection, Mapping
from itertools import compress
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from gprodom.arrays import Bools, Ints
from gprodom.console import warn
from gprodom.errors import Error
from gprodom.lcm import wire
from gprodom.lcm.log_scan import events
from gprodom.lcm.messages import by_fingerprint, message

# What a type's messages are read as: arrays by field; "type" is the type's name, "log_utime" (n,)
# the log's own stamps.
Channel = dict[str, Any]
Log = dict[str, Channel]  # by the channel's name, or by its role


def read(
    path: str | PathLike[str],
    channels: Collection[str] | None = None,
    every_us: Mapping[str, int] | None = None,
) -> Log:
    """The messages of a log by channel and field; only `channels` where given.

    ``read(path)["IMU"]["angular_velocity"]`` is (n, 3). Times (``utime``) are int64 microseconds.
    Messages of variable structure (status_t, sfm_t, command_t) come decoded as a list in
    ``"messages"``. Channels of foreign types are left out; of a channel with messages of several
    types those of the type that most have of ours are read, and the rest is counted in a warning.
    every_us: of each channel named there at most one message in so many microseconds of the log's
    stamps.
    """
    if not Path(path).is_file():
        raise Error(f"{path}: no such log")
    payloads: dict[str, list[bytes]] = {}
    stamps: dict[str, list[int]] = {}
    for channel, stamp, data in events(path, channels, every_us):
        payloads.setdefault(channel, []).append(data)
        stamps.setdefault(channel, []).append(stamp)
    if not payloads and channels is None and Path(path).stat().st_size > 0:
        raise Error(f"{path}: expected an LCM log, found no event in it")
    known = by_fingerprint()
    result: Log = {}
    for channel, messages in payloads.items():
        kinds = Counter(data[:8] for data in messages if data[:8] in known)
        if not kinds:
            continue
        [(kind, _)] = kinds.most_common(1)
        name = known[kind]
        ours = [data[:8] == kind for data in messages]
        foreign = ours.count(False)
        if foreign:
            warn(f"{path}: channel {channel}: {foreign} messages that are no {name} are left out")
        messages = list(compress(messages, ours))
        result[channel] = _decode(name, messages, f"{path}: channel {channel}")
        result[channel]["type"] = name
        result[channel]["log_utime"] = np.array(list(compress(stamps[channel], ours)), np.int64)
    return result


def read_roles(
    path: str | PathLike[str], names: Mapping[str, str], every_us: Mapping[str, int] | None = None
) -> Log:
    """As `read`, of the channels `names`, which gives each one's name by its role; by role.

    every_us: by role.
    """
    periods = {names[role]: period for role, period in (every_us or {}).items()}
    found = read(path, names.values(), periods)
    return {role: found[name] for role, name in names.items() if name in found}


def need(log: Log, role: str) -> Channel:
    """The channel of that role of a log read by `read_roles`."""
    if role not in log:
        raise Error(
            f"the log holds no {role} messages; their channel is named by channels.{role} of the "
            "configuration (-c, --set)"
        )
    return log[role]


def _decode(name: str, payloads: list[bytes], where: str) -> Channel:
    if name in wire.LAYOUTS:
        return dict(wire.decode(name, payloads, where))
    decoder = message(name)
    messages = [decoder.decode(data) for data in payloads]
    return {"utime": np.array([m.utime for m in messages], np.int64), "messages": messages}


def select(content: Channel, rows: Ints | Bools) -> Channel:
    """The messages of these rows."""
    count = len(content["utime"])
    return {
        name: values[rows] if isinstance(values, np.ndarray) and len(values) == count else values
        for name, values in content.items()
    }
