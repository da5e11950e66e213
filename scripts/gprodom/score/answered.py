"""How often a radar front end, or a network in its place, had a valid answer."""

from dataclasses import dataclass

import numpy as np

from gprodom.lcm import logs
from gprodom.lcm.constants import kind
from gprodom.trajectory import Times


@dataclass(frozen=True)
class Answered:
    """share: of the published time that valid displacements cover, revisits apart; revisits: number
    of those told."""

    share: float
    revisits: int


def answered(told: logs.Channel | None, published: Times) -> Answered | None:
    """From a channel of displacement_t and the times of the poses; None where nothing was told."""
    if told is None or len(published) < 2 or published[-1] <= published[0]:
        return None
    valid = np.asarray(told["valid"], bool)
    revisit = told["kind"] == kind("REVISIT")
    begin, end = (
        np.clip(told[name][valid & ~revisit], published[0], published[-1])
        for name in ("utime_from", "utime_to")
    )
    order = np.argsort(begin, kind="stable")
    begin, end = begin[order], end[order]
    # Each adds what lies beyond all before it: windows overlap.
    reached = np.maximum.accumulate(np.concatenate([published[:1], end]))
    covered = np.maximum(end - np.maximum(begin, reached[:-1]), 0).sum()
    share = float(covered) / float(published[-1] - published[0])
    return Answered(share, int(np.sum(valid & revisit)))
