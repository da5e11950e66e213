"""Details retention and standstills: against numpy, SciPy and PyWavelets, and on real ground."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import pywt
from numpy.typing import NDArray
from scipy.signal import firwin

gpr = pytest.importorskip("gprodom.gpr")

INTERVAL = 2e-10  # s
WAVELETS = ["db1", "db2", "db3", "db4", "db5", "db6", "db7", "db8", "sym4", "sym5", "sym6", "sym8"]


@pytest.fixture(scope="module")
def line(shared: Path) -> NDArray[Any]:
    """Traces (traces, samples) of a real line."""
    return np.asarray(np.load(shared / "real_ground/seal_beach/line_01.npz")["traces"], np.float64)


@pytest.mark.parametrize("wavelet", WAVELETS)
def test_wavelet_filters_and_transform_are_those_of_pywavelets(wavelet: str) -> None:
    rng = np.random.default_rng(1)
    for samples, levels in ((208, 4), (96, 3), (16, 4)):
        x = rng.normal(size=samples)
        details, approximation = gpr.swt(x, wavelet, levels)
        expected = pywt.swt(x, wavelet, levels)[::-1]
        for level, (_, detail) in enumerate(expected):
            np.testing.assert_allclose(details[level], detail, atol=1e-9, rtol=0)
        np.testing.assert_allclose(approximation, expected[-1][0], atol=1e-9, rtol=0)

        changed = pywt.threshold(details, 0.7, "soft")
        back = gpr.iswt(changed, 0 * approximation, wavelet)
        theirs = [(0 * approximation, detail) for detail in changed[::-1]]
        np.testing.assert_allclose(back, pywt.iswt(theirs, wavelet), atol=1e-9, rtol=0)


@pytest.mark.parametrize("samples", [208, 201])
def test_details_kept_are_those_of_pywavelets(samples: int) -> None:
    rng = np.random.default_rng(2)
    x = rng.normal(size=samples) + 20 * np.exp(-(((np.arange(samples) - 70) / 4) ** 2))
    padded = np.concatenate([x, x[::-1][: -samples % 16]])
    levels = pywt.swt(padded, "sym4", 4)
    sigma = np.median(np.abs(levels[-1][1][:samples])) / 0.6745
    limit = 0.8 * sigma * np.sqrt(2 * np.log(samples))
    kept = [(0 * a, pywt.threshold(d, limit, "soft")) for a, d in levels]
    expected = pywt.iswt(kept, "sym4")[:samples]
    np.testing.assert_allclose(gpr.keep_details(x, "sym4", 4, 0.8), expected, atol=1e-9, rtol=0)


def test_band_pass_is_scipys_window_design_run_both_ways() -> None:
    taps = gpr.design_band_pass(200e6, 850e6, INTERVAL, 20e-9)
    expected = firwin(101, [200e6, 850e6], window="triang", pass_zero=False, fs=1 / INTERVAL)
    np.testing.assert_allclose(taps, expected, atol=1e-12, rtol=0)

    x = np.random.default_rng(3).normal(size=(3, 201))
    long = np.pad(x, ((0, 0), (100, 100)), mode="edge")
    kernel = np.convolve(taps, taps[::-1])
    both_ways = np.stack([np.convolve(row, kernel, "valid") for row in long])
    ours = gpr.band_pass(x, INTERVAL, 200e6, 850e6, 20e-9)
    np.testing.assert_allclose(ours, both_ways, atol=1e-12, rtol=0)


def test_background_is_the_documented_mean() -> None:
    x = np.random.default_rng(4).normal(size=(30, 40)).astype(np.float32)
    np.testing.assert_allclose(gpr.remove_background(x), x - x.mean(axis=0), atol=1e-6)
    so_far = np.cumsum(x, axis=0) / np.arange(1, 31)[:, None]
    np.testing.assert_allclose(gpr.remove_background(x, "running"), x - so_far, atol=1e-5)


def test_time_zero_of_real_traces(line: NDArray[Any]) -> None:
    """Delays put into real traces come out again, as differences to those found without them."""
    traces = line[:, :201][gpr.check_traces(line[:, :201]) == 0][:300]
    put_in = np.random.default_rng(5).uniform(-2, 2, len(traces))
    put_in[0] = 0
    frequency = np.fft.rfftfreq(201 + 55)
    spectra = np.fft.rfft(np.pad(traces, ((0, 0), (0, 55)), mode="edge"))
    shifted = np.fft.irfft(spectra * np.exp(-2j * np.pi * put_in[:, None] * frequency))[:, :201]
    period = 1 / (300e6 * 3.125e-10)
    _, plain = gpr.track_time_zero(traces, period, 5.0)
    _, found = gpr.track_time_zero(shifted, period, 5.0)
    error = found - plain - put_in
    assert np.median(np.abs(error)) < 0.05
    assert np.mean(np.abs(error) < 0.3) > 0.97


def test_glitched_traces_of_real_ground_are_found(shared: Path) -> None:
    """Where a trace is unlike both neighbours and these are alike, and hardly anywhere else."""
    glitched = missed = flagged = total = 0
    for number in range(1, 21):
        data = np.load(shared / f"real_ground/seal_beach/line_{number:02d}.npz")["traces"]
        x = data[:, :201].astype(np.float64)
        x -= x.mean(axis=1, keepdims=True)

        def unlike(a: NDArray[Any], b: NDArray[Any]) -> NDArray[Any]:
            power = (a**2).sum(axis=1) + (b**2).sum(axis=1)
            return np.asarray(((a - b) ** 2).sum(axis=1) / power)

        before, after = unlike(x[1:-1], x[:-2]), unlike(x[1:-1], x[2:])
        clear = (before > 0.5) & (after > 0.5) & (unlike(x[2:], x[:-2]) < 0.1)
        bad = gpr.check_traces(data[:, :201]) != 0
        glitched += int(clear[10:].sum())
        missed += int((clear & ~bad[1:-1])[10:].sum())
        flagged += int(bad.sum())
        total += len(bad)
    assert glitched > 10
    assert missed <= 0.05 * glitched
    assert flagged < 0.04 * total


def test_details_of_real_ground(line: NDArray[Any]) -> None:
    """Bad traces go no further; neighbours, 1.8 cm apart, still agree without their background."""
    config = gpr.FilterConfig()
    config.gain_rate, config.gain_power = 0.015, 0.5
    out, quality, delay, noise = gpr.DetailsRetention(config).filter(line[:, :201], 3.125e-10)
    good = quality == 0
    assert np.isfinite(out[good]).all()
    assert np.isnan(out[~good]).all()
    assert (np.abs(delay) <= 4).all()
    assert (noise[good][1:] > 0).all()  # the first trace is its own background
    settled = np.flatnonzero(good[:-1] & good[1:])[100:]
    a, b = np.float64(out[settled, 40:]), np.float64(out[settled + 1, 40:])
    similarity = (a * b).sum(1) / np.sqrt((a**2).sum(1) * (b**2).sum(1))
    assert np.median(similarity) > 0.7


def test_bad_arguments_are_refused() -> None:
    x = np.zeros((2, 40))
    calls: list[Callable[[], Any]] = [
        lambda: gpr.swt(np.zeros(20), "db2", 3),
        lambda: gpr.keep_details(x, "haar"),
        lambda: gpr.band_pass(x, INTERVAL, 9e8, 1e8),
        lambda: gpr.band_pass(x, 0.0),
        lambda: gpr.remove_background(x, "mean"),
        lambda: gpr.remove_background(x, "window", 0),
        lambda: gpr.check_traces(x[0]),
        lambda: gpr.dewow(x, -1),
        lambda: gpr.standstills(np.arange(3), x, INTERVAL),
        lambda: gpr.DetailsRetention().filter(x, -1.0),
    ]
    for call in calls:
        with pytest.raises((ValueError, TypeError)):
            call()
