#!/usr/bin/env python3
"""How ground differs beside a track: correlation of neighbouring real lines, and the length fitted.

DATA holds `seal_beach` (lines 20 cm apart). In patches of 1.8 m, the shift along the track between
two lines is found on one half of the depths and the correlation is taken on the other half, so that
the search favours no correlation. Along the track the correlation is that of a line with itself,
over its value between neighbouring traces extrapolated to no distance, since noise lowers all.

Columns: distance (m), correlation aside and along. `stretch`: along the track the correlation falls
as far in `stretch` times the distance, where the next lines are. `lateral_m`: l of cos(d / l) with
the curvature at small d of the correlation along the track, less that stretch
(docs/simulation.md).

    bench/lateral.py ../shared/data/real_ground [--json]
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from gprodom.arrays import Floats
from program import exit_with, list_of, parser_of, print_figures, table_of

PATCH, REACH = 100, 28  # traces: 1.8 m, and 0.5 m, as lines start up to 25 cm apart
DEPTH = slice(15, 120)  # samples: 5 to 38 ns; below, noise is as strong as the ground
BAND = (1e8, 6e8)  # Hz
BLOCK = 20  # samples, of a depth that counts as one: more than the pulse
SMALL_M = 0.06  # m, along the track: within the antenna's footprint


def correlation(a: Floats, b: Floats) -> float:
    """Of two pictures."""
    return float(np.sum(a * b) / np.sqrt(np.sum(a * a) * np.sum(b * b)))


def read_lines(folder: Path) -> tuple[Floats, float]:
    """(lines, traces, samples), filtered and of equal strength at each depth; spacing, m."""
    files = [np.load(path) for path in sorted(folder.glob("line_*.npz"))]
    count = min(len(file["traces"]) for file in files)
    traces = np.array([file["traces"][:count].astype(float) for file in files])
    traces -= np.median(traces, axis=1, keepdims=True)
    frequency = np.fft.rfftfreq(traces.shape[2], float(files[0]["sample_interval"]))
    spectrum = np.fft.rfft(traces, axis=2)
    spectrum[..., (frequency < BAND[0]) | (frequency > BAND[1])] = 0
    traces = np.fft.irfft(spectrum, traces.shape[2], axis=2)[..., DEPTH]
    traces /= np.sqrt((traces**2).mean(axis=(0, 1)))
    return np.clip(traces, -4, 4), float(files[0]["spacing"])  # a few traces are glitches


def beside(lines: Floats, apart: int) -> float:
    """Correlation of lines that are `apart` lines apart."""
    half = np.arange(lines.shape[2]) // BLOCK % 2 == 0
    found = []
    for a, b in zip(lines, lines[apart:], strict=False):
        for begin in range(REACH, lines.shape[1] - PATCH - REACH, PATCH // 2):
            here = a[begin : begin + PATCH]
            there = [b[begin + s : begin + s + PATCH] for s in range(-REACH, REACH + 1)]
            for fit in (half, ~half):
                best = np.argmax([correlation(here[:, fit], each[:, fit]) for each in there])
                found.append(correlation(here[:, ~fit], there[best][:, ~fit]))
    return float(np.mean(found))


def along(lines: Floats, steps: int) -> float:
    """Correlation of lines with themselves, `steps` traces on."""
    return float(np.mean([correlation(line[:-steps], line[steps:]) for line in lines]))


def measure(folder: Path) -> dict[str, Any]:
    """The figures."""
    lines, spacing = read_lines(folder)
    own = np.array([along(lines, steps) for steps in range(1, 40)])
    distance = spacing * np.arange(1, 40)
    near = distance < SMALL_M
    # own = start (1 - d^2 / 2 l^2) at small d: without noise start would be 1.
    slope, start = np.polyfit(distance[near] ** 2, own[near], 1)
    own = own / start
    rows = [
        {"m": 0.2 * k, "aside": beside(lines, k), "along": float(np.interp(0.2 * k, distance, own))}
        for k in (1, 2, 3)
    ]
    falls = float(np.interp(-rows[0]["aside"], -own, distance))
    stretch = falls / 0.2
    return {
        "rows": rows,
        "along_curvature_m": float(np.sqrt(-start / (2 * slope))),
        "stretch": stretch,
        "lateral_m": float(np.sqrt(-start / (2 * slope))) / stretch,
    }


def main() -> None:
    """Runs the command line."""
    parser = parser_of(__doc__)
    parser.add_argument("data", metavar="DATA", type=Path, help="folder real_ground")
    args = parser.parse_args()
    found = measure(args.data / "seal_beach")
    lengths = {key: value for key, value in found.items() if key != "rows"}
    print_figures(args, found, f"{table_of(found['rows'])}\n{list_of(lengths)}")


if __name__ == "__main__":
    exit_with(main)
