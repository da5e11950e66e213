"""What else decides whether it is of use: a line each in docs/results.md."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from layout import Figures, Row, metres, plain, table, whole

UNKNOWN = "?"  # in an answer that is not written


def questions(f: Figures) -> str:
    """The table; without the lines of which something was not measured."""
    lines = [line for part in PARTS for line in part(f) if UNKNOWN not in str(line[1])]
    return table(["what", "measured", "bench"], lines) if lines else ""


def _of(f: Figures, bench: str, name: str, form: Callable[[float | None], str] = whole) -> str:
    value = f.of(bench, name)
    return UNKNOWN if value is None else form(value)


def starts(f: Figures) -> Iterator[Row]:
    """In mid-drive."""
    rows = [f"{d}/{c}" for d in f.parts("mid_drive") for c in f.parts("mid_drive", 1)]
    keys = ("causal_m", "normal_m", "smoothed_m", "normal_smoothed_m")
    live, normal, after, normal_after = (
        metres(f.mean("mid_drive", rows, key)) or UNKNOWN for key in keys
    )
    what = "start in mid-drive: mean error (of a normal start, same stretch), live; afterwards"
    yield [what, f"{live} m ({normal}); {after} m ({normal_after})", "`mid_drive`"]
    nees, late = (f.greatest("mid_drive", rows, key) for key in ("nees_xy", "start_s"))
    answer = f"{plain(nees) or UNKNOWN}; {plain(late, 1)} s"
    yield ["its NEES and time until the first pose, largest", answer, "`mid_drive`"]


def wheel(f: Figures) -> Iterator[Row]:
    """That fails, and slips of it."""
    drives = f.parts("wheel_fails")
    means = [
        metres(f.mean("wheel_fails", drives, f"{how}, {use}_m")) or UNKNOWN
        for how in ("missing", "stuck")
        for use in ("never", "contradicted")
    ]
    what = "wheel gone for 10 s: mean error without coherence, with it; wheel's count stuck"
    answer = f"{means[0]} m, {means[1]} m; {means[2]} m, {means[3]} m"
    yield [what, answer, "`wheel_fails`"]
    keys = ("in_time", "cases", "false_alarms")
    in_time, cases, alarms = (_of(f, "immobilised", key) for key in keys)
    answer = f"{in_time} of {cases}; {alarms} in {_of(f, 'immobilised', 'km', plain)} km"
    yield ["immobilised robots told in time; false alarms", answer, "`immobilised`"]


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
    what = f"{what}; wrong revisits of another process move its end by at most"
    held.append(f"{_of(f, 'coverage', 'moved_m_max', metres)} m")
    yield [what, "; ".join(held), "`coverage`"]
    robots = [
        f"{plain(f.of('consistency', f'{robot}/nees_xy'))} {robot.partition(',')[0]}"
        for robot in f.parts("consistency")
    ]
    what = "NEES of x, y of simulated robots that do not slip (2 is right)"
    yield [what, "; ".join(robots) or UNKNOWN, "`consistency`"]


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
    false = [_of(f, "relocation", f"false_on_{kind}_ground") for kind in ("known", "unknown")]
    what = "located after a reset; after, median; falsely on known, on unknown ground"
    yield [what, f"{right}; {after} m; {false[0]}, {false[1]}", "`relocation`"]
    keys = ("right", "runs", "false_on_strangers", "strangers")
    changed = []
    for change in f.parts("changed_ground"):
        found = [_of(f, "changed_ground", f"{change}/{key}") for key in keys]
        changed.append(f"{change}: {found[0]} of {found[1]}, {found[2]} of {found[3]}")
    what = "located with permittivity changed by; on a stranger's ground"
    yield [what, "; ".join(changed) or UNKNOWN, "`changed_ground`"]
    real = []
    for kind in f.parts("another_day"):
        right, number, wrong = (
            f.of("another_day", f"{kind}/{key}") for key in ("right", "number", "false")
        )
        told = f"{whole(right)} of " if right is not None else ""
        real.append(f"{kind}: {told}{whole(number)}, {whole(wrong)}")
    what = "located rightly on real ground; falsely"
    yield [what, "; ".join(real) or UNKNOWN, "`another_day`"]


def begun_with_a_map(f: Figures) -> Iterator[Row]:
    """The twelve."""
    days = [f"same/{d}" for d in f.parts("days", 1) if d.isdigit()]
    both = [metres(f.mean("days", days, key)) or UNKNOWN for key in ("with_map_m", "without_m")]
    found = [
        f"{_of(f, 'days', f'{kind}/located')} of {_of(f, 'days', f'{kind}/drives')}"
        for kind in ("same", "strangers")
    ]
    what = "located in the map of an earlier drive; error from there, without it; on other ground"
    yield [what, f"{found[0]}; {both[0]} m, {both[1]} m; {found[1]}", "`days`"]


def joined(f: Figures) -> Iterator[Row]:
    """Maps of two days."""
    found = []
    for change in f.parts("merge"):
        count = f"{_of(f, 'merge', f'{change}/proven')} of {_of(f, 'merge', f'{change}/runs')}"
        errors = [_of(f, "merge", f"{change}/{key}", metres) for key in ("before_m", "after_m")]
        found.append(f"{change}: {count}, {errors[0]} m, {errors[1]} m")
    what = "maps of two days joined, ground changed by; error before, after"
    yield [what, "; ".join(found) or UNKNOWN, "`merge`"]


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
