"""The pictures of a drive's report, each for a wide page and for a narrow screen."""

from typing import Any

import numpy as np

from gprodom import canvas, rotation
from gprodom.arrays import Ints
from gprodom.drive.doubt import ellipses, position_sigma, yaw_sigma
from gprodom.drive.log import Drive
from gprodom.drive.radargram import along_way
from gprodom.drive.troubles import FLAGS, health_spans, stretches
from gprodom.errors import Error
from gprodom.lcm.constants import flag, flag_bits
from gprodom.plot.log import SPEED_SPAN_S, wheel_speed
from gprodom.plot.revisits import Revisits, find_revisits
from gprodom.trajectory import Trajectory, interpolate

WIDE_IN, NARROW_IN = 7.2, 3.5  # of 96 pixels
MOST_POINTS = 2000  # of a curve: as many as a picture has pixels on a fine screen
MOST_LINKS = 300
ELLIPSES = 8
BLUE, ORANGE, GREEN, PINK, AMBER, SKY, BLACK = canvas.COLOURS[:7]
HEALTH = {"ok": GREEN, "degraded": AMBER, "failed": ORANGE}
SMALL: dict[str, Any] = {"frameon": False, "fontsize": 8}
ABOVE_RIGHT: dict[str, Any] = {"loc": "lower right", "bbox_to_anchor": (1.0, 1.0), "ncols": 2,
                               "borderpad": 0, **SMALL}  # fmt: skip


def thinned(count: int) -> Ints:
    """Rows of `count` that are drawn, the last among them."""
    if count <= MOST_POINTS:
        return np.arange(count)
    return np.unique(np.linspace(0, count - 1, MOST_POINTS).astype(int))


def _new(
    rows: int, narrow: bool, height: float, **options: Any
) -> tuple[canvas.Figure, list[canvas.Axes]]:
    from matplotlib import rc_context

    with rc_context({"font.size": 8.5, "axes.titlesize": 9}):
        width = NARROW_IN if narrow else WIDE_IN
        return canvas.new_figure(rows, 1, width=width, height=height, **options)


def above_figure(drive: Drive, narrow: bool) -> canvas.Figure:
    """The way from above: path, dead reckoning, slip, revisits, and how sure the position is."""
    figure, (axis,) = _new(1, narrow, 4.2 if narrow else 4.8)
    path = drive.path
    reckoned = drive.dead_reckoning
    if reckoned is not None:
        rows = thinned(len(reckoned))
        style: dict[str, Any] = {"color": ORANGE, "lw": 1.0, "ls": (0, (4, 2))}
        axis.plot(*reckoned.position[rows, :2].T, label="wheel and gyro alone", **style)
    rows = thinned(len(path))
    axis.plot(*path.position[rows, :2].T, color=BLUE, lw=1.4, label="estimate")
    _draw_slip(axis, drive)
    _draw_links(axis, drive)
    _draw_ellipses(axis, path)
    axis.plot(*path.position[0, :2], "o", color=BLACK, ms=5, label="start")
    axis.plot(*path.position[-1, :2], "s", color=BLACK, ms=5, label="end")
    canvas.seen_from_above(axis)
    canvas.legend_below(axis, 2 if narrow else 4, **SMALL)
    return figure


def _draw_slip(axis: canvas.Axes, drive: Drive) -> None:
    odometry = drive.log["odometry"]
    slips = (odometry["flags"] & flag("SLIPPING")) != 0
    label: str | None = "wheel slips"
    for start, duration in stretches(drive.clock(odometry["utime"]), slips):
        seconds = drive.clock(drive.path.time)
        part = drive.path.position[(seconds >= start) & (seconds <= start + duration), :2]
        if len(part) > 1:
            axis.plot(*part.T, color=AMBER, lw=4.0, alpha=0.7, solid_capstyle="butt", label=label)
            label = None


def _draw_links(axis: canvas.Axes, drive: Drive) -> None:
    path = drive.path
    found = revisits_of(drive).within(path)
    if not len(found.end):
        return
    shown = slice(None, None, 1 + len(found.end) // MOST_LINKS)
    ends = [interpolate(path, t[shown]).position[:, :2] for t in (found.start, found.end)]
    line = np.stack([*ends, np.full(ends[0].shape, np.nan)], axis=1).reshape(-1, 2)
    axis.plot(*line.T, color=PINK, lw=0.8, marker=".", ms=2.5, label="ground known again")


def _draw_ellipses(axis: canvas.Axes, path: Trajectory) -> None:
    assert path.covariance is not None
    travelled = np.concatenate(
        [[0.0], np.cumsum(np.linalg.norm(np.diff(path.position[:, :2], axis=0), axis=1))]
    )
    rows = np.searchsorted(travelled, np.linspace(0, travelled[-1], ELLIPSES + 1)[1:])
    label: str | None = "95 % ellipse"
    chosen = path.select(np.unique(np.minimum(rows, len(path) - 1)))
    for line in ellipses(chosen):
        axis.fill(*line.T, facecolor=SKY, alpha=0.12)
        axis.plot(*line.T, color=SKY, lw=0.8, label=label)
        label = None


def revisits_of(drive: Drive) -> Revisits:
    """Those of the log; none where it tells none."""
    if "displacement" in drive.log:
        return find_revisits(drive.log)
    none = np.zeros(0, np.int64)
    return Revisits(none, none, np.zeros(0), np.zeros(0, bool))


def time_figure(drive: Drive, narrow: bool) -> canvas.Figure:
    """Speed, doubt, and what happened, along time."""
    heights = {"height_ratios": [3, 2.2, 2.2, 2.6]}
    figure, axes = _new(4, narrow, 6.6, sharex=True, gridspec_kw=heights)
    speed, position, heading, strips = axes
    odometry = drive.log["odometry"]
    rows = thinned(len(odometry["utime"]))
    seconds = drive.clock(odometry["utime"])[rows]
    measured = wheel_speed(drive.sensors)
    if measured is not None:
        clock = drive.clock(measured[0])
        kept = thinned(len(clock))
        dashed: dict[str, Any] = {"color": ORANGE, "lw": 0.9, "ls": (0, (4, 1.5))}
        speed.plot(clock[kept], measured[1][kept], label="wheel", **dashed)
    speed.plot(seconds, odometry["velocity"][rows, 0], color=BLUE, lw=0.9, label="estimate")
    speed.set_ylabel("forward\nspeed (m/s)")
    speed.legend(**ABOVE_RIGHT)
    path = drive.path
    rows = thinned(len(path))
    clock = drive.clock(path.time[rows])
    position.plot(clock, position_sigma(path)[rows], color=BLUE, lw=1.0)
    position.set(ylabel="position\nσ (m)", ylim=(0, None))
    heading.plot(clock, np.degrees(yaw_sigma(path)[rows]), color=GREEN, lw=1.0)
    heading.set(ylabel="heading\nσ (°)", ylim=(0, None))
    _draw_strips(strips, drive)
    strips.set(xlabel="time (s)", xlim=(0, max(drive.seconds, SPEED_SPAN_S)))
    figure.align_ylabels(axes)
    return figure


def _draw_strips(axis: canvas.Axes, drive: Drive) -> None:
    """A line for the health, for the revisits, and for each flag that was set."""
    names = ["health"]
    for name, spans in health_spans(drive).items():
        axis.broken_barh(spans, (-0.35, 0.7), color=HEALTH[name], lw=0)
    odometry = drive.log["odometry"]
    seconds = drive.clock(odometry["utime"])
    shown = ["standing", *FLAGS]
    for name, bit in flag_bits().items():
        spans = stretches(seconds, (odometry["flags"] & bit) != 0, 0.0)
        if name in shown and spans:
            colour = SKY if name == "standing" else AMBER
            axis.broken_barh(spans, (len(names) - 0.35, 0.7), color=colour, lw=0)
            names.append(name)
    known = drive.clock(revisits_of(drive).end)
    if len(known):
        axis.vlines(known, len(names) - 0.35, len(names) + 0.35, color=PINK, lw=0.6)
        names.append("revisits")
    axis.set(yticks=range(len(names)), yticklabels=names, ylim=(len(names) - 0.5, -0.5))
    axis.grid(False, axis="y")


def revisits_figure(drive: Drive, narrow: bool) -> canvas.Figure | None:
    """Which ground was known again, and what that did to the path; None without revisits."""
    found = revisits_of(drive)
    if not len(found.end) and not drive.steps:
        return None
    figure, (pairs, moved) = _new(2, narrow, 4.4, sharex=True)
    for mirrored, colour, marker, name in (
        (False, BLUE, "o", "driven as then"),
        (True, ORANGE, "x", "the other way"),
    ):
        those = (found.mirrored == mirrored) & (found.start >= drive.origin)
        if those.any():
            ends = [drive.clock(each[those]) for each in (found.end, found.start)]
            pairs.plot(*ends, marker, color=colour, ms=3, label=f"{name}: {those.sum()}")
    pairs.set(ylabel="ground seen\nfirst at (s)", ylim=(0, drive.seconds))
    before = drive.clock(found.end[found.start < drive.origin])
    if len(before):  # at the foot: it was first seen before all times of this drive
        name = f"of earlier drives: {len(before)}"
        pairs.plot(before, np.zeros(len(before)), "|", color=PINK, ms=9, clip_on=False, label=name)
    if pairs.get_lines():
        pairs.legend(**ABOVE_RIGHT)
    clock = drive.clock(np.array([jump.utime for jump in drive.steps], np.int64))
    moved.vlines(clock, 0, [jump.metres for jump in drive.steps], color=GREEN, lw=1.0)
    moved.set(ylabel="step of the pose\nin map (m)", xlabel="time (s)", ylim=(0, None))
    moved.set_xlim(0, drive.seconds)
    figure.align_ylabels([pairs, moved])
    return figure


def ground_figure(drive: Drive, narrow: bool) -> canvas.Figure | None:
    """The radargram along the way; None without traces."""
    if "gpr_trace" not in drive.sensors:
        return None
    odometry = drive.log["odometry"]
    driven = np.maximum.accumulate(odometry["distance"])
    columns = int((NARROW_IN if narrow else WIDE_IN) * 96)
    try:
        image = along_way(drive.sensors["gpr_trace"], odometry["utime"], driven, columns)
    except Error:
        return None
    figure, (axis,) = _new(1, narrow, 2.6)
    axis.grid(False)
    top, bottom = image.span_ns
    extent = (float(driven[0]), float(driven[0]) + image.length_m, bottom, top)
    shown = axis.imshow(image.echoes, "gray", vmin=-1, vmax=1, aspect="auto", extent=extent)
    shown.set_interpolation("nearest")
    axis.set(xlabel="distance driven (m)", ylabel="two-way time (ns)")
    return figure


def heading_at(path: Trajectory, row: int) -> float:
    """Degrees, counter-clockwise from x."""
    assert path.orientation is not None
    return float(np.degrees(rotation.yaw_of(path.orientation[row : row + 1])[0]))
