"""The bench of `gprodom commission`."""

from __future__ import annotations

from job import Bench, Job
from readers import commission


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


def _jobs() -> tuple[Job, ...]:
    """Fifty robots, ten in a job, and the recordings of real ones."""
    robots = (
        Job(
            f"robots {first}",
            ("--no-radar", "--robots=10", f"--first={first}"),
            (),
            first == 0 and ("--no-radar", "--robots=2"),
            f"robots {first}",
        )
        for first in range(0, 50, 10)
    )
    folder = "{data}/robots"
    return *robots, Job("recordings", ("--recordings", folder), (folder,), prefix="recordings")
