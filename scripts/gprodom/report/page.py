"""The page about a drive: where, how far, how sure, what went wrong and when."""

import html
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Any

import numpy as np

import gprodom
from gprodom import canvas
from gprodom.drive.doubt import SIGMAS_95_OF_ONE, radius_95, yaw_sigma
from gprodom.drive.log import Drive
from gprodom.drive.troubles import Trouble, covered_s, stretches
from gprodom.lcm.constants import flag
from gprodom.report import pictures

MOST_ROWS = 24  # of what went wrong: a page of paper
COLUMNS = ("what", "level", "times", "for", "longest from", "at x, y (m)")

STYLE = """
body { max-width: 52rem; }
.lead { font-size: 1.1rem; }
.figure { display: block; max-width: 100%; height: auto; fill: currentColor; }
.narrow { display: none; }
td, th { vertical-align: top; text-align: left; }
td:first-child { white-space: normal; }
.facts td:first-child { color: var(--soft); padding-right: 2rem; }
.troubles td:nth-child(n + 3) { white-space: nowrap; }
.failed, .degraded, .note-level { font-weight: 600; white-space: nowrap; }
.failed::before { content: "\\25A0\\00A0"; color: #d55e00; }
.degraded::before { content: "\\25B2\\00A0"; color: #e69f00; }
.note-level::before { content: "\\25CF\\00A0"; color: #56b4e9; }
@media screen and (max-width: 47rem) {
  body { margin: 1rem auto; }
  .wide { display: none; } .narrow { display: block; }
  table, tbody, tr, td { display: block; } thead { display: none; }
  tr { padding: 0.4rem 0; border-bottom: 1px solid var(--faint); }
  td, td:first-child { border: 0; padding: 0.1rem 0; text-align: left; min-width: 0;
    position: static; }
  td[data-label]::before { content: attr(data-label) ": "; color: var(--soft); }
}
@page { size: A4; margin: 14mm; }
@media print {
  body { margin: 0; max-width: none; font-size: 10pt; }
  p:not(.lead), figcaption { font-size: 8.5pt; margin: 0.4rem 0; }
  h2 { break-after: avoid; margin-top: 1rem; } figure, tr { break-inside: avoid; }
  .figure { margin: auto; }
  .above .figure { max-height: 90mm; width: auto; }
  .time .figure { max-height: 142mm; width: auto; }
}
"""


@dataclass(frozen=True)
class Fact:
    """A row of the first table. key: of --json."""

    key: str
    value: Any
    name: str
    text: str


def facts_of(drive: Drive, troubles: Sequence[Trouble]) -> list[Fact]:
    """Where, how far, how sure."""
    path, odometry = drive.path, drive.log["odometry"]
    driven = float(np.maximum(np.diff(odometry["distance"]), 0).sum())
    radius = radius_95(path)
    worst = int(np.argmax(radius))
    worst_s = float(drive.clock(path.time[worst : worst + 1])[0])
    yaw = SIGMAS_95_OF_ONE * float(np.degrees(yaw_sigma(path)[-1]))
    away = float(np.linalg.norm(path.position[-1, :2] - path.position[0, :2]))
    begin = datetime.fromtimestamp(drive.origin * 1e-6, UTC)
    x, y = (float(value) for value in path.position[-1, :2])
    heading = pictures.heading_at(path, len(path) - 1)
    found = [
        Fact("begin", begin.isoformat(), "begin", f"{begin:%Y-%m-%d %H:%M:%S} UTC"),
        Fact("seconds", drive.seconds, "duration", duration(drive.seconds)),
        Fact("distance_m", driven, "distance driven", f"{driven:.1f} m"),
        Fact("end_m", [x, y], "end", f"x {x:.2f} m, y {y:.2f} m, heading {heading:.0f}°"),
        Fact("from_start_m", away, "end from start", f"{away:.2f} m"),
        Fact("end_radius_95_m", radius[-1], "position at the end", f"± {radius[-1]:.2f} m"),
        Fact("end_heading_95_deg", yaw, "heading at the end", f"± {yaw:.1f}°"),
        Fact(
            "worst_radius_95_m",
            radius[worst],
            "least sure",
            f"± {radius[worst]:.2f} m, {worst_s:.0f} s after the first pose",
        ),
        *_revisit_facts(drive),
        *_wheel_facts(drive),
        *_frame_facts(drive),
    ]
    worse = [each for each in troubles if each.level != "note"]
    return [*found, Fact("troubles", len(worse), "degraded or failed", verdict(worse))]


def verdict(worse: Sequence[Trouble]) -> str:
    """What is told above all tables."""
    if not worse:
        return "nothing"
    lasted = duration(covered_s(worse))
    return f"{len(worse)} thing{'s' if len(worse) > 1 else ''}, {lasted} altogether"


def duration(seconds: float) -> str:
    """Such as 2 min 5 s."""
    whole = round(seconds)
    if whole < 60:
        return f"{whole} s"
    minutes, rest = divmod(whole, 60)
    return f"{minutes} min {rest} s" if minutes < 60 else f"{minutes // 60} h {minutes % 60} min"


def _revisit_facts(drive: Drive) -> list[Fact]:
    found = pictures.revisits_of(drive)
    count = len(found.end)
    if not count and not drive.steps:
        return [Fact("revisits", 0, "ground known again", "none: the position drifts")]
    largest = max(drive.steps, key=lambda jump: jump.metres, default=None)
    moved = f"; the largest step of the pose in map {largest.metres:.2f} m" if largest else ""
    before = int(np.count_nonzero(found.start < drive.origin))
    earlier = f", {before} of them on ground of earlier drives" if before else ""
    return [Fact("revisits", count, "ground known again", f"{count} times{earlier}{moved}")]


def _wheel_facts(drive: Drive) -> list[Fact]:
    odometry = drive.log["odometry"]
    slips = stretches(
        drive.clock(odometry["utime"]), (odometry["flags"] & flag("SLIPPING")) != 0, 0.0
    )
    slipped = sum(each for _, each in slips)
    scale, sigma = (float(odometry[name][-1]) for name in ("wheel_scale", "wheel_scale_sigma"))
    found = [
        Fact("slipping_s", slipped, "wheel slipped for", duration(slipped)),
        Fact("wheel_scale", scale, "wheel scale", f"{scale:.4f} ± {sigma:.4f} (1 σ)"),
    ]
    reckoned = drive.dead_reckoning
    if reckoned is not None:
        row = max(int(np.searchsorted(reckoned.time, drive.path.time[-1])) - 1, 0)
        apart = float(np.linalg.norm(reckoned.position[row, :2] - drive.path.position[-1, :2]))
        text = f"{apart:.2f} m from the estimate at the end"
        found.append(Fact("dead_reckoning_end_m", apart, "wheel and gyro alone", text))
    return found


def _frame_facts(drive: Drive) -> list[Fact]:
    frame = drive.frame
    if frame is None:
        return []
    second = float(drive.clock(np.array([frame.utime]))[0])
    if frame.why == "located":
        text = f"after {frame.driven_m:.1f} m, {second:.0f} s after the first pose"
        return [Fact("located_after_m", frame.driven_m, "located in an earlier map", text)]
    text = f"{second:.0f} s after the first pose; the {frame.driven_m:.1f} m before are not drawn"
    return [Fact("reset_after_m", frame.driven_m, "reset", text)]


def write_html(drive: Drive, troubles: Sequence[Trouble], facts: Sequence[Fact]) -> str:
    """The whole page."""
    by_key = {fact.key: fact for fact in facts}
    lead = (
        f"{by_key['distance_m'].text} in {by_key['seconds'].text}. At the end the position is "
        f"known to {by_key['end_radius_95_m'].text} (95\u00a0%). Degraded or failed: "
        f"{by_key['troubles'].text}."
    )
    parts = [
        f'<p class="lead">{html.escape(lead)}</p>',
        canvas.heading("At a glance"),
        cards("facts", ("", ""), [[fact.name, fact.text] for fact in facts]),
        *_figures("above", drive, pictures.above_figure, ABOVE, "The way"),
        canvas.heading("What went wrong, and when"),
        *_troubles(drive, troubles),
        *_figures("time", drive, pictures.time_figure, ALONG_TIME, "Along time"),
        *_figures("revisits", drive, pictures.revisits_figure, REVISITS, "Ground known again"),
        *_figures("ground", drive, pictures.ground_figure, GROUND, "The ground"),
        canvas.paragraph(
            f"gprodom {gprodom.__version__}. ± without more is 95 %; σ is one standard deviation. "
            "These are the estimator's own figures: nothing was compared with a truth."
            + (" The log has one: gprodom score compares them." if drive.truth is not None else "")
        ),
    ]
    return canvas.page(f"Drive {drive.name}", parts, STYLE)


ABOVE = (
    "The way from above, in map, and where the robot believes itself with 95 %. Wheel and gyro "
    "alone begin at the same pose."
)
ALONG_TIME = (
    "Along time, from the first pose on: speed, standard deviations (position: of x and y "
    "together), and what was told: health (green: ok, yellow: degraded, red: failed), flags, "
    "revisits."
)
REVISITS = (
    "Revisits: when ground was known again, and when it was first seen (that of earlier drives at "
    "the foot); and how far corrections moved the pose in map."
)
GROUND = (
    "Radargram along the way: the mean trace is taken out, and each row is shown relative to its "
    "own strength."
)


def _figures(
    name: str,
    drive: Drive,
    draw: Callable[[Drive, bool], canvas.Figure | None],
    caption: str,
    heading: str,
) -> list[str]:
    found = drawn(name, lambda narrow: draw(drive, narrow), caption)
    return [canvas.heading(heading), *found] if found else []


def drawn(name: str, draw: Callable[[bool], canvas.Figure | None], caption: str) -> list[str]:
    """The wide and the narrow picture, of which a screen shows one; [] where there is none."""
    figures = {kind: draw(kind == "narrow") for kind in ("wide", "narrow")}
    elements = [
        f'<div class="{kind}">{canvas.svg(figure, f"{name}-{kind}", caption)}</div>'
        for kind, figure in figures.items()
        if figure is not None
    ]
    if not elements:
        return []
    text = html.escape(caption)
    return [f'<figure class="{name}">{"".join(elements)}<figcaption>{text}</figcaption></figure>']


def _troubles(drive: Drive, troubles: Sequence[Trouble]) -> list[str]:
    if not troubles:
        return [canvas.paragraph("Nothing: the estimator told of no trouble.")]
    rows = [_row(drive, each) for each in troubles[:MOST_ROWS]]
    found = [
        cards("troubles", ("what", "level", "times", "for", "longest from", "at x, y (m)"), rows)
    ]
    left = len(troubles) - len(rows)
    more = f"{left} more kinds of notes are left out. " if left else ""
    meaning = "docs/reference.md says what each of them means, and what to do."
    return [*found, canvas.paragraph(more + meaning)]


def _row(drive: Drive, each: Trouble) -> list[str]:
    start, lasted = each.longest
    seconds = drive.clock(drive.path.time)
    at = "–"
    if seconds[0] <= start <= seconds[-1]:
        place = drive.path.position[int(np.searchsorted(seconds, start)), :2]
        x, y = np.round(place, 1) + 0.0  # no -0.0
        at = f"{x:.1f}, {y:.1f}"
    when = f"{start:.0f} s, for {lasted:.1f} s" if start >= 0 else "before the first pose"
    return [each.what, each.level, str(each.times), duration(each.total_s), when, at]


def cards(kind: str, header: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table of that class, which a narrow screen shows as one paragraph for each row."""
    levels = {"failed": "failed", "degraded": "degraded", "note": "note-level"}

    def cell(name: str, text: str) -> str:
        label = f' data-label="{html.escape(name)}"' if name and name != header[0] else ""
        words = html.escape(text)
        if name == "level":
            words = f'<span class="{levels[text]}">{words}</span>'
        return f"<td{label}>{words}</td>"

    body = "".join(
        f"<tr>{''.join(cell(n, t) for n, t in zip(header, row, strict=True))}</tr>\n"
        for row in rows
    )
    heads = "".join(f"<th>{html.escape(name)}</th>" for name in header)
    head = f"<thead><tr>{heads}</tr></thead>" if any(header) else ""
    return f'<table class="{kind}">{head}<tbody>{body}</tbody></table>'
