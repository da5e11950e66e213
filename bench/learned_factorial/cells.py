"""The cells of the factorial test: ground x speed x rate of the traces, and what befalls them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gprodom.arrays import Floats, Ints
from gprodom.learned.grounds import LENGTH, Line, receive
from gprodom.random_streams import stream

SPEEDS = (0.1, 0.2, 0.4, 0.8)  # m/s
RATES = (5.0, 10.0, 20.0, 40.0)  # traces/s
BEFORE_S = 3.0  # of standing, before the drive
DRIVE_S = 9.0
FIRST_S = 1.0  # of the drive, left out: not all methods have begun
SEGMENT_S = 4.0
KINDS = ("driven", "shuffled", "standing")


@dataclass(frozen=True)
class Cell:
    """Traces of one drive at a constant speed; `begin` (s) is when it starts to move."""

    ground: int
    kind: str
    speed: float  # m/s, driven; 0 standing
    rate: float  # traces/s
    time: Floats  # s
    traces: Ints
    sample_interval: float

    @property
    def segments(self) -> list[tuple[float, float]]:
        """Begin and end (s) of the pieces that are scored."""
        first = BEFORE_S + FIRST_S
        count = int((DRIVE_S - FIRST_S) / SEGMENT_S)
        return [(first + i * SEGMENT_S, first + (i + 1) * SEGMENT_S) for i in range(count)]


def make_cell(line: Line, ground: int, kind: str, speed: float, rate: float) -> Cell:
    """One drive over the ground of that seed. shuffled: the same traces, each segment's in another
    order: their number says what it did, their likeness nothing."""
    random = stream(ground, f"{speed} {rate}")
    time = np.arange(0.0, BEFORE_S + DRIVE_S + 0.1, 1 / rate)
    moved = 0.0 if kind == "standing" else speed
    way = moved * np.maximum(time - BEFORE_S, 0.0)
    along = random.uniform(0.0, LENGTH - way[-1] - 0.01) + way
    cell = Cell(
        ground,
        kind,
        moved,
        rate,
        time,
        receive(line, along, rate, random),
        line.sample_interval,
    )
    if kind == "shuffled":
        for begin, end in cell.segments:
            inside = np.flatnonzero((time >= begin) & (time < end))
            cell.traces[inside] = cell.traces[random.permutation(inside)]
    return cell


def calibration_drive(line: Line, ground: int) -> Cell:
    """Some 5 m of the same ground at 0.6 m/s and 20 traces/s, by which a scale may be learnt, as
    gprodom learns it from the wheel."""
    random = stream(ground, "calibration")
    time = np.arange(0.0, BEFORE_S + DRIVE_S + 0.1, 0.05)
    along = random.uniform(0.0, 6.0) + 0.6 * np.maximum(time - BEFORE_S, 0.0)
    traces = receive(line, along, 20.0, random)
    return Cell(ground, "driven", 0.6, 20.0, time, traces, line.sample_interval)
