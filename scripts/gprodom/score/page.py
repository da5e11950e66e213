"""The HTML page of one score."""

from pathlib import Path

from gprodom import canvas
from gprodom.files import write_bytes, write_text
from gprodom.score.figures import Comparison
from gprodom.score.pictures import error_figure, trajectory_figure
from gprodom.score.record import Record

MEANING = {
    "ate_rmse_m": "absolute trajectory error, RMS (m)",
    "rpe_1m_m": "relative error per metre travelled, RMS (m)",
    "end_m": "error at the end (m)",
    "distance_pct": "error at the end, percent of the distance travelled",
    "nees_xy": "normalised squared error of x, y; 2 where the covariance is right",
    "nees_yaw": "normalised squared error of yaw; 1 where the covariance is right",
    "n": "points compared",
    "excluded": "truth points without an estimate",
    "excluded_s": "for how long there is none (s)",
    "excluded_m": "how far the truth travels meanwhile (m)",
    "distance_m": "distance travelled by the truth (m)",
    "before_m": "driven in another frame, before it was located or reset; left out (m)",
    "map_jumps": "corrections that moved the pose in the map frame",
    "map_jump_mean_m": "their mean size (m)",
    "map_jump_max_m": "the largest (m)",
}


def text(value: object) -> str:
    """A figure as shown on a page."""
    if value is None:
        return "–"
    return f"{value:.3f}" if isinstance(value, float) else str(value)


def write_report(comparison: Comparison, record: Record, folder: Path) -> list[Path]:
    """trajectory.png, error.png and report.html in `folder`, which is made where missing."""
    folder.mkdir(parents=True, exist_ok=True)
    title = record.sequence or "trajectory"
    pictures = {
        folder / "trajectory.png": trajectory_figure(comparison, title),
        folder / "error.png": error_figure(comparison, title),
    }
    images = [canvas.png(figure) for figure in pictures.values()]
    for path, image in zip(pictures, images, strict=True):
        write_bytes(path, image)
    values = record.as_dict()
    rows = [
        [name, text(values[name]), meaning]
        for name, meaning in MEANING.items()
        if name in ("nees_xy", "nees_yaw") or values[name] is not None
    ]
    parts = [
        canvas.paragraph(
            f"Estimate: {record.method}, {record.mode}. Alignment of the estimate to the truth: "
            f"{record.align}."
        ),
        canvas.table(["figure", "value", "meaning"], rows),
        canvas.picture(images[0], "Trajectory seen from above; the dot is where the truth begins."),
        canvas.picture(images[1], "Position error over time."),
    ]
    report = folder / "report.html"
    write_text(report, canvas.page(f"gprodom score: {title}", parts))
    return [*pictures, report]
