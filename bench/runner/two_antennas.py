"""The benches of two antennas in a row."""

from __future__ import annotations

from pathlib import Path

from job import Bench, Job
from jobs import drives, of_grounds
from readers import DRIVE, PAIR, PAIR_FAULT, lateral

from figures import by_row


def of_pairs(data: Path) -> tuple[Bench, ...]:
    """Drives, distance by the pair alone, faults, and the ground that differs beside a track."""
    return (
        Bench("pairs", "Drives with two antennas", "pairs.py", DRIVE, drives(data, "pairs", ())),
        Bench(
            "pair_distance",
            "Distance by two antennas alone, over 50 m, beside its limit",
            "pair_distance.py",
            by_row(lambda row: f"{row['ground']}/{row['case']}", PAIR),
            of_grounds(),
            settable=False,
        ),
        Bench(
            "pair_faults",
            "Two antennas over rebar, swapped, silent, and drifting apart",
            "pair_faults.py",
            by_row(lambda row: f"{row['ground']}/{row['fault']}/{row['method']}", PAIR_FAULT),
            tuple(
                Job(
                    name,
                    ("{data}/real_ground", *words),
                    ("{data}/real_ground",),
                    short and ("{data}/real_ground", *short),
                )
                for name, words, short in (
                    ("rebar", ("--minutes=0",), False),
                    ("others", ("--km=0",), ("--km=0", "--minutes=0.5", "--ground=fdtd")),
                )
            ),
            settable=False,
        ),
        Bench(
            "lateral",
            "Correlation of real ground beside a track",
            "lateral.py",
            lateral,
            (Job("all", ("{data}/real_ground",), ("{data}/real_ground",), True),),
            settable=False,
        ),
    )
