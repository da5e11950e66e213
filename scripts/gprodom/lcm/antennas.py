"""The radar's traces apart by antenna: `GPR_TRACE` has those of all."""

from collections.abc import Collection

import numpy as np

from gprodom.errors import Error
from gprodom.lcm.logs import Channel, select


def counts(radar: Channel) -> dict[int, int]:
    """How many traces each antenna_id has, in the order in which they were heard first."""
    ids, first, number = np.unique(radar["antenna_id"], return_index=True, return_counts=True)
    order = np.argsort(first)
    return dict(zip(ids[order].tolist(), number[order].tolist(), strict=True))


def named(radar: Channel) -> str:
    """The antennas and their counts in words, such as "0 (120 traces), 1 (118 traces)"."""
    return ", ".join(f"{antenna} ({number} traces)" for antenna, number in counts(radar).items())


def of_antenna(radar: Channel, antenna: int) -> Channel:
    """The channel with the traces of one antenna alone."""
    mine = radar["antenna_id"] == antenna
    if not mine.any():
        raise Error(f"no traces of antenna {antenna}; there are those of {named(radar)}")
    if mine.all():
        return radar
    some = select(radar, mine)
    samples = some["samples"]
    if samples.dtype == object and len({len(trace) for trace in samples}) == 1:
        some["samples"] = np.stack(list(samples))  # only another antenna's had another length
    return some


def apart(radar: Channel) -> dict[int, Channel]:
    """The channel of each antenna, in the order in which they were heard first."""
    return {antenna: of_antenna(radar, antenna) for antenna in counts(radar)}


def choose(radar: Channel, asked: int | None, placed: Collection[int] = ()) -> Channel:
    """Of the antenna that is asked for; else the first heard of those `placed` on the robot by
    gpr.antennas, as the estimator has it, or of all where it places none."""
    if asked is not None:
        return of_antenna(radar, asked)
    heard = list(counts(radar))
    return of_antenna(radar, next((each for each in heard if each in placed), heard[0]))
