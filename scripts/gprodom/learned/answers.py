"""From traces and odometry, as they come, to what the estimator is told: the same code live and on
a recording.

Both kinds hear `trace` and `pose` in time order and return displacements with what they hear.
"""

import math
from collections import deque
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from gprodom.arrays import Floats
from gprodom.ground.laid import LaidTraces, Piece
from gprodom.lcm.answers import Answer
from gprodom.lcm.constants import kind
from gprodom.learned.model import Network, read_record, to_offset, to_spacing, widening
from gprodom.learned.windows import COLUMN, LENGTH, WINDOW, image, step_at, to_rows

LONGEST_GAP = 1.0  # s between traces: after a longer one all begins anew
LEAST_SIGMA = 2e-3  # m

EVERY = LENGTH / 2  # m, from an image to the next
PARALLEL = math.radians(25)  # of headings, either way
NEAR = 0.6  # m; images whose middles lie so close by the track are compared
DRIFT = 0.02  # by which that grows with the way between them
MOST = 24  # images compared with one, the nearest


class SequentialTeller:
    """learned_sequential: unsigned motion from the last two windows of traces."""

    def __init__(self, folder: Path) -> None:
        self._network = Network(folder, "learned_sequential")
        self._widen = widening(read_record(folder), "learned_sequential")
        self._rows: deque[Floats] = deque(maxlen=2 * WINDOW)
        self._times: deque[int] = deque(maxlen=2 * WINDOW)
        self._told = 0  # traces since the last answer

    def trace(self, utime: int, samples: Floats, sample_interval: float) -> list[Answer]:
        """Hears a trace."""
        if self._times and not 0 < utime - self._times[-1] < LONGEST_GAP * 1e6:
            self._rows.clear()
            self._times.clear()
        self._rows.append(to_rows(samples[None], sample_interval)[0])
        self._times.append(utime)
        self._told += 1
        if len(self._times) < 2:
            return []
        span = (self._times[-1] - self._times[0]) * 1e-6
        step = step_at((len(self._times) - 1) / span)
        if len(self._times) < WINDOW + step or self._told < step:
            return []
        self._told = 0
        rows = np.array(self._rows)
        before, after = rows[-step - WINDOW : -step], rows[-WINDOW:]
        spacing = to_spacing(self._network(before[None], after[None]), self._widen)
        return [
            Answer(
                utime,
                self._times[-1 - step],
                utime,
                "learned_sequential",
                kind("MOTION"),
                step * float(spacing.mean[0]),
                max(step * float(spacing.sigma[0]), LEAST_SIGMA),
            )
        ]

    def pose(self, utime: int, x: float, y: float, yaw: float) -> list[Answer]:
        """Needs none."""
        return []


@dataclass(frozen=True)
class _Image:
    """Laid along its own pass: the pose and time of its middle, the way driven until then."""

    picture: Floats
    utime: int
    x: float
    y: float
    heading: float  # rad, driven
    way: float
    forwards: bool


def _image(piece: Piece) -> _Image:
    """Of the last LENGTH of way."""
    middle = piece.way[-1] - LENGTH / 2
    yaw = piece.at(middle, piece.yaw)
    return _Image(
        image(piece.traces, piece.along, piece.way[-1] - LENGTH),
        int(piece.at(middle, piece.utime)),
        piece.at(middle, piece.x),
        piece.at(middle, piece.y),
        yaw if piece.forwards else yaw + math.pi,
        middle,
        piece.forwards,
    )


class PairTeller:
    """learned_pair: images along the estimated track; those of ground seen before are revisits."""

    def __init__(self, folder: Path) -> None:
        record = read_record(folder)
        self._network = Network(folder, "learned_pair")
        self._widen = widening(record, "learned_pair")
        self._accept = float(record["training"]["learned_pair"]["accept"])
        self._laid = LaidTraces(LENGTH, EVERY, COLUMN, 0.1 * COLUMN)
        self._images: list[_Image] = []

    def trace(self, utime: int, samples: Floats, sample_interval: float) -> list[Answer]:
        """Hears a trace."""
        self._laid.trace(utime, to_rows(samples[None], sample_interval)[0])
        return []

    def pose(self, utime: int, x: float, y: float, yaw: float) -> list[Answer]:
        """Hears a pose of the track; tells of a revisit when an image is complete."""
        piece = self._laid.pose(utime, x, y, yaw)
        if piece is None:
            return []
        made = _image(piece)
        answers = self._compare(utime, made)
        self._images.append(made)
        return answers

    def _compare(self, utime: int, made: _Image) -> list[Answer]:
        """With those of earlier passes that the track puts near it."""
        near: list[tuple[float, _Image, bool]] = []
        for old in self._images:
            between = made.way - old.way
            turn = math.remainder(made.heading - old.heading, 2 * math.pi)
            against = abs(turn) > math.pi / 2
            apart = math.hypot(made.x - old.x, made.y - old.y)
            parallel = min(abs(turn), math.pi - abs(turn)) < PARALLEL
            if between > 1.5 * LENGTH and parallel and apart < NEAR + DRIFT * between:
                near.append((apart, old, against))
        near = sorted(near, key=lambda each: each[0])[:MOST]
        if not near:
            return []
        memory = np.array([old.picture for _, old, _ in near])
        query = np.array([made.picture[:, ::-1] if back else made.picture for *_, back in near])
        found = to_offset(self._network(memory, query), self._widen)
        best = int(np.argmax(found.same))
        if found.same[best] < self._accept or abs(found.offset[best]) > 0.8 * LENGTH / 2:
            return []
        _, old, against = near[best]
        return [
            Answer(
                utime,
                old.utime,
                made.utime,
                "learned_pair",
                kind("REVISIT"),
                float(found.offset[best]) * (1 if old.forwards else -1),
                max(float(found.sigma[best]), LEAST_SIGMA),
                against,
                float(found.same[best]),
            )
        ]


TELLERS: dict[str, type[SequentialTeller] | type[PairTeller]] = {
    "learned_sequential": SequentialTeller,
    "learned_pair": PairTeller,
}


def teller_of(network: Path) -> SequentialTeller | PairTeller:
    """Of a network's file."""
    return TELLERS[network.stem](network.parent)
