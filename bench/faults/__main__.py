"""The fault bench: replays sequences with one fault at a time and measures the effect.

Each LOG (a converted sequence) is replayed as it is and with every fault of kinds.py that --only
names (default: all), and in seeded combinations of three (--combinations).

Printed are for every fault the error over that of the clean run (mean over the sequences, and the
worst of them), the longest silence, the time after the fault until STATUS was well again, and what
STATUS said. Exit code 1 where a fault ended the program, made a number that is not finite or a pose
that is earlier than the one before, or was not told of in STATUS though it could be.

    python bench/faults LOG.lcmlog... [-j 2]
"""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from statistics import fmean
from typing import Any

sys.path.append(str(Path(__file__).resolve().parents[1]))

import kinds
from outcome import replayed

from gprodom.files import temporary_folder
from gprodom.options import add_config_option
from program import exit_with, in_processes, parser_of, print_figures, table_of, told_wrong
from zips import log_of

Outcome = dict[str, Any]


def row_of(
    fault: kinds.Fault, found: Sequence[tuple[str, Outcome, Outcome]]
) -> tuple[dict[str, Any], list[str]]:
    """The figures of a fault, and a line for each thing that is wrong. found: of each log its name,
    the outcome with the fault, and without."""
    wrong: list[str] = []
    said: dict[str, None] = {}
    held = []
    for log, result, clean in found:
        if "ended" in result:
            wrong.append(f"{log}: {fault.name}: {result['ended']}")
            continue
        held.append((result, clean["error_m"]))
        # What STATUS does not say, or not as often, without the fault.
        before = clean["said"]
        news = [name for name, count in result["said"].items() if count > before.get(name, 0.0)]
        said.update(dict.fromkeys(news))
        faults = [f"not {trait}" for trait in ("finite", "monotone") if not result[trait]]
        faults += ["STATUS is silent"] * (fault.told and not news)
        wrong += [f"{log}: {fault.name}: {what}" for what in faults]
    ratios = [result["error_m"] / clean for result, clean in held]
    known = [ratio for ratio in ratios if math.isfinite(ratio)]
    row: dict[str, Any] = {"fault": fault.name, "wrong": len(wrong)}
    if known:
        row |= {"error_ratio": fmean(known), "worst_ratio": max(known)}
    for key in ("silent_s", "recovered_s"):
        row[key] = max((result[key] for result, _ in held), default=0.0)
    return row | {"said": "; ".join([*said][:3])}, wrong


def parse() -> argparse.Namespace:
    """The command line."""
    parser = parser_of(__doc__, jobs=1)
    parser.add_argument("logs", nargs="+", type=Path, metavar="SEQ", help="log or zip")
    add_config_option(parser)
    parser.add_argument(
        "--only", action="append", metavar="TEXT", help="faults whose name holds it; repeatable"
    )
    parser.add_argument("--combinations", type=int, default=10, help="default: 10")
    return parser.parse_args()


def main() -> int:
    """Runs the command line."""
    args = parse()
    faults = kinds.faults_of(args.combinations)
    names = ["", *(name for name in faults if is_wanted(name, args.only))]
    with temporary_folder() as folder:
        logs = [log_of(source, folder) for source in args.logs]
        cases = [(log, name) for log in logs for name in names]
        work = partial(replayed, combinations=args.combinations, configs=args.configs)
        outcomes = in_processes(args.jobs, "replays", work, *zip(*cases, strict=True))
    of = {(log.stem, name): each for (log, name), each in zip(cases, outcomes, strict=True)}
    rows, wrong = [], []
    for name in names[1:]:
        found = [(log.stem, of[log.stem, name], of[log.stem, ""]) for log in logs]
        row, faulty = row_of(faults[name], found)
        rows.append(row)
        wrong += faulty
    print_figures(args, rows, table_of(rows))
    return told_wrong(wrong)


def is_wanted(name: str, only: Sequence[str] | None) -> bool:
    """One that --only names, or a combination."""
    return not only or " + " in name or any(text in name for text in only)


if __name__ == "__main__":
    exit_with(main)
