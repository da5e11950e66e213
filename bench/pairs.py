#!/usr/bin/env python3
"""Errors on drives with two antennas in a row, with both antennas and with one.

Each SEQUENCE (a zip or folder; a folder with zips stands for them) has truth, the traces of the
second antenna, and a `.json` beside it. Of that, only `antennas` (where they are by tape: front,
rear, [x, y, z] in m) and `gpr_sample_interval` are read, so that a folder of drives that nobody has
seen is enough. Rows and columns as in bench/rough.py; `one antenna` is gprodom_full with the front
antenna alone, `front fails` with both until the front one gives nothing any more, after two fifths
of the drive: then revisits are found by the rear one on what the front one has seen.

    bench/pairs.py ../shared/data/pairs [-j 2] [--json]
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from functools import partial
from pathlib import Path

from gprodom.lcm.messages import message
from log_events import read_events, write_events
from program import exit_with, parser_of
from rough import ALL, Row, attempt, measured

ONE, FAILS = "one antenna", "front fails"
METHODS = ("imu_wheel", "radar_imu", "gprodom", ALL)
NAMES = (ONE, FAILS, *METHODS)
FAILS_AFTER = 0.4  # of the drive


def antennas_of(sequence: Path) -> str:
    """The setting gpr.antennas."""
    facts = json.loads(sequence.with_suffix(".json").read_text(encoding="utf-8"))
    places = dict(enumerate(facts["antennas"]))
    return "gpr.antennas={" + ", ".join(f"{i}: {list(p)}" for i, p in places.items()) + "}"


def front_fails(log: Path) -> None:
    """Takes the front antenna's traces out of the log, from `FAILS_AFTER` on."""
    events = read_events(log)
    begin, end = events[0][0], events[-1][0]

    def is_kept(time: int, channel: str, data: bytes) -> bool:
        late = time >= begin + FAILS_AFTER * (end - begin)
        return not (late and channel == "GPR_TRACE" and antenna_of(data) == 0)

    write_events([event for event in events if is_kept(*event)], log)


def antenna_of(trace: bytes) -> int:
    """The id of an encoded trace's antenna."""
    return int(message("gpr_trace_t").decode(trace).antenna_id)


def run(sequence: Path, more: tuple[str, ...], names: Sequence[str]) -> list[Row] | str:
    """The rows of one drive, or why there are none."""
    try:
        both = antennas_of(sequence)
    except (OSError, ValueError, KeyError, TypeError) as error:
        return f"{sequence.name}: no antennas in the .json beside it: {error!r}"
    first = both.split("]", maxsplit=1)[0] + "]}"
    cases = [(ONE, ALL, (first, *more)), *((name, name, (both, *more)) for name in METHODS)]
    rows = attempt(sequence, [case for case in cases if case[0] in names])
    if FAILS not in names or isinstance(rows, str):
        return rows
    failing = attempt(sequence, [(FAILS, ALL, (both, *more))], front_fails)
    return failing if isinstance(failing, str) else rows + failing


def main() -> int:
    """Runs the command line."""
    parser = parser_of(__doc__, jobs=2, overrides=True)
    parser.add_argument("sequences", metavar="SEQUENCE", type=Path, nargs="+")
    parser.add_argument("--only", metavar="ROW", choices=NAMES, help="this row alone")
    args = parser.parse_args()
    names = tuple(name for name in NAMES if args.only in (None, name))
    return measured(args, partial(run, more=tuple(args.overrides), names=names), names)


if __name__ == "__main__":
    exit_with(main)
