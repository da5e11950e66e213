"""Curves of one method on one sequence for the report, kept with the scores."""

from dataclasses import dataclass

import numpy as np

from gprodom.arrays import Floats
from gprodom.score.associate import Pairs, covered
from gprodom.score.figures import Comparison
from gprodom.trajectory import Trajectory, interpolate, path_length

INTERVALS = (0.5, 1.0, 2.0, 3.0, 5.0, 8.0, 12.0, 20.0)  # s, of sampling
STEP_S = 1.0  # of the curves
TREAD_S = 0.5  # over which distance is added up, so that a total station's noise is not
STILL_M = 0.006  # a step below this is noise: the robot stands
POINTS = 600  # of a path


@dataclass(frozen=True)
class Curves:
    """Lists, so that they are JSON.

    time: s from the first pair, every `STEP_S`. rms: of the position error so far, m.
    distance, true_distance: travelled so far, m. interval_rms: by `INTERVALS`, RMS of the
    displacement's size over that time against truth, m (None: the sequence is shorter).
    path, true_path: x, y (m) in the truth's frame.
    """

    time: list[float]
    rms: list[float]
    distance: list[float]
    true_distance: list[float]
    interval_rms: list[float | None]
    path: list[list[float]]
    true_path: list[list[float]]


def measure_curves(comparison: Comparison) -> Curves:
    """The curves of a score."""
    pairs = comparison.pairs
    seconds = pairs.truth.seconds()
    grid = np.arange(0.0, seconds[-1] + 1e-9, STEP_S)
    so_far = np.sqrt(np.cumsum(comparison.error_m**2) / np.arange(1, len(seconds) + 1))
    aligned = comparison.transform.apply(pairs.estimate)
    return Curves(
        time=_rounded(grid),
        rms=_rounded(np.interp(grid, seconds, so_far)),
        distance=_rounded(np.interp(grid, *_travelled(pairs.estimate))),
        true_distance=_rounded(np.interp(grid, *_travelled(pairs.truth))),
        interval_rms=[interval_rms(pairs, interval) for interval in INTERVALS],
        path=_thinned(aligned.position),
        true_path=_thinned(pairs.truth.position),
    )


def _travelled(path: Trajectory) -> tuple[Floats, Floats]:
    """Times (s) and distance travelled until then (m), at steps of `TREAD_S`."""
    seconds = path.seconds()
    grid = np.arange(0.0, seconds[-1] + 1e-9, TREAD_S)
    points = np.column_stack([np.interp(grid, seconds, path.position[:, k]) for k in (0, 1)])
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    steps[steps < STILL_M] = 0.0
    return grid, np.concatenate([[0.0], np.cumsum(steps)])


def interval_rms(pairs: Pairs, interval: float) -> float | None:
    """RMS error of the size of the displacement from one sample to the next, `interval` s apart."""
    time = np.arange(pairs.truth.time[0], pairs.truth.time[-1], round(interval * 1e6))
    time = time[covered(pairs.truth, time) & covered(pairs.estimate, time)]
    if len(time) < 3:
        return None
    steps = [
        np.linalg.norm(np.diff(interpolate(path, time).position[:, :2], axis=0), axis=1)
        for path in (pairs.estimate, pairs.truth)
    ]
    apart = np.diff(time) <= round(interval * 1.001e6)  # nothing over a gap
    if not apart.any():
        return None
    return float(np.sqrt(np.mean((steps[0] - steps[1])[apart] ** 2)))


def _thinned(position: Floats) -> list[list[float]]:
    travelled = path_length(position)
    places = np.linspace(0, travelled[-1], POINTS)
    index = np.unique(np.searchsorted(travelled, places).clip(0, len(position) - 1))
    return [[round(float(x), 4), round(float(y), 4)] for x, y in position[index, :2]]


def _rounded(values: Floats) -> list[float]:
    return [round(float(value), 5) for value in values]
