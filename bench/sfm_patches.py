"""Matching on real ground: patches of one line that share no trace, then neighbouring lines.

Lines of Seal Beach (wheel-triggered, 1.83 cm a trace, 300 MHz) take the place of distance-indexed
radar. Even traces make one stream and odd traces another; a window of the even stream is matched
with one of the odd stream that lies 1 to 30 traces further on, so the true shift is known to a
fraction of a column and no trace is in both. Then line n against line n + 1, 20 cm aside, whose
starts differ by an unknown constant of up to some 25 cm: the true shift of a pair of lines is taken
to be the median that the B-scans' matches find with the search limited to 59 cm. Searched are all
shifts, and those alone.

    python bench/sfm_patches.py [LINES_FOLDER] [--no-fit | --max-joint N] [--json]
"""

from __future__ import annotations

import argparse
import json
import os
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gprodom import gpr

Floats = NDArray[np.float64]

CHECKOUT = Path(__file__).resolve().parents[1]
WINDOW = 100  # L, traces
COLUMNS = 50  # L_S
ROWS = 50  # D_S
PER_TRACE = COLUMNS / WINDOW
SHIFTS = range(1, 31)
SCALE_M = 5.0  # the first metres, which fix the amplitude scale
NEAR = 16  # columns, 59 cm: where the neighbouring line is looked for when something is known
BAND_HZ = (1.0e8, 6.0e8)  # of the 300 MHz antenna
GAIN_RATE, GAIN_FLAT_AFTER = 0.012, 351  # 1/sample, samples: deep echoes get levels too


@dataclass(frozen=True)
class Line:
    """One line: filtered traces (n, samples) with zeros for bad ones, and their peaks.

    depth, position, amplitude: (peaks,), of peaks; sample, trace and filtered counts. spacing: m.
    """

    filtered: NDArray[np.float32]
    depth: Floats
    position: Floats
    amplitude: Floats
    spacing: float

    def every_second(self, first: int) -> Line:
        """The stream of traces first, first + 2, ..."""
        mine = (self.position.astype(int) - first) % 2 == 0
        position = (self.position[mine] - first) / 2
        return Line(
            self.filtered[first::2],
            self.depth[mine],
            position,
            self.amplitude[mine],
            2 * self.spacing,
        )

    def scale(self) -> float:
        """Amplitude drawn as 255: the 0.99 quantile over the first metres."""
        early = self.position * self.spacing < SCALE_M
        return float(np.quantile(self.amplitude[early], 0.99))

    def sfm(self, first: int, scale: float) -> NDArray[np.int8]:
        """Feature matrix of the window that begins at trace `first`."""
        inside = (self.position >= first) & (self.position < first + WINDOW)
        return gpr.build_sfm(
            self.depth[inside], self.position[inside] - first, self.amplitude[inside],
            rows=ROWS, columns=COLUMNS, depth_range=float(self.filtered.shape[1]),
            length=float(WINDOW), amplitude_scale=scale,
        )  # fmt: skip

    def window(self, first: int) -> NDArray[np.float32]:
        """The window itself, (samples, columns): mean of the traces of each column."""
        traces = self.filtered[first : first + WINDOW]
        return traces.reshape(COLUMNS, -1, traces.shape[1]).mean(axis=1).T


def load_line(path: Path, options: gpr.PeakOptions) -> Line:
    """A line through the filter chain and the peak extraction."""
    with np.load(path) as file:
        traces = file["traces"].astype(np.float32)
        spacing, interval = float(file["spacing"]), float(file["sample_interval"])
    config = gpr.FilterConfig()
    config.band_low, config.band_high = BAND_HZ
    config.gain_rate, config.gain_flat_after = GAIN_RATE, GAIN_FLAT_AFTER
    filtered, quality, _, _ = gpr.DetailsRetention(config).filter(traces, interval)
    filtered[quality != 0] = 0.0
    peaks = gpr.PeakExtractor(options).extract_all(filtered)
    flat = [(p.sample, r, p.amplitude) for r, found in enumerate(peaks) for p in found]
    depth, position, amplitude = np.array(flat, dtype=float).T
    return Line(filtered, depth, position, amplitude, spacing)


@dataclass
class Matches:
    """Integer and sub-column shifts found, with their standard deviations, and the true ones."""

    shift: list[int]
    subcolumn: list[float]
    sigma: list[float]
    valid: list[bool]
    true: list[float]

    @classmethod
    def empty(cls) -> Matches:
        """None yet."""
        return cls([], [], [], [], [])

    def add(self, alignment: Any, true: float) -> None:
        """One more window pair."""
        self.shift.append(alignment.shift)
        self.subcolumn.append(alignment.subcolumn)
        self.sigma.append(float(np.sqrt(alignment.variance)))
        self.valid.append(alignment.valid)
        self.true.append(true)


def same_line(lines: list[Line], step: int) -> dict[str, Matches]:
    """Even against odd traces of each line, every `step` traces along it, for every shift."""
    found = {"sfm": Matches.empty(), "bscan": Matches.empty()}
    for line in lines:
        even, odd = line.every_second(0), line.every_second(1)
        scale = even.scale()
        last = min(len(even.filtered), len(odd.filtered)) - WINDOW - max(SHIFTS)
        odd_sfm = {i: odd.sfm(i, scale) for i in range(last + max(SHIFTS))}
        for first in range(0, last, step):
            sfm, window = even.sfm(first, scale), even.window(first)
            for shift in SHIFTS:
                # Odd trace i lies half a trace of its stream behind even trace i.
                true = -(shift + 0.5) * PER_TRACE
                found["sfm"].add(gpr.align_sfm(sfm, odd_sfm[first + shift])[0], true)
                found["bscan"].add(gpr.align_bscan(window, odd.window(first + shift))[0], true)
    return found


def next_line(lines: list[Line], step: int) -> dict[str, Matches]:
    """Line n against n + 1 at each place, over all shifts and over the near ones."""
    found = {name: Matches.empty() for name in ("sfm", "bscan", f"sfm {NEAR}", f"bscan {NEAR}")}
    for here, aside in pairwise(lines):
        scale = here.scale()
        last = min(len(here.filtered), len(aside.filtered)) - WINDOW
        firsts = range(0, last, step)
        windows = [(here.window(first), aside.window(first)) for first in firsts]
        matrices = [(here.sfm(first, scale), aside.sfm(first, scale)) for first in firsts]
        near = [gpr.align_bscan(*pair, max_shift=NEAR)[0] for pair in windows]
        true = float(np.median([alignment.subcolumn for alignment in near]))
        for alignment in near:
            found[f"bscan {NEAR}"].add(alignment, true)
        for pair in windows:
            found["bscan"].add(gpr.align_bscan(*pair)[0], true)
        for pair in matrices:
            found["sfm"].add(gpr.align_sfm(*pair)[0], true)
            found[f"sfm {NEAR}"].add(gpr.align_sfm(*pair, max_shift=NEAR)[0], true)
    return found


def figures(matches: Matches, within: float) -> dict[str, float]:
    """What became of the pairs, in columns of error.

    nearest_column: share whose whole shift lies within half a column of the truth. within: share
    whose place lies within `within` columns of it. error_over_sigma: RMS of the error over its own
    standard deviation, of pairs that are valid and within.
    """
    error = np.array(matches.subcolumn) - np.array(matches.true)
    nearest = np.abs(np.array(matches.shift) - np.array(matches.true)) <= 0.5 + 1e-9
    close, valid = np.abs(error) <= within, np.array(matches.valid)
    usable = close & valid
    ratio = error[usable] / np.array(matches.sigma)[usable]
    return {
        "pairs": int(error.size),
        "valid": float(valid.mean()),
        "nearest_column": float(nearest.mean()),
        "within": float(close.mean()),
        "rms_columns": float(np.sqrt(np.mean(error**2))),
        "rms_of_close_columns": float(np.sqrt(np.mean(error[usable] ** 2))),
        "median_abs_columns": float(np.median(np.abs(error))),
        "error_over_sigma": float(np.sqrt(np.mean(ratio**2))),
    }


def default_folder() -> Path:
    """Where the lines lie beside a checkout."""
    shared = Path(os.environ.get("GPRODOM_SHARED", CHECKOUT.parent / "shared"))
    return shared / "data" / "real_ground" / "seal_beach"


def print_table(title: str, results: dict[str, dict[str, float]]) -> None:
    """One row a method."""
    print(title)
    names = list(next(iter(results.values())))
    print("  " + " ".join(f"{name:>20}" for name in ["method", *names]))
    for method, values in results.items():
        cells = [f"{values[name]:>20.4g}" for name in names]
        print("  " + " ".join([f"{method:>20}", *cells]))


def main() -> None:
    """Runs both experiments and prints their figures."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path, nargs="?", default=default_folder())
    parser.add_argument("--no-fit", action="store_true", help="envelope maxima instead of the fit")
    parser.add_argument("--max-joint", type=int, default=1, help="pulses fitted together (1)")
    parser.add_argument("--step", type=int, default=10, help="traces between windows (10)")
    parser.add_argument("--json", action="store_true")
    args = parser.parse_args()
    paths = sorted(args.folder.glob("line_*.npz"))
    if not paths:
        parser.error(f"no line_*.npz in {args.folder}")
    options = gpr.PeakOptions(fit=not args.no_fit, max_joint=args.max_joint)
    lines = [load_line(path, options) for path in paths]
    experiments: dict[str, tuple[Callable[[list[Line], int], dict[str, Matches]], float]] = {
        "even against odd traces of one line": (same_line, 0.5),
        "line n against line n + 1": (next_line, 1.0),
    }
    results = {}
    for title, (experiment, within) in experiments.items():
        found = experiment(lines, args.step)
        results[title] = {name: figures(matches, within) for name, matches in found.items()}
        if not args.json:
            print_table(title, results[title])
    if args.json:
        print(json.dumps(results, indent=2))


if __name__ == "__main__":
    main()
