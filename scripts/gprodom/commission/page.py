"""The page about a commissioning: what was found, what was not shown, and what it changes."""

import html

import numpy as np

import gprodom
from gprodom import canvas
from gprodom.commission.compare import Comparison, aligned
from gprodom.commission.find import Commission
from gprodom.commission.parameter import Parameter
from gprodom.commission.sensors import heading_at_wheel
from gprodom.errors import Error
from gprodom.odometry.dead_reckoning import has_wheel, wheel_distance
from gprodom.plot.log import wheel_speed
from gprodom.report.page import STYLE, cards, drawn
from gprodom.report.pictures import NARROW_IN, WIDE_IN, thinned
from gprodom.trajectory import Trajectory

BLUE, ORANGE, GREEN, PINK = canvas.COLOURS[:4]
COLOURS = {"before": ORANGE, "after": BLUE}
TURN_S = 1.0  # over which the rate of turn is taken


def lines_of(found: Commission) -> list[list[str]]:
    """Constant, value, whether it is written, remark: of what was shown."""
    return [
        [each.name, in_words(each), "yes" if each.settings else "no", each.remark]
        for each in found.parameters
        if each.value
    ]


def missing(found: Commission) -> list[list[str]]:
    """Constant, why, manoeuvre: of what the recording does not show, or not well."""
    return [
        [each.name, each.remark if not each.value else "shown badly", each.manoeuvre or "–"]
        for each in found.parameters
        if not each.value or each.manoeuvre
    ]


def in_words(parameter: Parameter) -> str:
    """Value and standard deviation; angles in degrees."""
    if parameter.unit != "rad":
        return parameter.text
    values = ", ".join(f"{np.degrees(value):.1f}" for value in parameter.value)
    sigmas = ", ".join(f"{np.degrees(sigma):.1f}" for sigma in parameter.sigma)
    return f"{values} ± {sigmas}°"


def errors_of(comparison: Comparison) -> list[list[str]]:
    """Way and its error, m."""
    return [
        [way.name, "–" if way.error_m is None else f"{way.error_m:.3f}", way.why]
        for way in comparison.ways
    ]


def reference_name(comparison: Comparison) -> str:
    """What errors are against."""
    if comparison.of_truth:
        return "from the recorded positions"
    return "from wheel and gyro alone, which is no truth: it drifts, too"


def write_html(name: str, found: Commission, comparison: Comparison | None) -> str:
    """The whole page. comparison: None where nothing was replayed."""
    written = sum(bool(each.settings) for each in found.parameters)
    lacking = missing(found)
    lead = (
        f"{written} of {len(found.parameters)} constants are written to the configuration; "
        f"{len(lacking) or 'none'} {'needs' if len(lacking) < 2 else 'need'} another manoeuvre, or "
        f"{'is' if len(lacking) < 2 else 'are'} not there; the doctor finds "
        f"{len(found.findings) or 'nothing'} that a configuration does not mend."
    )
    parts = [
        f'<p class="lead">{html.escape(lead)}</p>',
        canvas.heading("What was found"),
        cards("found", ("constant", "value ± 1 σ", "written", "remark"), lines_of(found)),
        canvas.heading("What the recording does not show, and what would"),
        cards("missing", ("constant", "why", "manoeuvre"), lacking)
        if lacking
        else canvas.paragraph("Nothing is missing."),
    ]
    if found.findings:
        rows = [[each.code, each.what, each.mend] for each in found.findings]
        parts += [
            canvas.heading("What to mend in the driver or on the robot"),
            cards("findings", ("what", "seen", "mend"), rows),
        ]
    if comparison is not None:
        parts += [
            canvas.heading("The drive, before and after"),
            cards("errors", ("", "RMS (m)", ""), errors_of(comparison)),
            canvas.paragraph(
                f"RMS distance {reference_name(comparison)}, after moving each way onto it."
            ),
            *drawn("ways", lambda narrow: above_figure(comparison, narrow), "From above."),
        ]
    if has_wheel(found.sensors) and "imu" in found.sensors:
        caption = "The drive: speed by the wheel and rate of turn by the gyro, clocks put right."
        parts += [
            canvas.heading("What was driven"),
            *drawn("driven", lambda narrow: driven_figure(found, narrow), caption),
        ]
    parts.append(canvas.paragraph(f"gprodom {gprodom.__version__}. σ is one standard deviation."))
    return canvas.page(f"Commissioning by {name}", parts, STYLE)


def above_figure(comparison: Comparison, narrow: bool) -> canvas.Figure:
    """The ways of the last method before and after, on the reference."""
    width = NARROW_IN if narrow else WIDE_IN
    figure, (axis,) = canvas.new_figure(width=width, height=4.2 if narrow else 4.8)
    reference = _shown(comparison.reference)
    label = "recorded positions" if comparison.of_truth else "wheel and gyro alone"
    axis.plot(*reference.position[:, :2].T, color=canvas.TRUTH_COLOUR, lw=2.5, label=label)
    replayed = [way for way in comparison.ways if way.name.endswith(tuple(COLOURS))]
    for way in replayed[-2:]:
        if way.path is None:
            continue
        path = _shown(aligned(way.path, comparison.reference)).position
        dashes = "-" if way.name.endswith("after") else (0, (4, 2))
        colour = COLOURS[way.name.rpartition(" ")[2]]
        axis.plot(*path[:, :2].T, color=colour, lw=1.2, ls=dashes, label=way.name)
    canvas.seen_from_above(axis)
    canvas.legend_below(axis, 1 if narrow else 3, fontsize=8)
    return figure


def _shown(path: Trajectory) -> Trajectory:
    return path.select(thinned(len(path)))


def driven_figure(found: Commission, narrow: bool) -> canvas.Figure:
    """Speed and rate of turn along time."""
    width = NARROW_IN if narrow else WIDE_IN
    figure, (speed, turn) = canvas.new_figure(2, 1, width=width, height=3.6, sharex=True)
    measured = wheel_speed(found.sensors)
    assert measured is not None
    time, _ = wheel_distance(found.sensors)
    clock = (time - time[0]) * 1e-6
    rows = thinned(len(clock))
    speed.plot(clock[rows], measured[1][rows], color=BLUE, lw=0.9)
    speed.set_ylabel("speed (m/s)")
    try:
        yaw = heading_at_wheel(found.sensors)
        ahead, behind = (np.interp(clock + s * TURN_S / 2, clock, yaw) for s in (1, -1))
        rate = np.degrees(ahead - behind) / TURN_S
        turn.plot(clock[rows], rate[rows], color=GREEN, lw=0.9)
    except Error:  # no standstill: no bias, so no rate
        pass
    turn.set(ylabel="turn (°/s)", xlabel="time (s)")
    figure.align_ylabels([speed, turn])
    return figure
