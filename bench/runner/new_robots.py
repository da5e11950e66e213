"""The benches of robots that nobody has measured, and of carts whose wheel triggers the radar."""

from __future__ import annotations

from pathlib import Path

from job import Bench, Job
from jobs import RECORDINGS, drives, recordings
from readers import ERROR_M, commission

from figures import RATIO, SECONDS, Unit, by_row, rows


def commissioning() -> Bench:
    """Of simulated robots, and of recordings of real ones."""
    return Bench(
        "commission",
        "What `gprodom commission` finds of 50 robots, and of recordings of real ones",
        "commission.py",
        commission,
        _jobs(),
        settable=False,
    )


def mountings(data: Path) -> Bench:
    """An IMU that is mounted in any way, of the gentle drives and of recordings with points."""
    of_robots = recordings(("-j1",), ("f1tenth3",))
    return Bench(
        "mounting",
        "Mountings of the IMU at random, found while driving",
        "mounting_found.py",
        by_row(
            lambda row: row["recording"],
            {"over": RATIO, "right_m": ERROR_M, "auto_m": ERROR_M, "known_s": SECONDS},
        ),
        (
            *drives(data, "cmu_like", (9,)),
            *(job for job in of_robots if RECORDINGS[job.name].points),
        ),
    )


def triggering() -> Bench:
    """Traces by the wheel against traces by a clock, a job for each ground."""
    grounds = ("rays", "garage", "basement", "floor")
    jobs = (
        Job(
            ground,
            (f"--ground={ground}",),
            (),
            ground == "rays" and ("--ground=rays", "--seeds=1", "--spacing=0.02"),
        )
        for ground in grounds
    )
    values = {"error_m": ERROR_M, "without_m": Unit("m", ""), "revisits": Unit("", "")}
    return Bench(
        "triggers",
        "Traces that the wheel triggers, against those of a clock",
        "triggers.py",
        rows(("ground", "slip", "trigger"), values),
        tuple(jobs),
        settable=False,
    )


def _jobs() -> tuple[Job, ...]:
    """Fifty robots, ten in a job, and the recordings of real ones."""
    robots = (
        Job(
            f"robots {first}",
            ("--no-radar", "--robots=10", f"--first={first}"),
            (),
            first == 0 and ("--no-radar", "--robots=1"),
            f"robots {first}",
        )
        for first in range(0, 50, 10)
    )
    folder = "{data}/robots"
    return *robots, Job("recordings", ("--recordings", folder), (folder,), prefix="recordings")
