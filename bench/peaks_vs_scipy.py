#!/usr/bin/env python3
"""How much faster the peak fit is than scipy.optimize.curve_fit on the same pulses, in one run.

Traces of 201 samples hold one damped sinusoid each (500 MHz at 0.2 ns, down to a tenth in 2 to 3
periods, any phase, SNR 20). Ours is timed from trace to peaks: envelope, pulse search, gate, fit,
covariance and the conversion to Python objects. scipy is given our gates and its model's true
parameters to start from, and does nothing but the fit. Both are timed in turns, in CPU time, and
the fastest turn of each counts. Exit code 1 where the ratio is under 50.

    bench/peaks_vs_scipy.py
    bench/peaks_vs_scipy.py --pulses 500 --turns 5 --json
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import curve_fit

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "scripts"))
from gprodom import gpr

Floats = NDArray[np.float64]
OMEGA = 0.2 * np.pi  # rad per sample
SNR = 20.0
NEEDED = 50.0


def damped(i: Floats, alpha: float, beta: float, gamma: float, omega: float, phi: float) -> Floats:
    """A'(i) = beta exp(-alpha i) cos(omega i + phi) + gamma."""
    return beta * np.exp(-alpha * i) * np.cos(omega * i + phi) + gamma


def make_traces(count: int) -> tuple[NDArray[np.float32], Floats, NDArray[np.int64]]:
    """Traces (count, 201), true parameters (count, 5) of `damped` and onsets (count,)."""
    random = np.random.default_rng(1)
    traces, parameters, onsets = [], [], []
    for _ in range(count):
        onset = int(random.integers(30, 150))
        truth = [np.log(10) / random.uniform(20, 30), 1.0, 0.0, OMEGA, random.uniform(-3.1, 3.1)]
        i = np.arange(201.0) - onset
        trace = np.where(i >= 0, damped(np.maximum(i, 0.0), *truth), 0.0)
        traces.append(trace + random.normal(0.0, 1.0 / SNR, 201))
        parameters.append(truth)
        onsets.append(onset)
    return np.array(traces, np.float32), np.array(parameters), np.array(onsets)


def cpu_seconds(work: Callable[[], object]) -> float:
    """CPU time of one call."""
    start = time.process_time()
    work()
    return time.process_time() - start


def main() -> int:
    """Prints both times and their ratio."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--pulses", type=int, default=200, help="pulses fitted in a turn")
    parser.add_argument("--turns", type=int, default=5, help="turns, of which the fastest counts")
    parser.add_argument("--json", action="store_true", help="print figures as JSON")
    arguments = parser.parse_args()
    if arguments.pulses < 1 or arguments.turns < 1:
        parser.error("--pulses and --turns must be 1 or more")

    traces, parameters, onsets = make_traces(arguments.pulses)
    options = gpr.PeakOptions(noise_sigma=1.0 / SNR, min_relative=0.4)
    extractor = gpr.PeakExtractor(options)
    matched = [
        (row, peaks[0])
        for row, peaks in enumerate(extractor.extract_all(traces))
        if len(peaks) == 1 and abs(peaks[0].gate_begin - onsets[row]) <= 1
    ]
    traces = traces[[row for row, _ in matched]]
    pulses = [
        (trace[peak.gate_begin : peak.gate_end].astype(float), parameters[row], peak)
        for trace, (row, peak) in zip(traces, matched, strict=True)
    ]

    def scipy_fit() -> float:
        misfit = 0.0
        for data, truth, peak in pulses:
            i = np.arange(data.size, dtype=float)
            best, _ = curve_fit(damped, i, data, truth)
            misfit = max(misfit, abs(best[3] - peak.omega) / np.sqrt(peak.covariance[5, 5]))
        return misfit

    ours, theirs = [], []
    for _ in range(arguments.turns):
        ours.append(cpu_seconds(lambda: extractor.extract_all(traces)) / len(traces))
        theirs.append(cpu_seconds(scipy_fit) / len(pulses))
    figures = {
        "pulses": len(pulses),
        "ours_us": 1e6 * min(ours),
        "scipy_us": 1e6 * min(theirs),
        "ratio": min(theirs) / min(ours),
        "largest_difference_of_omega_in_sigmas": scipy_fit(),
    }
    if arguments.json:
        print(json.dumps(figures))
    else:
        print(
            f"{figures['pulses']} pulses: ours {figures['ours_us']:.1f} us a pulse, "
            f"curve_fit {figures['scipy_us']:.0f} us, ratio {figures['ratio']:.0f} "
            f"(at least {NEEDED:.0f} wanted); omega differs by at most "
            f"{figures['largest_difference_of_omega_in_sigmas']:.3f} of its sigma"
        )
    return 0 if figures["ratio"] >= NEEDED else 1


if __name__ == "__main__":
    sys.exit(main())
