"""What else decides whether it is of use: a line each in docs/results.md."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from layout import Figures, Row, metres, plain, table, whole

UNKNOWN = "?"  # in an answer that is not written


def questions(f: Figures) -> str:
    """The table; without the lines of which something was not measured."""
    lines = [
        line
        for part in (
            starts,
            wheel,
            standing,
            covariance,
            revisits,
            located,
            begun_with_a_map,
            joined,
            ground,
            live,
        )
        for line in part(f)
        if UNKNOWN not in str(line[1])
    ]
    return table(["what", "measured", "bench"], lines) if lines else ""


def _of(f: Figures, bench: str, name: str, form: Callable[[float | None], str] = whole) -> str:
    value = f.of(bench, name)
    return UNKNOWN if value is None else form(value)


def starts(f: Figures) -> Iterator[Row]:
    """In mid-drive."""
    rows = [f"{d}/{c}" for d in f.parts("mid_drive") for c in f.parts("mid_drive", 1)]
    for name, key, normal in (
        ("live", "causal_m", "normal_m"),
        ("afterwards", "smoothed_m", "normal_smoothed_m"),
    ):
        means = [metres(f.mean("mid_drive", rows, k)) or UNKNOWN for k in (key, normal)]
        what = f"start in mid-drive, {name}: mean error; of a normal start, same stretch"
        yield [what, f"{means[0]} m; {means[1]} m", "`mid_drive`"]
    nees, late = (f.greatest("mid_drive", rows, key) for key in ("nees_xy", "start_s"))
    answer = f"{plain(nees) or UNKNOWN}; {plain(late, 1)} s"
    yield ["its NEES and time until the first pose, largest", answer, "`mid_drive`"]


def wheel(f: Figures) -> Iterator[Row]:
    """That fails, and slips of it."""
    drives = f.parts("wheel_fails")
    for how in ("missing", "stuck"):
        means = [
            metres(f.mean("wheel_fails", drives, f"{how} {use}_m")) or UNKNOWN
            for use in ("never", "contradicted")
        ]
        what = f"wheel {how} for 10 s: mean error without coherence; with it"
        yield [what, f"{means[0]} m; {means[1]} m", "`wheel_fails`"]
    answer = f"{_of(f, 'immobilised', 'in_time')} of {_of(f, 'immobilised', 'cases')}"
    yield ["immobilised robots told in time", answer, "`immobilised`"]
    kilometres = _of(f, "immobilised", "km", plain)
    answer = f"{_of(f, 'immobilised', 'false_alarms')} in {kilometres} km"
    yield ["false alarms of it", answer, "`immobilised`"]


def standing(f: Figures) -> Iterator[Row]:
    """Standstill and sudden slip."""
    drives = f.parts("motion")
    if not drives:
        return
    prompt, episodes = (
        sum(f.all("motion", (f"{d}/{key}" for d in drives))) for key in ("prompt", "episodes")
    )
    what = "sudden slips flagged within 0.5 s"
    yield [what, f"{prompt:.0f} of {episodes:.0f}", "`motion`"]
    claims, false = (
        f.mean("motion", drives, f"standing_{key}") or 0.0 for key in ("recall", "false")
    )
    what = "standstill that the radar claims; claims while it moves, of that time"
    yield [what, f"{100 * claims:.1f} %; {100 * false:.2f} %", "`motion`"]


def covariance(f: Figures) -> Iterator[Row]:
    """Is it true?"""
    held = [
        _of(f, "coverage", key, lambda v: f"{100 * (v or 0):.0f} %")
        for key in ("coverage_end", "coverage_all")
    ]
    what = "95 % ellipse in `map` holds the truth: at the end; always"
    yield [what, "; ".join(held), "`coverage`"]
    moved = _of(f, "coverage", "moved_m_max", metres)
    what = "wrong revisits of another process move the final pose by at most"
    yield [what, f"{moved} m", "`coverage`"]
    for robot in f.parts("consistency"):
        both = [_of(f, "consistency", f"{robot}/{key}", plain) for key in ("nees_xy", "nees_yaw")]
        what = f"NEES of x, y (2 is right) and yaw (1), no slip: {robot}"
        yield [what, "; ".join(both), "`consistency`"]


def revisits(f: Figures) -> Iterator[Row]:
    """Of the gentle drives."""
    rows = [f"{d}/free/gprodom_full" for d in f.parts("revisits")]
    found, wrong = (
        sum(f.all("revisits", (f"{row}/{key}" for row in rows))) for key in ("revisits", "wrong")
    )
    most = f.greatest("revisits", rows, "rms_cm")
    if most is not None:
        answer = f"{wrong:.0f} of {found:.0f}; {most:.1f} cm"
        what = "wrong revisits of the gentle drives; RMS of a drive's others at most"
        yield [what, answer, "`revisits`"]
        true = [row.replace("/free/", "/true/") for row in rows]
        both = [metres(f.mean("revisits", true, key)) for key in ("se2_c", "se2_s")]
        what = "`gprodom_full` with the wheel's true scale: mean error live; afterwards"
        yield [what, f"{both[0]} m; {both[1]} m", "`revisits`"]


def live(f: Figures) -> Iterator[Row]:
    """A daemon among faults."""
    packets, wrong = (_of(f, "hostile_packets", key) for key in ("packets", "wrong"))
    what = "hostile packets beside a robot's; poses that differ, losses, ends"
    yield [what, f"{packets}; {wrong}", "`hostile_packets`"]
    faults, wrong = (_of(f, "process_faults", key) for key in ("faults", "wrong"))
    after = _of(f, "process_faults", "killed/pose_after_s", plain)
    what = "faults of process, disk, listener; not held or not told; a pose after kill -9"
    yield [what, f"{faults}; {wrong}; after {after} s", "`process_faults`"]


def located(f: Figures) -> Iterator[Row]:
    """On ground of a map."""
    right = f"{_of(f, 'relocation', 'right')} of {_of(f, 'relocation', 'runs')}"
    after = _of(f, "relocation", "located_after_m_median", lambda v: plain(v, 1))
    yield ["located after a reset; after, median", f"{right}; {after} m", "`relocation`"]
    false = [_of(f, "relocation", f"false_on_{kind}_ground") for kind in ("known", "unknown")]
    yield ["located falsely on known; on unknown ground", "; ".join(false), "`relocation`"]
    for change in f.parts("changed_ground"):
        keys = ("right", "runs", "false_on_strangers", "strangers")
        found = [_of(f, "changed_ground", f"{change}/{key}") for key in keys]
        what = f"located with permittivity changed by {change}; on a stranger's ground"
        answer = f"{found[0]} of {found[1]}; {found[2]} of {found[3]}"
        yield [what, answer, "`changed_ground`"]
    for kind in f.parts("another_day"):
        right, number, wrong = (
            _of(f, "another_day", f"{kind}/{key}") for key in ("right", "number", "false")
        )
        answer = f"{right} of {number} right; " if right != UNKNOWN else ""
        what = f"located on real ground: {kind}"
        yield [what, f"{answer}{wrong} of {number} false", "`another_day`"]


def begun_with_a_map(f: Figures) -> Iterator[Row]:
    """The twelve."""
    days = [f"same/{d}" for d in f.parts("days", 1) if d.isdigit()]
    both = [metres(f.mean("days", days, key)) or UNKNOWN for key in ("with_map_m", "without_m")]
    found = [
        f"{_of(f, 'days', f'{kind}/located')} of {_of(f, 'days', f'{kind}/drives')}"
        for kind in ("same", "strangers")
    ]
    what = "located in the map of an earlier drive; error from there; without it"
    yield [what, f"{found[0]}; {both[0]} m; {both[1]} m", "`days`"]
    yield ["located in the map of other ground", found[1], "`days`"]


def joined(f: Figures) -> Iterator[Row]:
    """Maps of two days."""
    for change in f.parts("merge"):
        count = f"{_of(f, 'merge', f'{change}/proven')} of {_of(f, 'merge', f'{change}/runs')}"
        errors = [_of(f, "merge", f"{change}/{key}", metres) for key in ("before_m", "after_m")]
        what = f"maps of two days joined, ground changed by {change}; error before; after"
        yield [what, f"{count}; {errors[0]} m; {errors[1]} m", "`merge`"]


def ground(f: Figures) -> Iterator[Row]:
    """Revisits on real lines, calibration, and the simulated ground."""
    for variant in f.parts("revisit_along")[:1]:  # the whole matcher; then one check off at a time
        told, right = (
            _of(f, "revisit_along", f"{variant}/{key}", lambda v: plain(v, 3))
            for key in ("told", "right_told")
        )
        false, negatives = (
            _of(f, "revisit_along", f"{variant}/{key}") for key in ("false", "negatives")
        )
        what = "revisits 20 cm aside on real lines: accepted; right of these; false"
        yield [what, f"{told}; {right}; {false} of {negatives}", "`revisit_along`"]
    grounds = [f"{g}/{t}" for g in f.parts("radar_time_offset") for t in ("0 ms", "50 ms")]
    rms = f.all("radar_time_offset", (f"{each}/rms_s" for each in grounds))
    if rms:
        what = "calibration of the radar's time offset, RMS error by ground"
        answer = f"{1e3 * min(rms):.1f} to {1e3 * max(rms):.1f} ms"
        yield [what, answer, "`radar_time_offset`"]
    parts = ("direct_wave", "pipe", "pipe_from_above", "layer")
    waves = f.all("fdtd", (f"{part}_ns" for part in parts))
    if waves:
        what = "FDTD ground against physics, largest error"
        yield [what, f"{max(waves):.3f} ns", "`fdtd`"]


PARTS = (
    starts,
    wheel,
    standing,
    covariance,
    revisits,
    located,
    begun_with_a_map,
    joined,
    ground,
    live,
)
