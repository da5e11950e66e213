"""Placing the estimate in the truth's frame."""

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from gprodom import rotation
from gprodom.arrays import Bools, Floats
from gprodom.errors import Error
from gprodom.options import Parser
from gprodom.score.associate import Pairs
from gprodom.trajectory import Trajectory, path_length

Alignment = Literal["none", "first", "se2", "se3"]
ALIGNMENTS: tuple[Alignment, ...] = get_args(Alignment)
FIRST_M = 3.0

# Errors after a planar alignment are distances in the horizontal plane: heights are not fitted.
PLANAR: frozenset[Alignment] = frozenset({"first", "se2"})


@dataclass(frozen=True)
class Transform:
    """p_truth = matrix p_estimate + translation (metres)."""

    matrix: Floats
    translation: Floats

    def apply(self, trajectory: Trajectory) -> Trajectory:
        """The trajectory transformed."""
        return trajectory.transformed(self.matrix, self.translation)

    def inverse(self) -> "Transform":
        """The inverse transform."""
        return Transform(self.matrix.T, -self.matrix.T @ self.translation)


def first_metres(position: Floats, metres: float) -> Bools:
    """Mask (n,) of the points up to where the path (n, 3) has travelled `metres`."""
    travelled = path_length(position)
    if metres <= 0:
        raise Error(f"--first-m {metres:g}: expected a distance above 0")
    if travelled[-1] < metres:
        raise Error(
            f"the truth travels {travelled[-1]:.2f} m, less than the {metres:g} m to align by: "
            "give a shorter --first-m, or another --align"
        )
    return travelled <= metres


def fit_planar(source: Floats, target: Floats) -> Transform:
    """Least-squares rotation about z and translation (Kabsch in the plane; z by its mean)."""
    a, b = source - source.mean(axis=0), target - target.mean(axis=0)
    cross = float(np.sum(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]))
    dot = float(np.sum(a[:, 0] * b[:, 0] + a[:, 1] * b[:, 1]))
    if np.hypot(cross, dot) < 1e-9:
        raise Error("cannot align: the trajectory or the truth does not move; try --align none")
    matrix = rotation.yaw_matrix(np.arctan2(cross, dot))
    return Transform(matrix, target.mean(axis=0) - matrix @ source.mean(axis=0))


def fit_spatial(source: Floats, target: Floats) -> Transform:
    """Least-squares rotation and translation in space (Umeyama 1991 without scale)."""
    a, b = source - source.mean(axis=0), target - target.mean(axis=0)
    u, d, vt = np.linalg.svd(b.T @ a / len(a))
    if np.count_nonzero(d > np.finfo(float).eps) < 2:
        raise Error(
            "cannot align by SE(3): the points lie on one line, so its roll is undetermined; "
            "use --align se2"
        )
    sign = np.diag([1.0, 1.0, np.sign(np.linalg.det(u) * np.linalg.det(vt))])
    matrix = u @ sign @ vt
    return Transform(matrix, target.mean(axis=0) - matrix @ source.mean(axis=0))


def fit(pairs: Pairs, alignment: Alignment, first_m: float = FIRST_M) -> Transform:
    """The transform that `alignment` asks for.

    none: identity. first: rotation about z and translation, fitted over the first `first_m` metres
    that the truth travels. se2: the same over all pairs. se3: rotation and translation over all.
    """
    source, target = pairs.estimate.position, pairs.truth.position
    if alignment == "none":
        return Transform(np.eye(3), np.zeros(3))
    if alignment == "first":
        used = first_metres(target, first_m)
        return fit_planar(source[used], target[used])
    return fit_planar(source, target) if alignment == "se2" else fit_spatial(source, target)


def add_align_option(
    parser: Parser, what: str = "alignment as in gprodom score (default se2)"
) -> None:
    """``--align``."""
    parser.choice("--align", ALIGNMENTS, "se2", what)


def add_first_m_option(parser: Parser) -> None:
    """``--first-m``."""
    parser.option(
        "--first-m M", FIRST_M, f"metres that --align first aligns by (default {FIRST_M:g})"
    )
