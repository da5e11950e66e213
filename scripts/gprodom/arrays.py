"""Names for numpy arrays in signatures, whose shapes and units stand in docstrings; running sums;
runs in a mask.

numpy's stubs infer element types differently from version to version, so these say what is meant
and leave the checking of element types to the tests.
"""

from typing import Any

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[Any]  # float64
Ints = npt.NDArray[Any]  # int64 unless said otherwise
Bools = npt.NDArray[Any]


def sums(steps: Floats) -> Floats:
    """(n + 1, ...): the running sums of steps (n, ...), from 0."""
    return np.concatenate([np.zeros((1, *steps.shape[1:])), np.cumsum(steps, axis=0)])


def integral(values: Floats, seconds: Floats) -> Floats:
    """The running integral of values (n, ...) over `seconds` (n,), by trapezoids, from 0."""
    steps = np.diff(seconds).reshape(-1, *(1,) * (values.ndim - 1))
    return sums(0.5 * (values[1:] + values[:-1]) * steps)


def runs(on: Bools) -> Ints:
    """(n, 2): first index, and index after the last, of each run of True."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], on, [False]]).astype(int)))
    return edges.reshape(-1, 2)
