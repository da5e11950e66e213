"""results.csv, results.json and the table of a benchmark."""

import csv
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from statistics import fmean
from typing import Any

from gprodom.benchmark.jobs import Outcome, Settings
from gprodom.benchmark.pairs import compare_methods, pair_cells
from gprodom.console import format_table
from gprodom.files import replacing
from gprodom.score.record import COLUMNS, Record

AVERAGED = ("ate_rmse_m", "rpe_1m_m", "end_m", "distance_pct", "nees_xy", "nees_yaw", "answered")


def write_csv(path: Path, records: Sequence[Record]) -> None:
    """One row a record; an empty cell where a figure is null."""
    with replacing(path) as part, part.open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
        writer.writeheader()
        for record in records:
            writer.writerow(record.as_dict())


def mean_of(records: Sequence[Record], figure: str) -> float | None:
    """Mean over the records that have the figure; None if none has."""
    values = [getattr(record, figure) for record in records]
    known = [value for value in values if value is not None]
    return fmean(known) if known else None


def weighted_mean(records: Sequence[Record]) -> float | None:
    """Mean ate_rmse_m, each sequence weighing as the distance it travels."""
    length = sum(record.distance_m for record in records)
    if not length:
        return None
    return sum(record.ate_rmse_m * record.distance_m for record in records) / length


def summarise(records: Sequence[Record]) -> list[dict[str, Any]]:
    """Means by method and mode: of every figure, and of ate_rmse_m by scene. Every sequence has the
    same weight, whatever its length. `sequences` is their number."""
    groups: dict[tuple[str, str], list[Record]] = {}
    for record in records:
        groups.setdefault((record.method, record.mode), []).append(record)
    scenes = list(dict.fromkeys(record.scene for record in records))
    return [
        {
            "method": method,
            "mode": mode,
            "sequences": len(group),
            "scenes": {
                scene: mean_of([r for r in group if r.scene == scene], "ate_rmse_m")
                for scene in scenes
            },
            "weighted_m": weighted_mean(group),
            **{figure: mean_of(group, figure) for figure in AVERAGED},
        }
        for (method, mode), group in groups.items()
    ]


def table_cells(summary: Sequence[dict[str, Any]]) -> tuple[list[str], list[list[object]]]:
    """Header and rows of the one table: mean ATE by scene and over all, then the other figures."""
    scenes = list(summary[0]["scenes"]) if summary else []
    header = ["method", "mode", "mean ATE (m)", "by length", *(scene or "ATE" for scene in scenes)]
    header += [
        "RPE 1 m (m)",
        "end (m)",
        "% of dist.",
        "NEES xy",
        "NEES yaw",
        "answered",
        "sequences",
    ]
    rows: list[list[object]] = [
        [line["method"], line["mode"], line["ate_rmse_m"], line["weighted_m"]]
        + [*line["scenes"].values(), *(line[figure] for figure in AVERAGED[1:])]
        + [line["sequences"]]
        for line in summary
    ]
    return header, rows


def as_json(
    outcomes: Sequence[Outcome], records: Sequence[Record], settings: Settings
) -> dict[str, Any]:
    """Everything: settings, records, means, the K of each job and what failed."""
    return {
        "align": settings.align,
        "first_m": settings.first_m,
        "configs": [str(path) for path in settings.configs],
        "set": list(settings.overrides),
        "records": [record.as_dict() for record in records],
        "means": summarise(records),
        "pairs": [{**asdict(pair), "verdict": pair.verdict} for pair in compare_methods(records)],
        "k": [
            {"sequence": o.sequence, "method": o.method, **asdict(o.k), "fitted_on": o.fitted_on}
            for o in outcomes
            if o.k
        ],
        "failures": [
            {"sequence": o.sequence, "method": o.method, "reason": o.failure}
            for o in outcomes
            if o.failure
        ],
    }


def describe(records: Sequence[Record], align: str) -> str:
    """The table as text, and the comparison of methods if there are enough sequences."""
    header, rows = table_cells(summarise(records))
    note = (
        f"ATE and end after alignment {align}; means over sequences (by length: weighted by the "
        "distance travelled); scenes: mean ATE (m)"
    )
    text = format_table(header, rows) + "\n" + note
    pairs = compare_methods(records)
    if pairs:
        text += "\n\n" + format_table(*pair_cells(pairs))
        text += "\nmean paired differences of ATE, intervals by bootstrap over sequences"
    return text
