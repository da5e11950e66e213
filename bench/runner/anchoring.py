"""Figures of the bench of positions from outside."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from figures import COUNT, ERROR_M, FEWER, METRES, SECONDS, Figure, Unit, by_row, each


def by_mode(**values: Unit) -> dict[str, Unit]:
    """Of the solution over all data, and as published."""
    return {f"{mode}_{key}": values[key] for mode in ("smoothed", "causal") for key in values}


BETWEEN = by_mode(
    **each(METRES, "without_m", "placed_m"),
    **each(ERROR_M, "m", "site_m"),
    **each(FEWER, "ratio", "site_ratio"),
) | {"smoothed_body_m": ERROR_M}
FAULT = by_mode(m=ERROR_M, over=FEWER)
SCALE = {
    **each(COUNT, "sigma", "limit"),
    "sigma_over_limit": FEWER,
    **each(COUNT, "nees", "sigma_without"),
}
# By a key that tells of which part a row is.
PARTS = {
    "smoothed_site_m": by_row(lambda row: f"{row['recording']}/{row.get('noise', 'own')}", BETWEEN),
    "fault": by_row(lambda row: f"{row['recording']}/{row['fault']}", FAULT | {"after_s": SECONDS}),
    "sigma_over_limit": by_row(lambda row: f"scale/{row['seed']}", SCALE),
    "joined": by_row(lambda row: f"days/{row['seed']}", {"joined": COUNT, "error_m": ERROR_M}),
}


def anchors(content: Any) -> Iterator[Figure]:
    """bench/anchors, any of its parts; of the wheel's scale the means alone."""
    for key, read in PARTS.items():
        found = [row for row in content if key in row]
        if key == "sigma_over_limit":
            found = [row for row in found if str(row["seed"]).startswith("mean")]
        yield from read(found)
    named = [row for row in content if row.get("fault") not in (None, "healthy")]
    if named:
        count = sum(bool(row["named"]) for row in named)
        yield Figure(f"{named[0]['recording']}/named", count / len(named), "", "higher")
