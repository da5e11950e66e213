"""report.html of a benchmark."""

from __future__ import annotations

from collections.abc import Sequence as Items
from pathlib import Path

from gprodom.benchmark.jobs import Outcome, Sequence, Settings, read_sequence_truth
from gprodom.benchmark.results import summarise, table_cells
from gprodom.errors import Error
from gprodom.plot import canvas
from gprodom.score.align import fit
from gprodom.score.associate import associate
from gprodom.score.figures import FIGURE_NAMES
from gprodom.score.page import text
from gprodom.score.pictures import draw_paths
from gprodom.score.record import Record
from gprodom.trajectory import Trajectory, read_tum

SHOWN = ("sequence", "method", "mode", *FIGURE_NAMES, "map_jumps")


def write_report(
    path: Path,
    sequences: Items[Sequence],
    outcomes: Items[Outcome],
    records: Items[Record],
    settings: Settings,
) -> None:
    """Means by method, every score, what failed, and the trajectories of each sequence."""
    header, rows = table_cells(summarise(records))
    best = _best_row(rows, header.index("mean ATE (m)"))
    parts = [
        canvas.paragraph(
            f"Alignment {settings.align}. Causal: as published, never rewritten; "
            "smoothed: from one solution over all data. Means are over "
            "sequences; the columns of scenes hold the mean absolute trajectory error (RMS, m)."
        ),
        canvas.heading("Methods"),
        canvas.table(header, [[text(cell) for cell in row] for row in rows], best),
    ]
    failures = [outcome for outcome in outcomes if outcome.failure]
    if failures:
        cells = [[outcome.sequence, outcome.method, outcome.failure] for outcome in failures]
        parts += [canvas.heading("Failed"), canvas.table(["sequence", "method", "reason"], cells)]
    parts.append(canvas.heading("Trajectories"))
    for sequence in sequences:
        picture = _trajectories(sequence, outcomes, settings)
        if picture is not None:
            parts.append(canvas.picture(picture, sequence.name))
    values = [[text(record.as_dict()[name]) for name in SHOWN] for record in records]
    parts += [canvas.heading("Every score"), canvas.table(SHOWN, values)]
    fits = [
        [outcome.sequence, outcome.method, f"{outcome.k.k:.6g}", str(outcome.k.n)]
        for outcome in outcomes
        if outcome.k
    ]
    if fits:
        parts += [
            canvas.heading("K, fitted on the other sequences of the scene"),
            canvas.table(["sequence", "method", "K (m per unit of shift)", "windows"], fits),
        ]
    path.write_text(canvas.page("gprodom benchmark", parts), encoding="utf-8")


def _best_row(rows: Items[Items[object]], column: int) -> list[int]:
    known = [(row[column], i) for i, row in enumerate(rows) if isinstance(row[column], float)]
    return [min(known)[1]] if known else []


def _trajectories(sequence: Sequence, outcomes: Items[Outcome], settings: Settings) -> bytes | None:
    truth = read_sequence_truth(sequence)
    done = [o.method for o in outcomes if o.sequence == sequence.name and o.records]
    if truth is None or not done:
        return None
    paths: dict[str, Trajectory] = {}
    for method in done:
        pairs = associate(read_tum(sequence.folder / f"{method}.tum"), truth)
        try:
            transform = fit(pairs, settings.align, settings.first_m)
        except Error:
            continue
        paths[method] = transform.apply(pairs.estimate)
    figure, (axis,) = canvas.new_figure(width=7.5, height=5.0)
    draw_paths(axis, truth.position, paths)
    axis.legend(loc="center left", bbox_to_anchor=(1.01, 0.5), frameon=False, fontsize="small")
    axis.set_title(sequence.name)
    return canvas.png(figure, dpi=90)
