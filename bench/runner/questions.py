"""What else decides whether it is of use: a line each in docs/results.md."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial

from layout import Figures, Row, metres, plain, table, whole

LASTING = ("ramps", "steps", "turns", "gravel", "ice")  # as bench/runner/benches.py has them
MOST_FAULTS = 4
PAIR_METHODS = ("gprodom", "radar_imu")  # as bench/pair_faults.py has them


def questions(f: Figures) -> str:
    """The table; without the lines of which something was not measured."""
    lines = [line for part in PARTS for line in part(f)]
    return table(["what", "measured", "bench"], lines) if lines else ""


def filled(answer: str, *values: float | None) -> str | None:
    """The answer with these values; None where one was not measured."""
    return None if None in values else answer.format(*values)


def listed(what: str, bench: str, answers: Sequence[str | None]) -> Iterator[Row]:
    """A line of answers, if all there are were measured."""
    known = [answer for answer in answers if answer is not None]
    if known and len(known) == len(answers):
        yield [what, "; ".join(known), f"`{bench}`"]


def told(what: str, bench: str, answer: str, *values: float | None) -> Iterator[Row]:
    """A line of one answer."""
    yield from listed(what, bench, [filled(answer, *values)])


def starts(f: Figures) -> Iterator[Row]:
    """In mid-drive."""
    rows = [f"{d}/{c}" for d in f.parts("mid_drive") for c in f.parts("mid_drive", 1)]
    keys = ("causal_m", "normal_m", "smoothed_m", "normal_smoothed_m")
    means = [f.mean("mid_drive", rows, key) for key in keys]
    most = [f.greatest("mid_drive", rows, key) for key in ("nees_xy", "start_s")]
    what = "start in mid-drive: mean error (of a normal start, same stretch), live; afterwards; "
    what += "largest NEES, time until the first pose"
    answer = "{:.3f} m ({:.3f}); {:.3f} m ({:.3f}); {:.2f}, {:.1f} s"
    yield from told(what, "mid_drive", answer, *means, *most)


def mountings(f: Figures) -> Iterator[Row]:
    """That are found while driving."""
    names = f.parts("mounting")
    gentle = [name for name in names if name.isdigit()]
    robots = [name for name in names if not name.isdigit()]
    what = "IMU mounted at random, `auto`: error over that of the right mounting, mean (worst)"
    answer = "gentle {:.2f} ({:.2f}); real robots {:.2f} ({:.2f})"
    over = [
        of("mounting", rows, "over") for rows in (gentle, robots) for of in (f.mean, f.greatest)
    ]
    yield from told(what, "mounting", answer, *over)


def wheel(f: Figures) -> Iterator[Row]:
    """That fails, and slips of it."""
    drives = f.parts("wheel_fails")
    means = [
        f.mean("wheel_fails", drives, f"{how}, {use}_m")
        for how in ("missing", "stuck")
        for use in ("never", "contradicted")
    ]
    what = "wheel gone for 10 s: mean error without coherence, with it; wheel's count stuck"
    answer = "{:.3f} m, {:.3f} m; {:.3f} m, {:.3f} m"
    yield from told(what, "wheel_fails", answer, *means)
    values = f.each("immobilised", "in_time", "cases", "false_alarms", "km")
    what = "immobilised robots told in time; false alarms"
    yield from told(what, "immobilised", "{:.0f} of {:.0f}; {:.0f} in {:.2f} km", *values)


def standing(f: Figures) -> Iterator[Row]:
    """Standstill and sudden slip."""
    drives = f.parts("motion")
    if not drives:
        return
    slips = [f.total("motion", drives, key) for key in ("prompt", "episodes")]
    what = "sudden slips flagged within 0.5 s"
    yield from told(what, "motion", "{:.0f} of {:.0f}", *slips)
    keys = ("standing_recall", "standing_false")
    shares = [100 * (f.mean("motion", drives, key) or 0.0) for key in keys]
    what = "standstill that the radar claims; claims while it moves, of that time"
    yield from told(what, "motion", "{:.1f} %; {:.2f} %", *shares)


def covariance(f: Figures) -> Iterator[Row]:
    """Is it true?"""
    shares = [100 * share for share in f.all("coverage", ("coverage_end", "coverage_all"))]
    what = "95 % ellipse in `map` holds the truth: at the end; always"
    what = f"{what}; wrong revisits of another process move its end by at most"
    if shares:
        answer = "{:.0f} %; {:.0f} %; {:.3f} m"
        yield from told(what, "coverage", answer, *shares, f.of("coverage", "moved_m_max"))
    robots = [
        filled(f"{{:.2f}} {robot.partition(',')[0]}", f.of("consistency", f"{robot}/nees_xy"))
        for robot in f.parts("consistency")
    ]
    what = "NEES of x, y of simulated robots that do not slip (2 is right)"
    yield from listed(what, "consistency", robots)


def revisits(f: Figures) -> Iterator[Row]:
    """Of the gentle drives."""
    rows = [f"{d}/free/gprodom_full" for d in f.parts("revisits")]
    wrong, found = (f.total("revisits", rows, key) for key in ("wrong", "revisits"))
    most = f.greatest("revisits", rows, "rms_cm")
    what = "wrong revisits of the gentle drives; RMS of a drive's others at most"
    yield from told(what, "revisits", "{:.0f} of {:.0f}; {:.1f} cm", wrong, found, most)
    true = [row.replace("/free/", "/true/") for row in rows]
    both = [f.mean("revisits", true, key) for key in ("se2_c", "se2_s")]
    what = "`gprodom_full` with the wheel's true scale: mean error live; afterwards"
    yield from told(what, "revisits", "{:.3f} m; {:.3f} m", *both)


def live(f: Figures) -> Iterator[Row]:
    """A daemon among faults."""
    values = f.each("hostile_packets", "packets", "wrong")
    what = "hostile packets beside a robot's; poses that differ, losses, ends"
    yield from told(what, "hostile_packets", "{:.0f}; {:.0f}", *values)
    values = f.each("process_faults", "faults", "wrong", "killed/pose_after_s")
    what = "faults of process, disk, listener; not held or not told; a pose after kill -9"
    yield from told(what, "process_faults", "{:.0f}; {:.0f}; after {:.2f} s", *values)


def located(f: Figures) -> Iterator[Row]:
    """On ground of a map."""
    keys = ("right", "runs", "located_after_m_median")
    false = ("false_on_known_ground", "false_on_unknown_ground")
    what = "located after a reset; after, median; falsely on known, on unknown ground"
    answer = "{:.0f} of {:.0f}; {:.1f} m; {:.0f}, {:.0f}"
    yield from told(what, "relocation", answer, *f.each("relocation", *keys, *false))
    changed = []
    for change in f.parts("changed_ground"):
        keys = ("right", "runs", "false_on_strangers", "strangers")
        found = f.each("changed_ground", *(f"{change}/{key}" for key in keys))
        changed.append(filled(f"{change}: {{:.0f}} of {{:.0f}}, {{:.0f}} of {{:.0f}}", *found))
    what = "located with permittivity changed by; on a stranger's ground"
    yield from listed(what, "changed_ground", changed)
    real = []
    for kind in f.parts("another_day"):
        right, number, wrong = (
            whole(f.of("another_day", f"{kind}/{key}")) for key in ("right", "number", "false")
        )
        real.append(f"{kind}: {f'{right} of ' if right else ''}{number}, {wrong}")
    yield from listed("located rightly on real ground; falsely", "another_day", real)


def begun_with_a_map(f: Figures) -> Iterator[Row]:
    """The twelve."""
    days = [f"same/{d}" for d in f.parts("days", 1) if d.isdigit()]
    both = [f.mean("days", days, key) for key in ("with_map_m", "without_m")]
    same = f.each("days", "same/located", "same/drives")
    strangers = f.each("days", "strangers/located", "strangers/drives")
    what = "located in the map of an earlier drive; error from there, without it; on other ground"
    answer = "{:.0f} of {:.0f}; {:.3f} m, {:.3f} m; {:.0f} of {:.0f}"
    yield from told(what, "days", answer, *same, *both, *strangers)


def joined(f: Figures) -> Iterator[Row]:
    """Maps of two days."""
    found = []
    for change in f.parts("merge"):
        keys = ("proven", "runs", "before_m", "after_m")
        values = f.each("merge", *(f"{change}/{key}" for key in keys))
        found.append(filled(f"{change}: {{:.0f}} of {{:.0f}}, {{:.3f}} m, {{:.3f}} m", *values))
    yield from listed(
        "maps of two days joined, ground changed by; error before, after", "merge", found
    )


def tied(f: Figures) -> Iterator[Row]:
    """To one datum, and the wheel's scale by fixes."""
    days = [f"days/{kind}" for kind in f.parts("anchors", 1)]
    if found := f.all("anchors", (f"{day}/joined" for day in days)):
        off = metres(f.mean("anchors", days, "error_m")) or "no"
        scales = [
            f.of("anchors", f"scale/{row}/{key}")
            for row in ("mean, no slip", "mean")
            for key in ("sigma_over_limit", "nees")
        ]
        what = "maps of two days tied to one datum: joined, error; two fixes of 2 cm, 90 m apart: "
        what += "sigma of the wheel's scale over its limit, NEES; where it may slip"
        answer = (
            f"{sum(found):.0f} of {len(found)}, {off} m; {{:.2f}}, {{:.2f}}; {{:.2f}}, {{:.2f}}"
        )
        yield from told(what, "anchors", answer, *scales)


def ground(f: Figures) -> Iterator[Row]:
    """Revisits on real lines, calibration, and the simulated ground."""
    for variant in f.parts("revisit_along")[:1]:  # the whole matcher; then one check off at a time
        keys = ("told", "right_told", "false", "negatives")
        values = f.each("revisit_along", *(f"{variant}/{key}" for key in keys))
        what = "revisits 20 cm aside on real lines: accepted; right of these; false"
        yield from told(what, "revisit_along", "{:.3f}; {:.3f}; {:.0f} of {:.0f}", *values)
    grounds = [f"{g}/{t}" for g in f.parts("radar_time_offset") for t in ("0 ms", "50 ms")]
    rms = f.all("radar_time_offset", (f"{each}/rms_s" for each in grounds))
    parts = ("direct_wave", "pipe", "pipe_from_above", "layer")
    waves = f.all("fdtd", (f"{part}_ns" for part in parts))
    if rms and waves:
        what = "calibration of the radar's time offset, RMS error by ground; FDTD ground against "
        what += "physics, largest error"
        answer = f"{1e3 * min(rms):.1f} to {1e3 * max(rms):.1f} ms; {max(waves):.3f} ns"
        yield [what, answer, "`radar_time_offset`, `fdtd`"]


def again_and_again(f: Figures) -> Iterator[Row]:
    """The same ground: what days on it cost, and whether the covariance is right."""
    pieces = [f"pieces/{day}" for day in f.parts("yard", 1) if f.of("yard", f"pieces/{day}/rounds")]
    if not pieces:
        return
    ratios = [f"pieces/{what}_last_over_second" for what in ("cost", "memory", "map")]
    rounds = f.total("yard", pieces, "rounds")
    nees = f.all("yard", (f"{piece}/nees_xy" for piece in pieces))
    keys = (f"{pieces[-1]}/rmse_in_map_m", "one/1/nees_xy", "one/2/nees_xy")
    what = f"a yard of 400 m, {rounds:.0f} rounds in {len(pieces)} runs, each in the map of the "
    what += "one before: cost, memory and map of the last over the second; NEES; error in the map; "
    what += "NEES of two days in one run"
    answer = f"{{:.2f}}, {{:.2f}}, {{:.2f}}; {min(nees):.2f} to {max(nees):.2f}; "
    answer += "{:.3f} m; {:.2f}, {:.2f}"
    yield from told(what, "yard", answer, *f.each("yard", *ratios, *keys))


def lasting_slip(f: Figures) -> Iterator[Row]:
    """Over dead reckoning, by kind."""
    names = f.parts("slip_kinds", 2)
    found = []
    for i, kind in enumerate(LASTING):
        some = [name for name in names if int(name.split("-")[0]) % len(LASTING) == i]
        live, after, dead = (
            f.total("slip_kinds", [f"{way}/{name}" for name in some], "ate_rmse_m")
            for way in ("gprodom_full/causal", "gprodom_full/smoothed", "wheel/causal")
        )
        if dead:
            found.append(f"{kind} {live / dead:.2f}, {after / dead:.2f}")
    what = "lasting slip by kind: `gprodom_full` over dead reckoning, live, afterwards"
    yield from listed(what, "slip_kinds", found)


def sensor_faults(f: Figures) -> Iterator[Row]:
    """What they cost, and whether anything was wrong."""
    drives, names = f.parts("faults"), f.parts("faults", 1)
    rows = {name: [f"{drive}/{name}" for drive in drives] for name in names}
    means = {name: f.mean("faults", each, "error_ratio") for name, each in rows.items()}
    known = {name: mean for name, mean in means.items() if mean is not None}
    if not known:
        return
    below = sum(ratio < 1.1 for ratio in known.values())
    worst = sorted(known, key=lambda name: known[name], reverse=True)[:MOST_FAULTS]
    dearest = [f"{name} {plain(known[name])}" for name in worst]
    what = "faults of sensors that cost less than 10 % of the error; dearest, over the clean run"
    yield from listed(what, "faults", [f"{below} of {len(known)}", *dearest])
    wrong = sum(f.total("faults", each, "wrong") for each in rows.values())
    what = "poses of them not finite or back in time, ends, faults of which `STATUS` is silent"
    yield from told(what, "faults", "{:.0f}", wrong)


def pair_faults(f: Figures) -> Iterator[Row]:
    """Two antennas over ground that repeats itself, and with faults."""

    total = partial(f.total, "pair_faults")
    if total(["rebar/none/gprodom"], "passages"):
        found = []
        for kind in ("pitch", "half", "third"):
            rows, free = ([f"rebar/{k}/{m}" for m in PAIR_METHODS] for k in (kind, "none"))
            share = total(rows, "passages") / max(1.0, total(free, "passages"))
            found.append(f"{kind}: {total(rows, 'wrong'):.0f}, {100 * share:.0f} %")
        what = "rebar at the antennas' distance, half, a third: wrong passages; answers over those"
        yield from listed(f"{what} without rebar", "pair_faults", found)
    fails = [f"{drive}/front fails" for drive in f.parts("pairs")]
    errors = [f.mean("pairs", fails, key) for key in ("dead_m", "causal_m", "smoothed_m")]
    what = "front antenna fails after two fifths of a drive: dead reckoning, live, afterwards (m)"
    yield from told(what, "pairs", "{:.3f}, {:.3f}, {:.3f}", *errors)
    grounds = [ground for ground in f.parts("pair_faults") if ground != "rebar"]
    if grounds:
        each = {
            fault: [f"{ground}/{fault}/gprodom" for ground in grounds]
            for fault in ("none", "swapped", "silent", "time zero")
        }
        passages = [f"{fault}: {total(rows, 'passages'):.0f}" for fault, rows in each.items()]
        wrong = sum(total(rows, "wrong") for rows in each.values())
        back = f.greatest("pair_faults", each["silent"], "back_after_s")
        what = "pair with faults: passages; wrong ones; used again after a silence of 10 s"
        answers = [*passages, f"{wrong:.0f}", f"{plain(back, 1)} s"]
        yield from listed(what, "pair_faults", answers)


def replays(f: Figures) -> Iterator[Row]:
    """Times, on the machine of the run."""
    logs = f.parts("window_solvers")
    if not logs or not f.parts("replay_speed"):
        return

    def times(bench: str, key: str) -> str:
        return ", ".join(whole(f.of(bench, f"{log}/{key}")) for log in logs)

    default = times("replay_speed", "default/times_real_time_cpu")
    by = [times("window_solvers", f"{solver}_x") for solver in ("ceres", "chain")]
    apart = max(f.all("window_solvers", (f"{log}/max_m" for log in logs)))
    what = f"replay of {', '.join(logs)}, times real time: default; by Ceres; by the chain; both "
    what += "apart by at most"
    yield [what, "; ".join([default, *by, f"{apart:.0e} m"]), "`replay_speed`, `window_solvers`"]


def latencies(f: Figures) -> Iterator[Row]:
    """Of what runs live; and of an update, beside GTSAM's."""
    keys = ("latency.imu.p50_ms", "latency.imu.p99_ms")
    nodes = []
    for job in f.parts("ros2_live"):
        values = f.each("ros2_live", *(f"{job}/{key}" for key in (*keys, "lost")))
        nodes.append(filled(f"{job.replace('_', ' ')} {{:.2f}} ms, {{:.2f}} ms, {{:.0f}}", *values))
    yield from listed("ROS 2 node live: IMU to pose, median, p99; lost", "ros2_live", nodes)
    for job, name in (("idle", "nothing beside it"), ("busy", "two busy processes beside it")):
        values = f.each("live", *(f"{job}/{key}" for key in (*keys, "core_percent", "memory_mb")))
        what = f"daemon live, {name}: IMU to pose, median; p99; load; memory"
        answer = "{:.2f} ms; {:.2f} ms; {:.2f} % of a core; {:.2f} MB"
        yield from told(what, "live", answer, *values)
    updates = []
    labels = [label for label in f.parts("smoothers") if f.of("smoothers", f"{label}/median_ms")]
    for label in labels:
        values = f.each("smoothers", f"{label}/median_ms", f"{label}/error_m")
        updates.append(filled("{:.2f} ms, {:.3f} m", *values))
    yield from listed(f"an update, median, and error: {'; '.join(labels)}", "smoothers", updates)


PARTS = (
    starts,
    mountings,
    wheel,
    standing,
    lasting_slip,
    sensor_faults,
    pair_faults,
    covariance,
    revisits,
    located,
    begun_with_a_map,
    joined,
    tied,
    ground,
    again_and_again,
    live,
    replays,
    latencies,
)
