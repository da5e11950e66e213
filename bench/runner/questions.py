"""What else decides whether it is of use: a line each in docs/results.md."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from layout import Figures, Row, metres, plain, table, whole

UNKNOWN = "?"  # in an answer that is not written
LASTING = ("ramps", "steps", "turns", "gravel", "ice")  # as bench/runner/benches.py has them
MOST_FAULTS = 4
PAIR_METHODS = ("gprodom", "radar_imu")  # as bench/pair_faults.py has them


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
    nees, late = (f.greatest("mid_drive", rows, key) for key in ("nees_xy", "start_s"))
    what = (
        "start in mid-drive: mean error (of a normal start, same stretch), live; afterwards; "
        "largest NEES, time until the first pose"
    )
    answer = f"{live} m ({normal}); {after} m ({normal_after}); {plain(nees) or UNKNOWN}"
    yield [what, f"{answer}, {plain(late, 1)} s", "`mid_drive`"]


def mountings(f: Figures) -> Iterator[Row]:
    """That are found while driving."""
    names = f.parts("mounting")
    groups = {
        "gentle": [name for name in names if name.isdigit()],
        "real robots": [name for name in names if not name.isdigit()],
    }
    what = "IMU mounted at random, `auto`: error over that of the right mounting, mean (worst)"
    answers = [
        f"{group} {plain(f.mean('mounting', rows, 'over')) or UNKNOWN} "
        f"({plain(f.greatest('mounting', rows, 'over'))})"
        for group, rows in groups.items()
    ]
    yield [what, "; ".join(answers), "`mounting`"]


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


def tied(f: Figures) -> Iterator[Row]:
    """To one datum, and the wheel's scale by fixes."""
    days = [f"days/{kind}" for kind in f.parts("anchors", 1)]
    if found := f.all("anchors", (f"{day}/joined" for day in days)):
        off = metres(f.mean("anchors", days, "error_m")) or "no"
        keys = ("sigma_over_limit", "nees")
        rows = [
            ", ".join(plain(f.of("anchors", f"scale/{row}/{key}")) or UNKNOWN for key in keys)
            for row in ("mean, no slip", "mean")
        ]
        what = "maps of two days tied to one datum: joined, error; two fixes of 2 cm, 90 m apart: "
        what += "sigma of the wheel's scale over its limit, NEES; where it may slip"
        answer = f"{sum(found):.0f} of {len(found)}, {off} m; {'; '.join(rows)}"
        yield [what, answer, "`anchors`"]


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
    cost = plain(f.of("yard", "pieces/cost_last_over_second"))
    memory = plain(f.of("yard", "pieces/memory_last_over_second"))
    rounds = sum(f.all("yard", (f"{piece}/rounds" for piece in pieces)))
    nees = f.all("yard", (f"{piece}/nees_xy" for piece in pieces))
    off = metres(f.of("yard", f"{pieces[-1]}/rmse_in_map_m"))
    one = ", ".join(plain(f.of("yard", f"one/{day}/nees_xy")) for day in (1, 2))
    what = f"a yard of 400 m, {rounds:.0f} rounds in {len(pieces)} runs, each in the map of the "
    what += "one before: cost and memory of the last over the second; NEES; error in the map; NEES "
    what += "of two days in one run"
    answer = f"{cost}, {memory}; {min(nees):.2f} to {max(nees):.2f}; {off} m; {one}"
    yield [what, answer, "`yard`"]


def lasting_slip(f: Figures) -> Iterator[Row]:
    """Over dead reckoning, by kind."""
    names = f.parts("slip_kinds", 2)
    found = []
    for i, kind in enumerate(LASTING):
        some = [name for name in names if int(name.split("-")[0]) % len(LASTING) == i]
        sums = [
            sum(f.all("slip_kinds", (f"{way}/{name}/ate_rmse_m" for name in some)))
            for way in ("gprodom_full/causal", "gprodom_full/smoothed", "wheel/causal")
        ]
        if sums[2]:
            found.append(f"{kind} {plain(sums[0] / sums[2])}, {plain(sums[1] / sums[2])}")
    what = "lasting slip by kind: `gprodom_full` over dead reckoning, live, afterwards"
    yield [what, "; ".join(found) or UNKNOWN, "`slip_kinds`"]


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
    what = "faults of sensors that cost less than 10 % of the error; dearest, over the clean run"
    dearest = "; ".join(f"{name} {plain(known[name])}" for name in worst)
    yield [what, f"{below} of {len(known)}; {dearest}", "`faults`"]
    wrong = sum(f.all("faults", (f"{row}/wrong" for each in rows.values() for row in each)))
    what = "poses of them not finite or back in time, ends, faults of which `STATUS` is silent"
    yield [what, f"{wrong:.0f}", "`faults`"]


def pair_faults(f: Figures) -> Iterator[Row]:
    """Two antennas over ground that repeats itself, and with faults."""

    def total(key: str, *rows: str) -> float:
        return sum(f.all("pair_faults", (f"{row}/{key}" for row in rows)))

    if total("passages", "rebar/none/gprodom"):
        found = []
        for kind in ("pitch", "half", "third"):
            rows, free = ([f"rebar/{k}/{m}" for m in PAIR_METHODS] for k in (kind, "none"))
            share = total("passages", *rows) / max(1.0, total("passages", *free))
            found.append(f"{kind}: {total('wrong', *rows):.0f}, {100 * share:.0f} %")
        what = "rebar at the antennas' distance, half, a third: wrong passages; answers over those"
        what += " without rebar"
        yield [what, "; ".join(found), "`pair_faults`"]
    fails = [f"{drive}/front fails" for drive in f.parts("pairs")]
    errors = (f.mean("pairs", fails, key) for key in ("dead_m", "causal_m", "smoothed_m"))
    what = "front antenna fails after two fifths of a drive: dead reckoning, live, afterwards (m)"
    yield [what, ", ".join(metres(error) or UNKNOWN for error in errors), "`pairs`"]
    grounds = [ground for ground in f.parts("pair_faults") if ground != "rebar"]
    if grounds:
        each = {
            fault: [f"{ground}/{fault}/gprodom" for ground in grounds]
            for fault in ("none", "swapped", "silent", "time zero")
        }
        answer = "; ".join(f"{k}: {total('passages', *r):.0f}" for k, r in each.items())
        wrong = total("wrong", *(row for rows in each.values() for row in rows))
        back = f.greatest("pair_faults", each["silent"], "back_after_s")
        what = "pair with faults: passages; wrong ones; used again after a silence of 10 s"
        yield [what, f"{answer}; {wrong:.0f}; {plain(back, 1)} s", "`pair_faults`"]


def speed(f: Figures) -> Iterator[Row]:
    """Times, on the machine of the run."""
    logs = f.parts("replay_speed")
    for case in f.parts("replay_speed", 1):
        times = [f.of("replay_speed", f"{log}/{case}/times_real_time_cpu") for log in logs]
        if None not in times:
            answer = f"{', '.join(whole(value) for value in times)} times real time"
            yield [f"replay of {', '.join(logs)}: {case}", answer, "`replay_speed`"]
    logs = f.parts("window_solvers")
    if logs:
        ceres, chain = (
            ", ".join(whole(f.of("window_solvers", f"{log}/{key}")) for log in logs)
            for key in ("ceres_x", "chain_x")
        )
        apart = max(f.of("window_solvers", f"{log}/max_m") for log in logs)
        what = f"{', '.join(logs)} by Ceres; by the chain; apart by at most"
        yield [what, f"{ceres}; {chain} times real time; {apart:.0e} m", "`window_solvers`"]
    told = []
    for job in f.parts("ros2_live"):
        keys = ("latency.imu.p50_ms", "latency.imu.p99_ms", "lost")
        values = [f.of("ros2_live", f"{job}/{key}") for key in keys]
        if None not in values:
            p50, p99, lost = values
            told.append(f"{job.replace('_', ' ')} {plain(p50)} ms, {plain(p99)} ms, {lost:.0f}")
    if told:
        what = "ROS 2 node live: IMU to pose, median, p99; lost"
        yield [what, "; ".join(told), "`ros2_live`"]
    for job, name in (("idle", "nothing beside it"), ("busy", "two busy processes beside it")):
        keys = ("latency.imu.p50_ms", "latency.imu.p99_ms", "core_percent", "memory_mb")
        values = [f.of("live", f"{job}/{key}") for key in keys]
        if None not in values:
            p50, p99, core, memory = (plain(value) for value in values)
            answer = f"{p50} ms; {p99} ms; {core} % of a core; {memory} MB"
            what = f"daemon live, {name}: IMU to pose, median; p99; load; memory"
            yield [what, answer, "`live`"]
    labels = [label for label in f.parts("smoothers") if f.of("smoothers", f"{label}/median_ms")]
    if labels:
        times = [plain(f.of("smoothers", f"{label}/median_ms")) for label in labels]
        errors = [metres(f.of("smoothers", f"{label}/error_m")) for label in labels]
        both = (f"{time} ms, {error} m" for time, error in zip(times, errors, strict=True))
        what = f"an update, median, and error: {'; '.join(labels)}"
        yield [what, "; ".join(both), "`smoothers`"]


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
    speed,
)
