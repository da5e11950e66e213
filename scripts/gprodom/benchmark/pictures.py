"""Pictures of a benchmark's report, from the curves that the jobs kept."""

from collections.abc import Mapping
from collections.abc import Sequence as Items
from math import ceil, sqrt
from typing import Any

import numpy as np

from gprodom import canvas
from gprodom.benchmark.curves import INTERVALS, STEP_S, Curves
from gprodom.benchmark.jobs import Outcome
from gprodom.score.record import scene_of

GPR, WHEEL = "gpr_sfm", "wheel"  # the paper's distances: of the radar alone, of the encoder
MOST_PANELS = 11
PAGE_WIDTH = 9.6  # inches; a picture is at most 62rem wide on the page, 930 pixels

ByMethod = Mapping[str, Curves]


def by_sequence(outcomes: Items[Outcome]) -> dict[str, dict[str, Curves]]:
    """The curves there are, by sequence and method."""
    found: dict[str, dict[str, Curves]] = {}
    for outcome in outcomes:
        if outcome.curves is not None:
            found.setdefault(outcome.sequence, {})[outcome.method] = outcome.curves
    return found


def styles(methods: Items[str]) -> dict[str, dict[str, Any]]:
    """How each method is drawn, the same in all pictures."""
    return {name: canvas.line_style(i, len(methods)) for i, name in enumerate(methods)}


def _panels(count: int, height: float) -> tuple[canvas.Figure, list[canvas.Axes]]:
    """Panels, at most three side by side, of a page's width, so that texts stay as large as they
    are; the last one is left for the legend."""
    columns = 2 if count == 3 else min(3, count + 1)
    rows = ceil((count + 1) / columns)
    figure, axes = canvas.new_figure(
        rows, columns, width=PAGE_WIDTH * columns / 3, height=height * rows
    )
    for axis in axes[count:]:
        axis.set_axis_off()
    return figure, axes


def _legend(axes: list[canvas.Axes], count: int) -> None:
    """What the lines of all panels are, in the first one left."""
    lines: dict[str, Any] = {}
    for axis in axes[:count]:
        for line, label in zip(*axis.get_legend_handles_labels(), strict=True):
            lines.setdefault(label, line)
    axes[count].legend(lines.values(), lines.keys(), loc="center left", frameon=False)


def sequence_title(name: str) -> str:
    """A sequence's name, without what all of the dataset have in theirs."""
    return name.removesuffix("-cmu-gpr")


def travelled_figure(curves: Mapping[str, ByMethod]) -> canvas.Figure | None:
    """Distance travelled over time: of the radar alone, of the wheel, of the truth."""
    shown = [name for name, each in curves.items() if GPR in each or WHEEL in each]
    shown = shown[:MOST_PANELS]
    if not shown:
        return None
    figure, axes = _panels(len(shown), 2.6)
    for axis, name in zip(axes, shown, strict=False):
        each = curves[name]
        truth = next(iter(each.values()))
        axis.plot(truth.time, truth.true_distance, color=canvas.TRUTH_COLOUR, lw=4, label="truth")
        for method, style in styles((WHEEL, GPR)).items():
            if method in each:
                own = each[method]
                axis.plot(own.time, own.distance, label=method, **style)
        axis.set(title=sequence_title(name), xlabel="time (s)", ylabel="travelled (m)")
    _legend(axes, len(shown))
    return figure


def intervals_figure(curves: Mapping[str, ByMethod], scenes: Items[str]) -> canvas.Figure | None:
    """RMS error of a displacement against the time over which it is taken, by scene."""
    methods = [method for method in (WHEEL, GPR) if any(method in each for each in curves.values())]
    if not methods:
        return None
    figure, axes = _panels(len(scenes), 2.9)
    for axis, scene in zip(axes, scenes, strict=False):
        here = [each for name, each in curves.items() if scene_of(name) == scene]
        for (method, style), marker in zip(styles(methods).items(), canvas.MARKERS, strict=False):
            values = interval_values([each[method] for each in here if method in each])
            axis.plot(INTERVALS, values, marker=marker, ms=4, label=method, **style)
        axis.set(title=scene or "all", xlabel="sampling interval (s)", ylabel="RMS error (m)")
        canvas.log_scales(axis, "x", "y")
    _legend(axes, len(scenes))
    return figure


def interval_values(curves: Items[Curves]) -> list[float]:
    """RMS over sequences by interval; NaN where no sequence is long enough."""
    values = []
    for i in range(len(INTERVALS)):
        known = [each.interval_rms[i] for each in curves]
        squares = [value**2 for value in known if value is not None]
        values.append(sqrt(sum(squares) / len(squares)) if squares else float("nan"))
    return values


def time_figure(
    curves: Mapping[str, ByMethod], scenes: Items[str], methods: Items[str]
) -> canvas.Figure | None:
    """RMS position error so far against time, over those sequences of each scene that are long
    enough.
    """
    if not curves:
        return None
    figure, axes = _panels(len(scenes), 3.1)
    look = styles(methods)
    for axis, scene in zip(axes, scenes, strict=False):
        here = [each for name, each in curves.items() if scene_of(name) == scene]
        for method in methods:
            runs = [each[method].rms for each in here if method in each]
            if runs:
                mean = _mean_square_root(runs)
                time = np.arange(len(mean)) * STEP_S
                axis.plot(time, mean, label=method, **look[method])
        axis.set(title=scene or "all", xlabel="time (s)", ylabel="RMSE so far (m)")
        canvas.log_scales(axis, "y")
    _legend(axes, len(scenes))
    return figure


def _mean_square_root(runs: Items[Items[float]]) -> np.ndarray:
    longest = max(len(run) for run in runs)
    squares = np.full((len(runs), longest), np.nan)
    for row, run in zip(squares, runs, strict=True):
        row[: len(run)] = np.square(run)
    return np.asarray(np.sqrt(np.nanmean(squares, axis=0)))


def paths_figure(each: ByMethod, methods: Items[str], title: str) -> canvas.Figure:
    """All methods of one sequence over the truth, aligned, seen from above."""
    figure, (axis,) = canvas.new_figure(width=PAGE_WIDTH, height=5.0)
    truth = np.array(next(iter(each.values())).true_path)
    axis.plot(*truth.T, color=canvas.TRUTH_COLOUR, linewidth=4.0, label="truth")
    axis.plot(*truth[0], "o", color="0.2", markersize=5, label="its begin")
    look = styles(methods)
    for method in methods:
        if method in each:
            axis.plot(*np.array(each[method].path).T, label=method, **look[method])
    canvas.seen_from_above(axis)
    axis.legend(loc="center left", bbox_to_anchor=(1.01, 0.5), frameon=False)
    axis.set_title(title)
    return figure
