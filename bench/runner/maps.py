"""The benches of ground seen before."""

from __future__ import annotations

from pathlib import Path

from job import Bench, Job
from jobs import drives, simulated, with_sequences
from readers import (
    FOUND,
    MAP,
    REVISIT,
    VISIT,
    changed_ground,
    consistency,
    days,
    merge,
    short_name,
    yard,
)

from figures import by_row, one_row, rows


def of_maps(data: Path) -> tuple[Bench, ...]:
    """Ground seen before."""
    twelve = drives(data, "cmu_like", ())
    return (
        Bench(
            "revisits",
            "Revisits of the gentle drives, with unknown and true scale",
            "revisits.py",
            by_row(
                lambda row: f"{short_name(row['sequence'])}/{row['scale']}/{row['method']}", FOUND
            ),
            tuple(with_sequences(twelve, "-j1")),
        ),
        Bench(
            "coverage",
            "The pose in map: coverage, and wrong revisits",
            "map_coverage.py",
            one_row(MAP),
            simulated("--runs=20", "--wrong", "--jobs=1", short=("--runs=2", "--jobs=1")),
        ),
        Bench(
            "yard",
            "The same 400 m again and again",
            "yard.py",
            yard,
            (
                Job("days", ("48",), short=("0.1", "--rest=5"), prefix="one"),
                Job("pieces", ("14", "--rest=60", "--pieces=7"), prefix="pieces"),
            ),
            compiled=True,
        ),
        Bench(
            "consistency",
            "Consistency over simulated robots",
            "consistency.py",
            consistency,
            simulated("--runs=12", "--robot=all", "--jobs=1"),
        ),
        Bench(
            "relocation",
            "Located after a reset",
            "relocation.py",
            one_row(VISIT),
            simulated("--runs=20", "--jobs=1"),
        ),
        Bench(
            "changed_ground",
            "Located on ground that has changed",
            "changed_ground.py",
            changed_ground,
            simulated("--runs=6", "--no-beside", "--change", "0", "10", "-20", "--jobs=1"),
        ),
        Bench(
            "another_day",
            "Located on real ground of another line or day",
            "real_another_day.py",
            by_row(lambda row: str(row["drives"]), VISIT),
            (
                Job(
                    "all",
                    ("{data}", "--lines=8", "--strangers=8", "--change", "0"),
                    ("{data}/real_ground",),
                ),
            ),
        ),
        Bench(
            "days",
            "Drives that begin with the map of another",
            "days.py",
            days,
            (
                Job("same ground", ("{data}/cmu_like", "-j1"), ("{data}/cmu_like",), prefix="same"),
                Job(
                    "strangers",
                    ("{data}/cmu_like", "--strangers", "-j1"),
                    ("{data}/cmu_like",),
                    prefix="strangers",
                ),
            ),
        ),
        Bench(
            "merge",
            "Maps of two days become one",
            "merge.py",
            merge,
            simulated("--runs=4", "--jobs=1"),
        ),
        Bench(
            "revisit_along",
            "Revisits along real lines",
            "revisit_along.py",
            rows(("variant",), REVISIT),
            (Job("all", ("{data}",), ("{data}/real_ground", "{data}/revisit_eval.py")),),
            settable=False,
        ),
    )
