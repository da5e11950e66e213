"""Pictures of one score."""

from collections.abc import Mapping

from gprodom import canvas
from gprodom.arrays import Floats
from gprodom.score.figures import Comparison
from gprodom.trajectory import Trajectory


def draw_paths(axis: canvas.Axes, truth: Floats | None, paths: Mapping[str, Trajectory]) -> None:
    """Truth (n, 3), if any, in grey and the (already aligned) paths over it, seen from above."""
    if truth is not None:
        axis.plot(truth[:, 0], truth[:, 1], color=canvas.TRUTH_COLOUR, linewidth=4.0, label="truth")
        axis.plot(*truth[0, :2], "o", color="0.2", markersize=5, label="its begin")
    for i, (name, path) in enumerate(paths.items()):
        axis.plot(*path.position[:, :2].T, label=name, **canvas.line_style(i, len(paths)))
    canvas.seen_from_above(axis)


def trajectory_figure(comparison: Comparison, title: str) -> canvas.Figure:
    """Aligned estimate over truth."""
    figure, (axis,) = canvas.new_figure(width=7.0, height=5.5)
    aligned = comparison.transform.apply(comparison.pairs.estimate)
    draw_paths(axis, comparison.pairs.truth.position, {"estimate": aligned})
    axis.set_title(f"{title}, aligned: {comparison.alignment}")
    canvas.legend_below(axis, 3)
    return figure


def error_figure(comparison: Comparison, title: str) -> canvas.Figure:
    """Error over time."""
    figure, (axis,) = canvas.new_figure(width=7.0, height=3.2)
    seconds = comparison.pairs.truth.seconds()
    axis.plot(seconds, comparison.error_m, color=canvas.COLOURS[0], linewidth=1.0)
    rmse = comparison.figures.ate_rmse_m
    axis.axhline(
        rmse, color=canvas.COLOURS[1], linewidth=1.0, linestyle="--", label=f"RMS {rmse:.3f} m"
    )
    axis.set(xlabel="time (s)", ylabel="position error (m)", ylim=(0, None), title=title)
    canvas.legend_below(axis, 1)
    return figure
