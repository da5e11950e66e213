"""The bench of positions from outside."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from job import Bench, Job
from jobs import RECORDINGS

from figures import COUNT, ERROR_M, RATIO, SECONDS, Figure, Unit, by_row

MODES = ("smoothed", "causal")
BETWEEN = {
    f"{mode}_{key}": unit
    for mode in MODES
    for key, unit in (
        ("without_m", Unit("m", "")),
        ("placed_m", Unit("m", "")),
        ("m", ERROR_M),
        ("site_m", ERROR_M),
        ("ratio", RATIO),
        ("site_ratio", RATIO),
    )
}
FAULT = {f"{mode}_{key}": unit for mode in MODES for key, unit in (("m", ERROR_M), ("over", RATIO))}
_READ = {
    "between": by_row(lambda row: f"{row['recording']}/{row.get('noise', 'own')}", BETWEEN),
    "fault": by_row(lambda row: f"{row['recording']}/{row['fault']}", FAULT | {"after_s": SECONDS}),
    "scale": by_row(
        lambda row: f"scale/{row['seed']}",
        {
            "sigma": Unit("", ""),
            "limit": Unit("", ""),
            "sigma_over_limit": RATIO,
            "nees": Unit("", ""),
            "sigma_without": Unit("", ""),
        },
    ),
    "days": by_row(lambda row: f"days/{row['seed']}", {"joined": COUNT, "error_m": ERROR_M}),
}


def anchors(content: Any) -> Iterator[Figure]:
    """bench/anchors, any of its parts: which one the rows are of is told by what they have."""
    for kind, key in (
        ("between", "smoothed_site_m"),
        ("fault", "fault"),
        ("scale", "sigma_over_limit"),
        ("days", "joined"),
    ):
        found = [row for row in content if key in row]
        if kind == "scale":
            found = [row for row in found if str(row["seed"]).startswith("mean")]
        yield from _READ[kind](found)
    named = [row for row in content if row.get("fault") not in (None, "healthy")]
    if named:
        count = sum(bool(row["named"]) for row in named)
        yield Figure(f"{named[0]['recording']}/named", count / len(named), "", "higher")


def of_anchors() -> tuple[Bench, ...]:
    """A job for each recording, and those of simulated drives."""

    def of_recordings(part: str, *names: str) -> tuple[Job, ...]:
        return tuple(
            Job(
                f"{part} {name}",
                (part, "{data}/robots", *(("--only", name) if part != "withheld" else ())),
                tuple(f"{{data}}/robots/{file}" for file in RECORDINGS[name].files),
            )
            for name in names
        )

    return (
        Bench(
            "anchors",
            "Positions from outside: what they give, and faults of their receivers",
            "anchors",
            anchors,
            (
                Job("scale", ("scale", "--seeds=20"), (), ("scale", "--seeds=1")),
                *of_recordings("ends", "wid02", "wid09", "f1tenth3"),
                *of_recordings("withheld", "husky"),
                *of_recordings("faults", "wid02", "f1tenth3"),
                Job("days", ("days", "--seeds=2")),
            ),
        ),
    )
