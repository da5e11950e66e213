"""Random numbers that stay the same: one stream for each part of a simulation.

numpy keeps `RandomState` unchanged between versions, which it does not promise of `Generator`.
Streams are named, so that a change to one part leaves the draws of the others as they are.
"""

import numpy as np

from gprodom.arrays import Floats

Random = np.random.RandomState


def stream(seed: int, name: str) -> Random:
    """The stream of `seed` (0 or more) for the part called `name`."""
    return Random(np.random.MT19937(np.random.SeedSequence([seed, *name.encode()])))


def gauss_markov(shape: tuple[int, ...], kept: float, random: Random) -> Floats:
    """Of unit variance; `kept`: the part of each row that is in the next one as well."""
    from scipy.signal import lfilter

    shocks = random.standard_normal(shape) * np.sqrt(1 - kept**2)
    shocks[0] = random.standard_normal(shape[1:])
    return np.asarray(lfilter([1.0], [1.0, -kept], shocks, axis=0))
