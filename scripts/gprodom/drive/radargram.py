"""Radar traces along the way: a column for each piece of it, however long the robot stood there."""

from dataclasses import dataclass

import numpy as np

from gprodom.arrays import Floats, Ints
from gprodom.errors import Error
from gprodom.lcm.logs import Channel

SHOWN_RMS = 2.5  # of a row's deviation: what is stronger is shown as this


@dataclass(frozen=True)
class Radargram:
    """echoes (samples, columns): -1 to 1, the mean trace taken out, each row over its deviation;
    NaN where no trace was taken. length_m: of the way; sample_interval: s; time_zero: s before the
    pulse left."""

    echoes: Floats
    length_m: float
    sample_interval: float
    time_zero: float

    @property
    def span_ns(self) -> tuple[float, float]:
        """Two-way travel time of the first and the last sample, ns."""
        rows = len(self.echoes)
        return -1e9 * self.time_zero, 1e9 * (rows * self.sample_interval - self.time_zero)


def of_one_antenna(radar: Channel) -> tuple[Ints, Floats]:
    """Times (n,), us, and traces (n, samples) of the first antenna: of the commonest length."""
    antenna = radar["antenna_id"] == radar["antenna_id"].min()
    lengths = radar["num_samples"]
    values, counts = np.unique(lengths[antenna], return_counts=True)
    kept = np.flatnonzero(antenna & (lengths == values[np.argmax(counts)]))
    samples = radar["samples"]
    ragged = samples.dtype == object
    traces = np.stack([samples[row] for row in kept]) if ragged else samples[kept]
    return radar["utime"][kept], traces


def equalised(traces: Floats) -> Floats:
    """Of traces (n, samples) (samples, n), -1 to 1: less the mean, each row over its deviation."""
    echoes = (traces - traces.mean(axis=0, dtype=float)).astype(np.float32)
    deviation = echoes.std(axis=0)
    echoes /= SHOWN_RMS * np.where(deviation > 0, deviation, 1)
    return np.asarray(np.clip(echoes, -1, 1).T)


def along_way(radar: Channel, time: Ints, distance: Floats, columns: int) -> Radargram:
    """The means of the traces in each of `columns` equal pieces of the way.

    time (m,), us, and distance (m,), m: of the way, which does not fall.
    """
    stamps, traces = of_one_antenna(radar)
    inside = (stamps >= time[0]) & (stamps <= time[-1])
    if not inside.any() or distance[-1] <= distance[0]:
        raise Error("no traces were taken on the way")
    length = float(distance[-1] - distance[0])
    origin = int(time[0])
    at = np.interp(stamps[inside] - origin, time - origin, distance) - distance[0]
    column = np.minimum((at / length * columns).astype(int), columns - 1)
    order = np.argsort(column, kind="stable")
    filled, first = np.unique(column[order], return_index=True)
    sums = np.add.reduceat(traces[inside][order].astype(float), first, axis=0)
    means = sums / np.diff(np.append(first, len(order)))[:, None]
    echoes = np.full((traces.shape[1], columns), np.nan, np.float32)
    echoes[:, filled] = equalised(means)
    return Radargram(
        echoes, length, float(radar["sample_interval"][0]), float(radar["time_zero"][0])
    )
