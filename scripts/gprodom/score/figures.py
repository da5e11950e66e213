"""The figures of a score, on associated pairs."""

from dataclasses import dataclass

import numpy as np

from gprodom import rotation
from gprodom.arrays import Floats, Ints
from gprodom.score.align import PLANAR, Alignment, Transform, fit
from gprodom.score.associate import Pairs
from gprodom.score.consistency import TruthError, nees_xy
from gprodom.trajectory import path_length

RPE_DISTANCE_M = 1.0


@dataclass(frozen=True)
class Figures:
    """The figures of a score; None if the data do not give it.

    ate_rmse_m: RMS distance between aligned estimate and truth; in the plane for the alignments
      `first` and `se2`, in space for `none` and `se3`.
    rpe_1m_m: RMS relative error over consecutive stretches in which the truth travels 1 m: of the
      distance between the stretch's end points, or, where truth has attitude, of the full relative
      translation. Independent of the alignment.
    end_m: distance between estimate and truth at the last pair, after alignment.
    distance_pct: end_m in percent of the distance that the truth travels.
    nees_xy, nees_yaw: mean normalised squared error of (x, y) and of yaw (2 and 1 degrees of
      freedom), by the estimate's own covariance and the truth's own error, whatever the alignment
      (`consistency`). None without covariances; nees_yaw also None where truth has no attitude.
    n: pairs. excluded: truth points outside the estimate's span or in its gaps; excluded_s and
      excluded_m: for how long that is, and how far the truth travels meanwhile.
    distance_m: distance that the truth travels.
    """

    ate_rmse_m: float
    rpe_1m_m: float | None
    end_m: float
    distance_pct: float | None
    nees_xy: float | None
    nees_yaw: float | None
    n: int
    excluded: int
    excluded_s: float
    excluded_m: float
    distance_m: float


FIGURE_NAMES = ("ate_rmse_m", "rpe_1m_m", "end_m", "distance_pct", "nees_xy", "nees_yaw", "n")


@dataclass(frozen=True)
class Comparison:
    """A score with what its pictures need: the pairs, the alignment and the error at each pair."""

    figures: Figures
    pairs: Pairs
    alignment: Alignment
    transform: Transform
    error_m: Floats  # (n,)


def errors(pairs: Pairs, transform: Transform, planar: bool) -> Floats:
    """Distances (n,), metres, between the transformed estimate and the truth."""
    difference = transform.apply(pairs.estimate).position - pairs.truth.position
    return np.asarray(np.linalg.norm(difference[:, : 2 if planar else 3], axis=1))


def stretches(position: Floats, metres: float) -> Ints:
    """Indices (k,) that cut a path (n, 3) into consecutive stretches of at least `metres`."""
    cuts, travelled = [0], 0.0
    steps = np.linalg.norm(np.diff(position, axis=0), axis=1)
    for i, step in enumerate(steps, start=1):
        travelled += float(step)
        if travelled >= metres:
            cuts.append(i)
            travelled = 0.0
    return np.array(cuts, dtype=np.int64)


def relative_errors(pairs: Pairs, metres: float = RPE_DISTANCE_M) -> Floats:
    """Relative errors (k,), metres, over stretches in which the truth travels `metres`."""
    cuts = stretches(pairs.truth.position, metres)
    i, j = cuts[:-1], cuts[1:]
    estimate, truth = pairs.estimate, pairs.truth
    step_estimate = estimate.position[j] - estimate.position[i]
    step_truth = truth.position[j] - truth.position[i]
    if estimate.orientation is None or truth.orientation is None:
        return np.asarray(
            np.abs(np.linalg.norm(step_estimate, axis=1) - np.linalg.norm(step_truth, axis=1))
        )
    body_estimate = _into_body(estimate.orientation[i], step_estimate)
    body_truth = _into_body(truth.orientation[i], step_truth)
    # The norm of inv(truth step) * estimate step does not depend on its rotation.
    return np.asarray(np.linalg.norm(body_estimate - body_truth, axis=1))


def _into_body(q: Floats, vectors: Floats) -> Floats:
    return np.asarray(np.einsum("nji,nj->ni", rotation.to_matrix(q), vectors))


def nees_yaw(pairs: Pairs) -> float | None:
    """Mean normalised error squared of yaw, the first poses made equal; None without meaning."""
    estimate, truth = pairs.estimate, pairs.truth
    if estimate.covariance is None or estimate.orientation is None or truth.orientation is None:
        return None
    variance = estimate.covariance[:, 5, 5]
    if np.any(variance <= 0):
        return None
    turn = rotation.multiply(estimate.orientation, rotation.conjugate(truth.orientation))
    first = rotation.multiply(rotation.conjugate(turn[:1]), turn)
    return float(np.mean(rotation.to_vector(first)[:, 2] ** 2 / variance))


def compare(
    pairs: Pairs,
    alignment: Alignment,
    first_m: float,
    truth_error: TruthError = TruthError(),  # noqa: B008 (a constant)
) -> Comparison:
    """All figures of one estimate against one truth."""
    transform = fit(pairs, alignment, first_m)
    error = errors(pairs, transform, alignment in PLANAR)
    relative = relative_errors(pairs)
    distance = float(path_length(pairs.truth.position)[-1])
    figures = Figures(
        ate_rmse_m=_rms(error),
        rpe_1m_m=_rms(relative) if relative.size else None,
        end_m=float(error[-1]),
        distance_pct=100 * float(error[-1]) / distance if distance > 0 else None,
        nees_xy=nees_xy(pairs, truth_error),
        nees_yaw=nees_yaw(pairs),
        n=len(pairs.truth),
        excluded=pairs.excluded,
        excluded_s=pairs.excluded_s,
        excluded_m=pairs.excluded_m,
        distance_m=distance,
    )
    return Comparison(figures, pairs, alignment, transform, error)


def _rms(values: Floats) -> float:
    return float(np.sqrt(np.mean(np.square(values))))
