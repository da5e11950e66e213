#!/usr/bin/env python3
"""Errors on drives, with and without IMU, coherence and revisits as witnesses.

Each SEQUENCE (a zip or folder; a folder with zips stands for them) has truth, and may have `.json`
(gpr_sample_interval) beside it; nothing else of it is read. So a folder of drives that nobody has
seen is enough. A row a drive and method: position RMSE aligned in the plane, m, of dead reckoning
and of the method, causal and smoothed, and NEES of x, y in odom and in map. Below, of each method,
the mean error over the mean of dead reckoning, and in brackets the mean of the drives' ratios; and
NEES, mean and largest.

    bench/rough.py ../shared/data/rough [-j 2] [--json]
    bench/rough.py ../shared/data/cmu_like ../shared/data/pairs
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterable, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from statistics import fmean

from estimates import planar_figures, run_method
from gprodom.errors import Error
from gprodom.files import temporary_folder
from gprodom.odometry.estimate import as_log
from gprodom.score.sources import read_estimate, read_truth
from program import complain, exit_with, in_processes, parser_of, print_figures, table_of
from zips import sample_interval, sequences_of

ALL = "gprodom_full"
METHODS = ("imu_wheel", "gprodom", ALL)
FRAMES = ("odom", "map")


@dataclass(frozen=True)
class Row:
    """One method on one drive. ratios: over dead reckoning."""

    sequence: str
    method: str
    dead_m: float
    causal_m: float
    smoothed_m: float
    nees_odom: float | None
    nees_map: float | None


Cases = Sequence[tuple[str, str, tuple[str, ...]]]  # name of the row, method, settings


def as_it_is(log: Path) -> None:
    """Changes nothing."""


def run(sequence: Path, methods: Cases, change: Callable[[Path], None] = as_it_is) -> list[Row]:
    """The rows of one drive, whose log `change` has changed."""
    truth = read_truth(sequence).trajectory
    rows = []
    with temporary_folder() as folder:
        log = as_log(sequence, folder, sample_interval(sequence))
        change(log)
        output = folder / "output.lcmlog"
        dead = planar_figures(run_method(log, "wheel", output).trajectory, truth)
        for name, method, settings in methods:
            made = run_method(log, method, output, settings, smooth=True)
            assert made.smoothed is not None
            paths = (made.trajectory, made.smoothed, read_estimate(output, "odom").trajectory)
            causal, smoothed, odom = (planar_figures(path, truth) for path in paths)
            errors = (each.ate_rmse_m for each in (dead, causal, smoothed))
            rows.append(Row(sequence.stem, name, *errors, odom.nees_xy, causal.nees_xy))
    return rows


def attempt(
    sequence: Path, methods: Cases, change: Callable[[Path], None] = as_it_is
) -> list[Row] | str:
    """The rows, or why there are none: one sequence that fails leaves the others going."""
    try:
        return run(sequence, methods, change)
    except Error as error:
        return f"{sequence.name}: {error}"


def ratio(rows: Sequence[Row], figure: str) -> str:
    """Mean over mean of dead reckoning, and the mean of the ratios."""
    values = [getattr(row, figure) for row in rows]
    of_means = fmean(values) / fmean(row.dead_m for row in rows)
    of_each = fmean(value / row.dead_m for value, row in zip(values, rows, strict=True))
    return f"{of_means:.2f} ({of_each:.2f})"


def nees(values: Iterable[float | None]) -> str:
    """Mean, and the largest."""
    known = [value for value in values if value is not None]
    return f"{fmean(known):.1f} ({max(known):.1f})" if known else ""


def table(rows: Sequence[Row], names: Sequence[str]) -> str:
    """All rows, and the ratios of each method."""
    of = {name: [row for row in rows if row.method == name] for name in names}
    ratios = [
        {
            "over dead": name,
            "causal": ratio(some, "causal_m"),
            "smoothed": ratio(some, "smoothed_m"),
        }
        | {f"NEES {frame}": nees(getattr(r, f"nees_{frame}") for r in some) for frame in FRAMES}
        for name, some in of.items()
    ]
    return f"{table_of([asdict(row) for row in rows])}\n\n{table_of(ratios)}"


def measured(
    args: argparse.Namespace, work: Callable[[Path], list[Row] | str], names: Sequence[str]
) -> int:
    """Runs the drives of the command line and prints their rows; the exit code."""
    rows, failed = [], False
    for found in in_processes(args.jobs, "drives", work, sequences_of(args.sequences)):
        if isinstance(found, str):
            complain(found)
            failed = True
        else:
            rows += found
    if rows:
        print_figures(args, [asdict(row) for row in rows], table(rows, names))
    return 1 if failed or not rows else 0


def main() -> int:
    """Runs the command line."""
    parser = parser_of(__doc__, jobs=2, overrides=True)
    parser.add_argument("sequences", metavar="SEQUENCE", type=Path, nargs="+")
    parser.add_argument("--only", metavar="METHOD", choices=METHODS, help="this method alone")
    args = parser.parse_args()
    names = [name for name in METHODS if args.only in (None, name)]
    cases = [(name, name, tuple(args.overrides)) for name in names]
    return measured(args, partial(attempt, methods=cases), names)


if __name__ == "__main__":
    exit_with(main)
