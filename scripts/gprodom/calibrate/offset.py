"""Common parts of the searches for a time offset between two sensors."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gprodom.arrays import Floats
from gprodom.errors import Error

REACH_S = 0.5  # lags that are tried, either way
BLOCKS = 8  # parts of the recording, whose spread is the uncertainty


@dataclass(frozen=True)
class Offset:
    """offset_s: to be added to the sensor's stamps. explained: share of one signal by the other."""

    offset_s: float
    sigma_s: float
    explained: float

    @property
    def significant(self) -> bool:
        """Whether the offset is more than two standard deviations from zero."""
        return abs(self.offset_s) > 2 * self.sigma_s


def refine(shares: Sequence[float] | Floats) -> tuple[float, float]:
    """Index of the largest share, with its fraction by a parabola, and that share."""
    best = int(np.clip(np.argmax(shares), 1, len(shares) - 2))
    a, b, c = (float(share) for share in shares[best - 1 : best + 2])
    bend = a - 2 * b + c
    return best + (0.5 * (a - c) / bend if bend < 0 else 0.0), b


def spread(parts: Sequence[float], whole: float) -> float:
    """Standard deviation of `whole`, s, from the offsets of parts of the recording.

    By the median deviation, since a part with hardly any start or stop has a large error. Raises
    `Error` of fewer than two parts, which show none.
    """
    if len(parts) < 2:
        raise Error("only one part of the drive shows it: give more starts and stops")
    deviation = np.median(np.abs(np.array(parts) - whole))
    return 1.4826 * float(deviation) / float(np.sqrt(len(parts)))
