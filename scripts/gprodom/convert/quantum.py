"""The encoder's step, found from the distances it reported."""

import numpy as np
import numpy.typing as npt

from gprodom.arrays import Floats

_MOST_DIVISIONS = 6  # the smallest step seen may be up to this many ticks
_FLOAT_TOLERANCE = 1e-9  # m; sums of floats are off their grid by less


def find_quantum(distances: npt.ArrayLike, decimals: int) -> float | None:
    """The largest step (m) of which all `distances` (n,) are multiples, to rounding.

    `decimals`: how many digits after the point the distances were written with. None where they lie
    on no grid coarser than that rounding.
    """
    values = np.asarray(distances, np.float64)
    tolerance = max(0.51 * 10.0**-decimals, _FLOAT_TOLERANCE)
    steps = np.abs(np.diff(values))
    steps = steps[steps > 2 * tolerance]
    magnitudes = np.unique(np.abs(values[np.abs(values) > 2 * tolerance]))
    if not len(steps) or not len(magnitudes):
        return None
    for division in range(1, _MOST_DIVISIONS + 1):
        guess = float(steps.min()) / division
        if guess < 8 * tolerance:
            return None
        quantum = _shortest(_refine(guess, magnitudes), magnitudes, tolerance)
        if quantum is not None:
            return quantum
    return None


def _refine(guess: float, magnitudes: Floats) -> float:
    """Least squares over longer and longer distances, so that no tick count is wrong by one."""
    quantum, span = guess, guess
    while span < magnitudes[-1]:
        span = min(4 * span, float(magnitudes[-1]))
        used = magnitudes[: np.searchsorted(magnitudes, span, side="right")]
        if len(used):
            ticks = np.rint(used / quantum)
            if ticks[-1] > 0:
                quantum = float(used @ ticks / (ticks @ ticks))
    return quantum


def _shortest(quantum: float, magnitudes: Floats, tolerance: float) -> float | None:
    """The shortest decimal near `quantum` that reproduces the distances; None if none does."""
    for digits in range(1, 18):
        candidate = float(f"{quantum:.{digits - 1}e}")
        if candidate > 0:
            error = magnitudes - candidate * np.rint(magnitudes / candidate)
            if np.abs(error).max() <= tolerance:
                return candidate
    return None
