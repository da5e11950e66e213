"""Random numbers that stay the same: one stream for each part of a simulation.

numpy keeps `RandomState` unchanged between versions, which it does not promise of `Generator`.
Streams are named, so that a change to one part leaves the draws of the others as they are.
"""

from __future__ import annotations

import numpy as np


def stream(seed: int, name: str) -> np.random.RandomState:
    """The stream of `seed` (0 or more) for the part called `name`."""
    entropy = [seed, *name.encode()]
    return np.random.RandomState(np.random.MT19937(np.random.SeedSequence(entropy)))
