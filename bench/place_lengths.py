#!/usr/bin/env python3
"""Is the decorrelation length of a place the same on a later pass?

A distance by coherence has an error that belongs to the ground: the decorrelation length changes
from place to place. This bench tells what a perfect memory of it would bring. For each span of the
coherence whose place was passed before (within 0.35 m, by the truth), ln(true metres / lengths) is
predicted in two ways: from the spans of the last 5 m, as the estimator does, and from those of the
earlier passes at this place. Positions and distances are the truth's, so nothing is lost to
localisation.

A row a SEQUENCE (with `.truth.npz` beside it): number of spans with an earlier pass, and the
standard deviation (by the median, robust) of ln(true / predicted metres) of each prediction.

    bench/place_lengths.py ../shared/data/rough/*.zip [--json]
"""

from __future__ import annotations

import argparse
import sys
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from gprodom import gpr
from gprodom.arrays import Floats
from gprodom.console import Progress, add_json_flag, format_table, print_json
from gprodom.convert.cmu import read_recording
from gprodom.errors import Error
from rough import sample_interval, sequences_of

NEAR_M = 0.35  # from an earlier pass
RECENT_M = 5.0  # of the path
PASSED_M = 8.0  # of the path, after which a pass is an earlier one
LEAST_M = 0.1  # of a span
FEWEST = 3  # spans to predict from


@dataclass(frozen=True)
class Row:
    """Standard deviations of ln(true / predicted metres)."""

    sequence: str
    spans: int
    recent: float | None
    earlier_pass: float | None


def spread(errors: list[float]) -> float | None:
    """Standard deviation by the median of the absolute errors; None of fewer than ten."""
    return 1.4826 * float(np.median(np.abs(errors))) if len(errors) >= 10 else None


def spans_of(sequence: Path) -> tuple[Floats, Floats, Floats]:
    """ln(true metres / lengths) (n,), place (n, 2) and way (n,), m, of each span's middle."""
    recording = read_recording(sequence)
    times = recording.gpr_utime * 1000
    paths = gpr.coherence(times, recording.traces, sample_interval(sequence))
    told = np.array([path[:3] for path in paths if path[3]])
    start, end, lengths = told[:, 0] * 1e-9, told[:, 1] * 1e-9, told[:, 2]
    truth = np.load(sequence.with_suffix(".truth.npz"))
    travelled = np.cumsum(np.abs(np.diff(truth["s"], prepend=truth["s"][0])))
    moved = np.interp(end, truth["t"], travelled) - np.interp(start, truth["t"], travelled)
    kept = moved > LEAST_M
    middle = 0.5 * (start + end)[kept]
    place = np.stack([np.interp(middle, truth["t"], truth[axis]) for axis in "xy"], axis=1)
    logs_of = np.log(moved[kept] / lengths[kept])
    return logs_of, place, np.asarray(np.interp(middle, truth["t"], travelled))


def measure(sequence: Path) -> Row:
    """The row of one sequence."""
    x, place, at_m = spans_of(sequence)
    recent, earlier = [], []
    for i, value in enumerate(x):
        before = at_m[i] - at_m
        of_late = (before > 0) & (before < RECENT_M)
        apart = np.linalg.norm(place - place[i], axis=1)
        passed = (before > PASSED_M) & (apart < NEAR_M)
        if of_late.sum() < FEWEST or not passed.any():
            continue
        weights = np.exp(-0.5 * (apart[passed] / (0.5 * NEAR_M)) ** 2)
        recent.append(float(value - x[of_late].mean()))
        earlier.append(float(value - np.average(x[passed], weights=weights)))
    return Row(sequence.stem, len(recent), spread(recent), spread(earlier))


def main() -> int:
    """Runs the command line."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("sequences", metavar="SEQUENCE", type=Path, nargs="+")
    add_json_flag(parser)
    args = parser.parse_args()
    rows = []
    sequences = sequences_of(args.sequences)
    try:
        with Progress("drives", len(sequences)) as bar:
            for sequence in sequences:
                rows.append(measure(sequence))
                bar.advance()
    except Error as error:
        print(f"place_lengths: error: {error}", file=sys.stderr)
        return 1
    if args.json:
        print_json([asdict(row) for row in rows])
    else:
        cells = [
            [row.sequence, str(row.spans)]
            + [f"{v:.3f}" if v is not None else "" for v in (row.recent, row.earlier_pass)]
            for row in rows
        ]
        print(format_table(["drive", "spans", "last 5 m", "earlier pass"], cells))
    return 0


if __name__ == "__main__":
    sys.exit(main())
