"""The feature matrix and its matching against a plain numpy statement of the paper's equations."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.optimize import curve_fit

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


# Peaks of traces: the fit against scipy on the same samples, and what Python passes and gets.


OMEGA = 0.2 * np.pi  # rad per sample: 500 MHz at 0.2 ns


def damped(i: Floats, alpha: float, beta: float, gamma: float, omega: float, phi: float) -> Floats:
    """A'(i) = beta exp(-alpha i) cos(omega i + phi) + gamma."""
    return beta * np.exp(-alpha * i) * np.cos(omega * i + phi) + gamma


def noisy_pulse(random: np.random.Generator, onset: int, sigma: float) -> Floats:
    """A trace (201,) of noise and one pulse that decays to a tenth in 2.5 periods."""
    i = np.arange(201.0) - onset
    phase = random.uniform(-np.pi, np.pi)
    pulse = damped(np.maximum(i, 0.0), np.log(10) / 25, 1.0, 0.0, OMEGA, phase)
    return np.where(i >= 0, pulse, 0.0) + random.normal(0.0, sigma, 201)


def test_fit_equals_scipy_on_the_same_samples() -> None:
    random = np.random.default_rng(1)
    extractor = gpr.PeakExtractor(gpr.PeakOptions(noise_sigma=0.02, min_relative=0.4))
    order = [2, 3, 4, 5, 6]  # alpha, beta, gamma, omega, phi
    for _ in range(100):
        trace = noisy_pulse(random, int(random.integers(30, 150)), 0.02).astype(np.float32)
        (peak,) = extractor.extract(trace)
        ours = np.array([peak.alpha, peak.beta, peak.gamma, peak.omega, peak.phi])
        i = np.arange(peak.gate_end - peak.gate_begin, dtype=float)
        data = trace[peak.gate_begin : peak.gate_end].astype(float)
        theirs, covariance = curve_fit(
            damped, i, data, ours, sigma=np.full(i.size, 0.02), absolute_sigma=True
        )
        sigmas = np.sqrt(np.diag(covariance))
        assert np.all(np.abs(ours - theirs) < 0.05 * sigmas)
        ratio = peak.covariance[np.ix_(order, order)] / np.outer(sigmas, sigmas)
        believed = ratio[0, 0] / (covariance[0, 0] / sigmas[0] ** 2)  # 1, or the residual's scale
        np.testing.assert_allclose(
            ratio / believed, covariance / np.outer(sigmas, sigmas), atol=0.05
        )


def test_peak_is_the_first_maximum_of_the_curve() -> None:
    random = np.random.default_rng(2)
    extractor = gpr.PeakExtractor(gpr.PeakOptions(noise_sigma=0.02, min_relative=0.4))
    for _ in range(50):
        (peak,) = extractor.extract(noisy_pulse(random, 60, 0.02))
        i = np.arange(0.0, 15.0, 1e-3)
        curve = damped(i, peak.alpha, peak.beta, peak.gamma, peak.omega, peak.phi)
        first = 1 + int(np.argmax((curve[1:-1] >= curve[:-2]) & (curve[1:-1] > curve[2:])))
        assert peak.sample == pytest.approx(peak.gate_begin + i[first], abs=2e-3)
        assert peak.amplitude == pytest.approx(curve[first], abs=1e-5)


def test_shapes_are_checked_and_options_are_keywords() -> None:
    extractor = gpr.PeakExtractor()
    with pytest.raises(ValueError, match=r"\(samples,\)"):
        extractor.extract(np.zeros((2, 201)))
    with pytest.raises(ValueError, match=r"\(traces, samples\)"):
        extractor.extract_all(np.zeros(201))
    with pytest.raises(ValueError, match="max_joint"):
        gpr.PeakExtractor(gpr.PeakOptions(max_joint=7))
    with pytest.raises(TypeError):
        gpr.PeakOptions(True)


def test_real_ground(shared: Path) -> None:
    """On real traces most pulses are damped sinusoids and the fit leaves little of them."""
    line = np.load(shared / "real_ground" / "seal_beach" / "line_01.npz")
    traces = line["traces"][:, :201].astype(float)
    traces = traces - np.median(traces, axis=0)
    spectrum = np.fft.rfft(traces, axis=1)
    frequency = np.fft.rfftfreq(201, float(line["sample_interval"]))
    band = (frequency > 120e6) & (frequency < 510e6)
    traces = np.fft.irfft(spectrum * band, 201, axis=1)
    extractor = gpr.PeakExtractor()
    peaks = [peak for row in extractor.extract_all(traces) for peak in row]
    counts = extractor.counts
    assert counts.traces == len(traces)
    assert counts.accepted == len(peaks)
    assert counts.accepted > 0.75 * counts.pulses
    assert np.median([peak.residual for peak in peaks]) < 0.2
