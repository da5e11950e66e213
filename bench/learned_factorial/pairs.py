"""learned_pair under a wheel that errs: images laid by a track that is scaled, of the same pass one
after the other, and of another pass over the same ground."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from gprodom.arrays import Floats
from gprodom.learned import windows
from gprodom.learned.examples import REACH
from gprodom.learned.grounds import LENGTH, Line, receive
from gprodom.learned.model import Network, read_record, to_offset, widening
from gprodom.learned.windows import image, to_rows
from gprodom.random_streams import stream

SCALES = (0.7, 0.85, 1.0, 1.15, 1.3)  # of the way that the wheel tells, over the true one
SPEED, RATE = 0.4, 20.0  # m/s, traces/s
PLACES = 12  # of each ground and scale
CONSECUTIVE, REVISIT = "consecutive", "revisit"


@dataclass(frozen=True)
class Offsets:
    """Of pairs on one ground: true offsets (n,), m, those that the wheel tells, and what the
    network says, with its standard deviation and the chance of the same ground."""

    kind: str
    scale: float
    true: Floats
    wheel: Floats
    told: Floats
    sigma: Floats
    same: Floats


def measure(line: Line, ground: int, folder: Path) -> list[Offsets]:
    """All pairs of a ground."""
    network = Network(folder, "learned_pair")
    widen = widening(read_record(folder), "learned_pair")
    made = []
    for scale in SCALES:
        random = stream(ground, f"pairs {scale}")
        along = np.arange(0.0, LENGTH, SPEED / RATE)
        passes = [
            to_rows(receive(line, along, RATE, random, on), line.sample_interval) for on in (0, 1)
        ]
        room = LENGTH - windows.LENGTH - REACH
        here = random.uniform(REACH + windows.LENGTH, room, PLACES)
        true = random.uniform(-REACH, REACH, PLACES) * min(1.0, 1 / scale)
        for kind, rows in ((CONSECUTIVE, passes[0]), (REVISIT, passes[1])):
            first = _images(passes[0], scale * along, scale * here)
            second = _images(rows, scale * along, scale * (here + true))
            found = to_offset(network(first, second), widen)
            made.append(
                Offsets(kind, scale, true, scale * true, found.offset, found.sigma, found.same)
            )
    return made


def _images(rows: Floats, along: Floats, middles: Floats) -> Floats:
    return np.array([image(rows, along, middle - windows.LENGTH / 2) for middle in middles])
