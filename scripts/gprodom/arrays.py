"""Names for numpy arrays in signatures, whose shapes and units stand in docstrings; runs in a mask.

numpy's stubs infer element types differently from version to version, so these say what is meant
and leave the checking of element types to the tests.
"""

from typing import Any

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[Any]  # float64
Ints = npt.NDArray[Any]  # int64 unless said otherwise
Bools = npt.NDArray[Any]


def runs(on: Bools) -> Ints:
    """(n, 2): first index, and index after the last, of each run of True."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], on, [False]]).astype(int)))
    return edges.reshape(-1, 2)
