"""The table of benches: what `bench/run` measures, in the order in which it does.

A new bench is an entry here. Its program prints JSON with --json; `read` says which values of that
are figures (figures.py), with unit and direction. Figures are named JOB'S ROW/KEY. A job is what is
run, kept and run again at once: some minutes at most, on one core, with arguments that tell it so
(-j 1). What decides most comes first.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

from figures import COUNT, ERROR_M, NEES, RATIO, SECONDS, Unit, by_row, rows
from job import BENCH, CHECKOUT, Bench, Job

sys.path.append(str(BENCH))

from recordings import RECORDINGS

DRIVE = by_row(
    lambda row: f"{row['sequence'].split('-')[0]}/{row['method']}",
    {
        "dead_m": ERROR_M,
        "causal_m": ERROR_M,
        "smoothed_m": ERROR_M,
        "nees_odom": NEES,
        "nees_map": NEES,
    },
)
ROBOT = {
    "wheel_m": ERROR_M,
    "causal_m": ERROR_M,
    "smoothed_m": ERROR_M,
    "ratio": RATIO,
    "over": RATIO,
    "smoothed_over": RATIO,
    "nees_xy": NEES,
    "start_s": SECONDS,
    "jump_m": ERROR_M,
    "distance_m": Unit("m", ""),
    "wheel_distance_m": Unit("m", ""),
    "causal_distance_m": Unit("m", ""),
    "failed": COUNT,
}


def drives(data: Path, folder: str, short: Sequence[int]) -> tuple[Job, ...]:
    """A job for each zip of a folder; those of --short by their number."""
    names = [path.name for path in sorted((data / folder).glob("*.zip"))]
    return tuple(
        Job(
            "-".join(name.split("-")[0:3:2]),
            (f"{{data}}/{folder}/{name}", "-j1"),
            (f"{{data}}/{folder}/{name}",),
            i in short,
        )
        for i, name in enumerate(names)
    )


def sample() -> tuple[Job, ...]:
    """The drive that lies in every checkout."""
    (path,) = (CHECKOUT / "sample").glob("*-cmu-gpr.zip")
    name = f"{{checkout}}/sample/{path.name}"
    return (Job("sample", (name, "-j1"), (name,), True),)


def recordings(more: tuple[str, ...], short: Sequence[str]) -> tuple[Job, ...]:
    """A job for each recording of a real robot."""
    return tuple(
        Job(
            name,
            ("{data}/robots", "--only", name, *more),
            tuple(f"{{data}}/robots/{file}" for file in recording.files),
            name in short,
        )
        for name, recording in RECORDINGS.items()
    )


def benches(data: Path) -> tuple[Bench, ...]:
    """All of them. data: the folder of recorded data."""
    return (
        Bench("twelve", "Gentle drives", "rough.py", DRIVE, drives(data, "cmu_like", (1, 9))),
        Bench("rough", "Rough drives", "rough.py", DRIVE, drives(data, "rough", (0, 7))),
        Bench(
            "robots",
            "Recordings of real robots",
            "robots.py",
            rows((), ROBOT),
            recordings((), ("phil1", "phil8", "f1tenth1", "warthog_a", "wid09")),
        ),
        Bench(
            "variations",
            "Variations of these recordings",
            "robot_variations.py",
            by_row(lambda row: f"{row['recording']}/{row['variation']}", ROBOT),
            recordings(("-j1",), ()),
        ),
        Bench("sample", "The sample drive", "rough.py", DRIVE, sample()),
        Bench("pairs", "Drives with two antennas", "rough.py", DRIVE, drives(data, "pairs", (1,))),
    )
