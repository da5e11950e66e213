#!/usr/bin/env python3
"""Errors on drives with two antennas in a row, with both antennas and with one.

Each SEQUENCE (a zip or folder; a folder with zips stands for them) has truth, the traces of the
second antenna, and a `.json` beside it. Of that, only `antennas` (where they are by tape: front,
rear, [x, y, z] in m) and `gpr_sample_interval` are read, so that a folder of drives that nobody has
seen is enough. Rows and columns as in bench/rough.py; `one antenna` is gprodom_full with the front
antenna alone.

    bench/pairs.py ../shared/data/pairs [-j 2] [--json]
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict
from functools import partial
from pathlib import Path

from program import exit_with, in_processes, parser_of, print_figures, told_apart
from rough import ALL, Row, attempt, sequences_of, table

ONE = "one antenna"
METHODS = ("imu_wheel", "radar_imu", "gprodom", ALL)
NAMES = (ONE, *METHODS)


def antennas_of(sequence: Path) -> str:
    """The setting gpr.antennas."""
    facts = json.loads(sequence.with_suffix(".json").read_text(encoding="utf-8"))
    places = dict(enumerate(facts["antennas"]))
    return "gpr.antennas={" + ", ".join(f"{i}: {list(p)}" for i, p in places.items()) + "}"


def run(sequence: Path, more: tuple[str, ...], names: Sequence[str]) -> list[Row] | str:
    """The rows of one drive, or why there are none."""
    try:
        both = antennas_of(sequence)
    except (OSError, ValueError, KeyError, TypeError) as error:
        return f"{sequence.name}: no antennas in the .json beside it: {error!r}"
    first = both.split("]", maxsplit=1)[0] + "]}"
    cases = [(ONE, ALL, (first, *more)), *((name, name, (both, *more)) for name in METHODS)]
    return attempt(sequence, [case for case in cases if case[0] in names])


def main() -> int:
    """Runs the command line."""
    parser = parser_of(__doc__, jobs=2, overrides=True)
    parser.add_argument("sequences", metavar="SEQUENCE", type=Path, nargs="+")
    parser.add_argument("--only", metavar="ROW", choices=NAMES, help="this row alone")
    args = parser.parse_args()
    names = tuple(name for name in NAMES if args.only in (None, name))
    sequences = sequences_of(args.sequences)
    work = partial(run, more=tuple(args.overrides), names=names)
    rows, failed = told_apart(in_processes(args.jobs, "drives", work, sequences))
    if not rows:
        return 1
    print_figures(args, [asdict(row) for row in rows], table(rows, names))
    return 1 if failed else 0


if __name__ == "__main__":
    exit_with(main)
