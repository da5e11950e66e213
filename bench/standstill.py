#!/usr/bin/env python3
"""What the radar alone sees of standstills, against the truth beside each sequence.

Standing: a true speed below 5 mm/s for a second or more, 0.2 s at its edges left out. Recall: the
share of that time that a claim of the stationarity front end covers, once over all traces and once
over those with a radar signal (a dead antenna is never claimed to stand). False: claimed time at
5 mm/s or more, over all such time. Unseen: the farthest that the antenna moved within a claim.

    bench/standstill.py ../shared/data/cmu_like/*.zip
"""

from __future__ import annotations

import argparse
import json
import sys
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from gprodom import gpr
from gprodom.arrays import Bools, Floats, Ints
from gprodom.console import add_json_flag, format_table, print_json
from gprodom.convert.cmu import SAMPLE_INTERVAL, read_recording

STANDING = 0.005  # m/s
SHORTEST = 1.0  # s
EDGE = 0.2  # s


@dataclass(frozen=True)
class Outcome:
    """Figures of one sequence."""

    sequence: str
    recall: float
    recall_alive: float
    false: float
    unseen_mm: float


def runs(mask: Bools) -> Ints:
    """(n, 2): first and past-the-last index of each run of True."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], mask.astype(int), [0]])))
    return edges.reshape(-1, 2)


def covered(t: Floats, spans: Floats) -> Bools:
    """Which of `t` lie in one of the spans (n, 2)."""
    result = np.zeros(len(t), bool)
    for start, end in spans:
        result[np.searchsorted(t, start) : np.searchsorted(t, end, "right")] = True
    return result


def judge(name: str, spans: Floats, alive: Bools, t: Floats, s: Floats, speed: Floats) -> Outcome:
    """Scores claims (n, 2), s, on the truth's times `t` (s), track `s` (m) and speed (m/s)."""
    standing = speed < STANDING
    inner = np.zeros(len(t), bool)
    for first, end in runs(standing):
        if t[end - 1] - t[first] >= SHORTEST:
            inner |= (t >= t[first] + EDGE) & (t <= t[end - 1] - EDGE)
    claimed = covered(t, spans)
    unseen = [abs(np.interp(b, t, s) - np.interp(a, t, s)) for a, b in spans]
    return Outcome(
        name,
        float(claimed[inner].mean()),
        float(claimed[inner & alive].mean()),
        float(claimed[~standing].mean()),
        1e3 * max(unseen, default=0.0),
    )


def measure(sequence: Path, window: float) -> Outcome:
    """Runs the front end over a sequence with `.truth.npz` and `.json` beside it."""
    facts = json.loads(sequence.with_suffix(".json").read_text())
    truth = np.load(sequence.with_suffix(".truth.npz"))
    recording = read_recording(sequence)
    times = recording.gpr_utime * 1000
    interval = facts.get("gpr_sample_interval", SAMPLE_INTERVAL)
    spans = gpr.standstills(times, recording.traces, interval, window=window) * 1e-9
    dead = gpr.check_traces(recording.traces) == 1
    nearest = np.clip(np.searchsorted(times * 1e-9, truth["t"]), 0, len(times) - 1)
    return judge(sequence.stem, spans, ~dead[nearest], truth["t"], truth["s"], np.abs(truth["v"]))


def main() -> int:
    """Command line."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("sequences", nargs="+", type=Path, metavar="SEQUENCE.zip")
    parser.add_argument("--window", type=float, default=0.6, help="gpr.stationary_window (s)")
    add_json_flag(parser)
    arguments = parser.parse_args()
    outcomes = [measure(sequence, arguments.window) for sequence in arguments.sequences]
    if arguments.json:
        print_json([asdict(outcome) for outcome in outcomes])
        return 0
    rows = [
        [
            outcome.sequence,
            f"{100 * outcome.recall:.1f} %",
            f"{100 * outcome.recall_alive:.1f} %",
            f"{100 * outcome.false:.2f} %",
            f"{outcome.unseen_mm:.1f}",
        ]
        for outcome in outcomes
    ]
    print(format_table(["sequence", "recall", "recall alive", "false", "unseen, mm"], rows))
    return 0


if __name__ == "__main__":
    sys.exit(main())
