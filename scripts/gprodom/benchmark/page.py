"""report.html of a benchmark: the paper's experiments on these sequences, then every figure."""

import zipfile
from collections.abc import Sequence as Items
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from gprodom import canvas
from gprodom.benchmark import pictures
from gprodom.benchmark.jobs import CAUSAL, Outcome, Sequence, Settings
from gprodom.benchmark.pairs import compare_methods, pair_cells
from gprodom.benchmark.results import mean_of, summarise, table_cells, weighted_mean
from gprodom.files import write_text
from gprodom.score.figures import FIGURE_NAMES
from gprodom.score.page import text
from gprodom.score.record import Record, scene_of

# Figures that others published on CMU-GPR.
SCENES = ("gates_g", "nsh_b", "nsh_h")  # parking garage, basement, factory floor


@dataclass(frozen=True)
class Published:
    """RMSE in metres by scene and over all; alignment and definition are not stated by any."""

    who: str
    scenes: dict[str, float]
    overall: float | None
    note: str = ""


FUSED = (
    Published(
        "Li et al. 2025, fused (arXiv 2503.18301)",
        dict(zip(SCENES, (0.468, 0.734, 0.439), strict=True)),
        0.568,
        "weighted by length; 0.562 by the lengths of the dataset",
    ),
    Published("CMU learned model (Baikovitz et al. 2021)", {}, 0.59),
    Published("GPR-OdomNet (arXiv 2511.17457)", {}, 0.449),
)
GPR_ONLY = (
    Published("Li et al. 2025, GPR only", {"gates_g": 1.73}, 2.23, "mean over scenes"),
    Published("Li et al. 2025, wheel", {"gates_g": 2.52}, None),
)


def is_of_dataset(source: Path) -> bool:
    """Whether a sequence is from CMU-GPR: only that dataset has pictures of a camera."""
    if source.is_dir():
        return (source / "camera").is_dir()
    if not zipfile.is_zipfile(source):
        return False
    with zipfile.ZipFile(source) as archive:
        return any("/camera/" in f"/{name}" for name in archive.namelist())


SHOWN = ("sequence", "method", "mode", *FIGURE_NAMES, "map_jumps")
MOST_PATHS = 24
DPI = 150  # half as fine again as a page shows it, for screens that are


def write_report(
    path: Path,
    sequences: Items[Sequence],
    outcomes: Items[Outcome],
    records: Items[Record],
    settings: Settings,
) -> None:
    """One page that fetches nothing."""
    header, rows = table_cells(summarise(records))
    best = _best_row(rows, header.index("mean ATE (m)"))
    parts = [
        canvas.paragraph(
            f"{len(sequences)} sequences. Alignment {settings.align}. Causal: as published, never "
            "rewritten; smoothed: from one solution over all data. Means are over sequences, or "
            "weighted by the distance travelled; the columns of scenes hold the mean absolute "
            "trajectory error (RMS, m)."
        ),
        canvas.heading("Methods"),
        canvas.table(header, [[text(cell) for cell in row] for row in rows], best),
        *_failures(outcomes),
        *_published(sequences, records),
        *_experiments(outcomes, records),
        *_compared(records),
    ]
    values = [[text(record.as_dict()[name]) for name in SHOWN] for record in records]
    parts += [canvas.heading("Every score"), canvas.table(SHOWN, values), *_fits(outcomes)]
    write_text(path, canvas.page("gprodom benchmark", parts))


def _best_row(rows: Items[Items[object]], column: int) -> list[int]:
    known = [(row[column], i) for i, row in enumerate(rows) if isinstance(row[column], float)]
    return [min(known)[1]] if known else []


def _failures(outcomes: Items[Outcome]) -> list[str]:
    cells = [[o.sequence, o.method, o.failure] for o in outcomes if o.failure]
    if not cells:
        return []
    return [canvas.heading("Failed"), canvas.table(["sequence", "method", "reason"], cells)]


def _published(sequences: Items[Sequence], records: Items[Record]) -> list[str]:
    """These results beside those published on CMU-GPR, and whether they can be compared."""
    real = [each.name for each in sequences if is_of_dataset(each.source)]
    if len(real) == len(sequences):
        note = (
            "All sequences are of the CMU-GPR dataset. No paper states its alignment or how its "
            "RMSE is defined, or on which sequences it was taken."
        )
    else:
        note = (
            f"MEASURED ON OTHER DATA: {len(sequences) - len(real)} of {len(sequences)} sequences "
            "are not of the CMU-GPR dataset (they have no camera pictures), so the published rows "
            "are no yardstick for the others. They stand here for their order of magnitude."
        )
    methods = list(dict.fromkeys((record.method, record.mode) for record in records))
    fused = [_row(records, *each) for each in methods]
    alone = [_row(records, *each) for each in methods if each[0] in (pictures.GPR, pictures.WHEEL)]
    header = ["RMSE (m)", *SCENES, "by length", "mean", ""]
    parts = [
        canvas.heading("Beside the published figures"),
        canvas.paragraph(note),
        canvas.table(header, [*fused, *(_printed(each) for each in FUSED)]),
    ]
    if alone:
        parts += [
            canvas.paragraph("The radar alone, and the wheel alone:"),
            canvas.table(header, [*alone, *(_printed(each) for each in GPR_ONLY)]),
        ]
    return parts


def _row(records: Items[Record], method: str, mode: str) -> list[str]:
    own = [r for r in records if (r.method, r.mode) == (method, mode)]
    scenes = [mean_of([r for r in own if r.scene == scene], "ate_rmse_m") for scene in SCENES]
    values = [*scenes, weighted_mean(own), mean_of(own, "ate_rmse_m")]
    return [f"{method}, {mode}", *(text(value) for value in values), "measured here"]


def _printed(published: Published) -> list[str]:
    by_length = published.overall if "length" in published.note else None
    mean = None if by_length is not None else published.overall
    scenes = [text(published.scenes.get(scene)) for scene in SCENES]
    note = "published, on CMU-GPR" + (f"; {published.note}" if published.note else "")
    return [published.who, *scenes, text(by_length), text(mean), note]


def _experiments(outcomes: Items[Outcome], records: Items[Record]) -> list[str]:
    curves = pictures.by_sequence(outcomes)
    scenes = list(dict.fromkeys(record.scene for record in records))
    methods = list(dict.fromkeys(record.method for record in records))
    figures: list[tuple[str, Any, str]] = [
        (
            "Travelled distance",
            pictures.travelled_figure(curves),
            "Distance travelled: truth, wheel, and the radar alone (SFM, its sign from the wheel).",
        ),
        (
            "Error against sampling interval",
            pictures.intervals_figure(curves, scenes),
            "RMS error of the displacement's size from sample to sample, by the time between.",
        ),
        (
            "Error against time",
            pictures.time_figure(curves, scenes, methods),
            "RMS position error up to a time, over the scene's sequences that last as long; "
            "causal, aligned over the whole sequence.",
        ),
    ]
    parts: list[str] = []
    for title, figure, caption in figures:
        if figure is not None:
            image = canvas.picture(canvas.png(figure, dpi=DPI), caption, figure.get_figwidth())
            parts += [canvas.heading(title), image]
    if curves:
        parts.append(canvas.heading("Trajectories"))
    if len(curves) > MOST_PATHS:
        parts.append(canvas.paragraph(f"The first {MOST_PATHS} of {len(curves)} sequences."))
    for name in list(curves)[:MOST_PATHS]:
        figure = pictures.paths_figure(curves[name], methods, name)
        parts.append(canvas.picture(canvas.png(figure, dpi=DPI), name, figure.get_figwidth()))
    return parts


def _compared(records: Items[Record]) -> list[str]:
    pairs = compare_methods([record for record in records if record.mode == CAUSAL])
    if not pairs:
        return []
    header, rows = pair_cells(pairs)
    return [
        canvas.heading("Methods compared"),
        canvas.paragraph(
            "Causal. Mean difference of the trajectory error over the sequences that both were "
            "scored on, with its 95 % interval by bootstrap over sequences. Where the interval "
            "holds 0 no difference is shown."
        ),
        canvas.table(header, [[text(cell) for cell in row] for row in rows]),
    ]


def _fits(outcomes: Items[Outcome]) -> list[str]:
    fits = [
        [o.sequence, o.method, f"{o.k.k:.6g}", str(o.k.n), _fitted_on(o)] for o in outcomes if o.k
    ]
    if not fits:
        return []
    return [
        canvas.heading("K, fitted on other sequences"),
        canvas.table(
            ["sequence", "method", "K (m per unit of shift)", "windows", "fitted on"], fits
        ),
    ]


def _fitted_on(outcome: Outcome) -> str:
    """Sequences of its own scene, or of others where it has no other."""
    scene = scene_of(outcome.sequence)
    scenes = {scene_of(name) for name in outcome.fitted_on}
    count = len(outcome.fitted_on)
    if scenes == {scene}:
        return f"its own scene, {count} sequences"
    return f"other scenes ({', '.join(sorted(scenes))}), {count} sequences: its own has no other"
