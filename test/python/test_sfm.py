"""The feature matrix and its matching against a plain numpy statement of the paper's equations."""

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

gpr = pytest.importorskip("gprodom.gpr")

Floats = NDArray[np.float64]


def numpy_sfm(
    depth: Floats,
    position: Floats,
    amplitude: Floats,
    shape: tuple[int, int],
    D: float,
    L: float,
    scale: float,
) -> NDArray[np.int64]:
    """S(floor(d D_S / D), floor(r L_S / L)) = floor(10 m / 255), the largest of each cell."""
    D_S, L_S = shape
    m = np.minimum(255.0, 255.0 * np.maximum(amplitude, 0.0) / scale)
    row = np.clip(np.floor(depth * D_S / D), 0, D_S - 1).astype(int)
    column = np.clip(np.floor(position * L_S / L), 0, L_S - 1).astype(int)
    S = np.zeros(shape, dtype=np.int64)
    np.maximum.at(S, (row, column), np.clip(np.floor(10.0 * m / 255.0), 0, 10).astype(int))
    return S


def numpy_distances(A: Floats, B: Floats, min_overlap: float, form: str) -> Floats:
    """Distance of columns c of A and c + l of B for l = -limit..limit; NaN without energy."""
    L = A.shape[1]
    limit = L - int(np.ceil(min_overlap * L))
    out = []
    for shift in range(-limit, limit + 1):
        w = L - abs(shift)
        a = A[:, max(0, -shift) :][:, :w].astype(float)
        b = B[:, max(0, shift) :][:, :w].astype(float)
        energy = (a * a).sum() * (b * b).sum()
        below = np.sqrt(energy) if form == "cosine" else energy
        out.append(1.0 - (a * b).sum() / below if energy > 0 else np.nan)
    return np.array(out)


def assert_matches(A: NDArray[Any], B: NDArray[Any], align: Any, tolerance: float) -> None:
    for form in ("cosine", "printed"):
        alignment, distances = align(A, B, form=form)
        expected = numpy_distances(A, B, 0.3, form)
        np.testing.assert_allclose(distances, expected, rtol=0, atol=tolerance)
        limit = len(expected) // 2
        least = np.nanmin(expected)
        assert distances[alignment.shift + limit] <= least + tolerance
        assert alignment.valid == (
            abs(alignment.shift) < limit
            and np.isfinite(expected[alignment.shift + limit + np.array([-1, 1])]).all()
        )


def test_random_peaks() -> None:
    random = np.random.default_rng(1)
    for shape in ((50, 50), (13, 20), (64, 37)):
        windows = []
        for _ in range(2):
            depth, position = random.uniform(-0.1, 3.2, 500), random.uniform(-1, 101, 500)
            amplitude = random.exponential(2.0, 500)
            S = gpr.build_sfm(
                depth,
                position,
                amplitude,
                rows=shape[0],
                columns=shape[1],
                depth_range=3.0,
                length=100.0,
                amplitude_scale=6.0,
            )
            assert S.dtype == np.int8
            np.testing.assert_array_equal(
                S, numpy_sfm(depth, position, amplitude, shape, 3.0, 100.0, 6.0)
            )
            windows.append(S)
        assert_matches(windows[0], windows[1], gpr.align_sfm, 1e-12)
        real = random.normal(size=(2, *shape))
        assert_matches(
            real[0].astype(np.float32), real[1].astype(np.float32), gpr.align_bscan, 1e-6
        )


def test_wrong_sizes_are_told() -> None:
    with pytest.raises(ValueError, match="same length"):
        gpr.build_sfm([1.0], [1.0, 2.0], [1.0], depth_range=1, length=1, amplitude_scale=1)
    with pytest.raises(ValueError, match="same size"):
        gpr.align_sfm(np.zeros((5, 5), np.int8), np.zeros((5, 6), np.int8))
    with pytest.raises(ValueError, match="cosine"):
        gpr.align_sfm(np.zeros((5, 5), np.int8), np.zeros((5, 5), np.int8), form="euclid")
