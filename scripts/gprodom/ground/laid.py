"""Traces laid along the ground by the poses of a track, as both come."""

import math
from collections import deque
from dataclasses import dataclass

import numpy as np

from gprodom.arrays import Floats, Ints

KEPT_TRACES = 4000  # for the pieces to come
WIDEST = 5.0  # columns without a trace; beyond, nothing is known of the ground between


def columns_at(ways: Floats, traces: Floats, along: Floats) -> Floats:
    """Traces (n, samples), which lie at `along` (n,), m, ascending, interpolated at `ways` (m,)."""
    after = np.clip(np.searchsorted(along, ways), 1, len(along) - 1)
    gap = np.maximum(along[after] - along[after - 1], 1e-9)
    part = np.clip((ways - along[after - 1]) / gap, 0, 1)[:, None].astype(traces.dtype)
    return np.asarray((1 - part) * traces[after - 1] + part * traces[after])


@dataclass(frozen=True)
class Piece:
    """Of a track in one direction, with its traces.

    utime (n,), and for each the way driven so far (m, always growing), s, the place along the track
    (m, backwards it falls), x, y (m) and unwrapped yaw (rad) of the robot; `along`: the way at each
    of the `traces` (m, samples)."""

    utime: Ints
    way: Floats
    s: Floats
    x: Floats
    y: Floats
    yaw: Floats
    along: Floats
    traces: Floats
    forwards: bool

    def at(self, way: float, values: Floats | Ints) -> float:
        """Of one of the track's columns, at that way."""
        return float(np.interp(way, self.way, values))


class LaidTraces:
    """Tells the piece that is complete, of `length` (m), each `every` (m).

    column: m, from a column of a piece to the next, for which there should be traces. turn: m, a
    step back that is a turn of the direction, and no correction of the track."""

    def __init__(self, length: float, every: float, column: float, turn: float) -> None:
        self._length, self._every, self._column, self._turn = length, every, column, turn
        self._traces: deque[tuple[int, Floats]] = deque(maxlen=KEPT_TRACES)
        # Of each pose since the direction last changed: time, way, s, x, y, yaw.
        self._track: list[tuple[int, float, float, float, float, float]] = []
        self._way = self._s = 0.0
        self._forwards = True
        self._next = length

    def trace(self, utime: int, samples: Floats) -> None:
        """Hears a trace (samples,)."""
        if self._traces and self._traces[-1][1].shape != samples.shape:
            self._traces.clear()
        self._traces.append((utime, samples))

    def pose(self, utime: int, x: float, y: float, yaw: float) -> Piece | None:
        """Hears a pose; the piece that it completes."""
        if self._track:
            _, _, _, before_x, before_y, _ = self._track[-1]
            step = (x - before_x) * math.cos(yaw) + (y - before_y) * math.sin(yaw)
            turned = (step > 0) != self._forwards
            if abs(step) < (self._turn if turned else 0.1 * self._column):
                return None
            if turned or abs(step) > self._length:
                self._forwards, self._next = step > 0, self._way + self._length
                self._track = self._track[-1:]
            self._way += abs(step)
            self._s += step
        self._track.append((utime, self._way, self._s, x, y, yaw))
        if self._way < self._next or len(self._track) < 3:
            return None
        self._next = self._way + self._every
        return self._piece()

    def _piece(self) -> Piece | None:
        """Of the last of the way."""
        ways = np.array([way for _, way, *_ in self._track])
        start = max(int(np.searchsorted(ways, self._way - 1.2 * self._length)) - 1, 0)
        self._track = self._track[start:]
        times, ways, s, xs, ys, yaws = np.array(self._track).T
        traces = [(t, samples) for t, samples in self._traces if times[0] <= t <= times[-1]]
        if len(traces) < self._length / (WIDEST * self._column):
            return None
        along = np.interp(np.array([t for t, _ in traces], np.float64), times, ways)
        if np.diff(along).max() > WIDEST * self._column:
            return None
        rows = np.array([samples for _, samples in traces])
        yaw = np.unwrap(yaws)
        return Piece(times.astype(np.int64), ways, s, xs, ys, yaw, along, rows, self._forwards)
