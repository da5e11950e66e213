"""The tables of docs/results.md; empty where nothing of one was measured."""

from __future__ import annotations

from collections.abc import Sequence
from statistics import fmean, geometric_mean

from layout import Figures, Row, metres, plain, table, whole

REAL_GROUND = ("1700010000", "1700011000", "1700012000")  # of the twelve: the beach
ALL = "gprodom_full"
METHODS = ("imu_wheel", "gprodom", ALL)
MOST_FAULTS = 4
LASTING = ("ramps", "steps", "turns", "gravel", "ice")  # as bench/runner/benches.py has them


def ratios(f: Figures, key: str) -> list[float]:
    """Of the recordings of robots of which the truth tells positions; two forms of one are one."""
    names = [name for name in f.parts("robots") if "(" not in name]
    return f.all("robots", (f"{name}/{key}" for name in names))


def head(f: Figures) -> str:
    """The table that README.md has, too."""
    lines: list[Row] = []
    twelve = f.parts("twelve")
    sets = [
        ("twelve", "gentle, simulated ground", [d for d in twelve if d not in REAL_GROUND]),
        ("twelve", "gentle, real ground (a beach)", [d for d in twelve if d in REAL_GROUND]),
        ("rough", "rough: IMU vibration, slip on half of the path", f.parts("rough")),
        ("pairs", "two antennas, rough, slip on most of the path", f.parts("pairs")),
    ]
    for bench, name, drives in sets:
        rows = [f"{drive}/{ALL}" for drive in drives]
        if rows:
            means = [f.mean(bench, rows, key) for key in ("dead_m", "causal_m", "smoothed_m")]
            lines.append([f"{name} ({len(rows)} drives)", *map(metres, means)])
    causal, smoothed = ratios(f, "over"), ratios(f, "smoothed_over")
    if causal and smoothed:
        live, after = (f"{geometric_mean(v):.2f} ({max(v):.2f})" for v in (causal, smoothed))
        none = len(f.all("robots", (f"{name}/failed" for name in f.parts("robots"))))
        count = f"{len(causal)} recordings" + (f", {none} more without a pose" if none else "")
        name = f"real robots without radar ({count}), over dead reckoning (worst)"
        lines.append([name, 1, live, after])
    return table(["drives", "dead reckoning", "live", "afterwards"], lines)


def drives(f: Figures) -> str:
    """Each rough drive and each scene of the gentle ones."""
    lines: list[Row] = []

    def line(name: str, bench: str, some: Sequence[str]) -> None:
        cells = [metres(f.mean(bench, [f"{d}/{ALL}" for d in some], "dead_m"))]
        for method in METHODS:
            rows = [f"{d}/{method}" for d in some]
            means = [metres(f.mean(bench, rows, key)) for key in ("causal_m", "smoothed_m")]
            cells.append(", ".join(means))
        for key in ("nees_odom", "nees_map"):
            cells.append(plain(f.mean(bench, [f"{d}/{ALL}" for d in some], key)))
        lines.append([name, *cells])

    twelve = f.parts("twelve")
    scenes = ("gentle: garage", "gentle: basement", "gentle: floor", "gentle: beach")
    for i, name in enumerate(scenes if len(twelve) == 12 else ()):
        line(name, "twelve", twelve[3 * i : 3 * i + 3])
    for bench, name in (("twelve", "gentle"), ("rough", "rough"), ("pairs", "two antennas")):
        some = f.parts(bench)
        for drive in some if bench != "twelve" else ():
            line(drive, bench, [drive])
        if some:
            line(f"**mean, {name}**", bench, some)
    header = ["drive", "dead reckoning", *(f"`{m}`: live, afterwards" for m in METHODS)]
    return table([*header, "NEES odom", "NEES map"], lines) if lines else ""


def robots(f: Figures) -> str:
    """Each recording, and its variations."""
    lines: list[Row] = []
    for name in f.parts("robots"):

        def get(key: str, name: str = name) -> float | None:
            return f.of("robots", f"{name}/{key}")

        if get("over") is not None:
            values = [metres(get(key)) for key in ("wheel_m", "causal_m", "smoothed_m")]
            values += [plain(get(key)) for key in ("over", "smoothed_over", "nees_xy")]
        elif get("distance_m") is not None:
            keys = ("wheel_distance_m", "causal_distance_m")
            values = [f"{plain(get(key), 1)} of {plain(get('distance_m'), 1)} m" for key in keys]
            values += [""] * 4
        else:
            values = ["no pose", *[""] * 5]
        lines.append([name, *values, *varied(f, name)])
    header = ["recording", "`wheel`", "`imu_wheel`", "smoothed", "over `wheel`", "smoothed over"]
    header += ["NEES x,y", "varied: at most 1.5", "worst"]
    return table(header, lines) if lines else ""


def varied(f: Figures, name: str) -> tuple[str, str]:
    """How many variations of a recording are over 1.5 of `wheel`, and which one is worst."""
    kinds = f.parts("variations", 1)
    found = {kind: f.of("variations", f"{name}/{kind}/over") for kind in kinds}
    over = {kind: value for kind, value in found.items() if value is not None}
    if not over:
        return "", ""
    worst = max(over, key=lambda kind: over[kind])
    within = sum(value <= 1.5 for value in over.values())
    none = len(f.all("variations", (f"{name}/{kind}/failed" for kind in kinds)))
    started = f", {none} without a pose" if none else ""
    return f"{within} of {len(over)}{started}", f"{over[worst]:.2f} ({worst})"


def slip_kinds(f: Figures) -> str:
    """Over dead reckoning, by kind."""
    names = f.parts("slip_kinds", 2)
    lines: list[Row] = []
    for i, kind in enumerate(LASTING):
        some = [name for name in names if int(name.split("-")[0]) % len(LASTING) == i]
        dead = f.all("slip_kinds", (f"wheel/causal/{name}/ate_rmse_m" for name in some))
        if not dead:
            continue
        cells: list[object] = [f"{kind} ({len(dead)})", metres(fmean(dead))]
        for way in [*(f"{m}/causal" for m in METHODS), f"{ALL}/smoothed"]:
            errors = f.all("slip_kinds", (f"{way}/{name}/ate_rmse_m" for name in some))
            cells.append(plain(sum(errors) / sum(dead)))
        nees = f.all("slip_kinds", (f"{ALL}/causal/{name}/nees_xy" for name in some))
        lines.append([*cells, f"{fmean(nees):.1f} ({max(nees):.1f})"])
    header = ["slip (drives)", "dead reckoning (m)", *(f"`{m}`, over it" for m in METHODS)]
    return table([*header, "smoothed", "NEES (worst)"], lines) if lines else ""


def methods(f: Figures) -> str:
    """Mean over the twelve."""
    lines: list[Row] = []
    for method in f.parts("methods"):
        if method.endswith("_signed"):
            continue
        cells = [
            metres(
                f.mean(
                    "methods", [f"{method}/{mode}/{s}" for s in f.parts("methods", 2)], "ate_rmse_m"
                )
            )
            for mode in ("causal", "smoothed")
        ]
        rows = [f"{method}/causal/{s}" for s in f.parts("methods", 2)]
        lines.append([f"`{method}`", *cells, plain(f.mean("methods", rows, "nees_xy"), 1)])
    return table(["method", "live", "afterwards", "NEES x,y"], lines) if lines else ""


def faults(f: Figures) -> str:
    """Those that cost most, and whether anything was wrong."""
    drives, names = f.parts("faults"), f.parts("faults", 1)
    known: list[tuple[float, str]] = []
    for name in names:
        ratio = f.mean("faults", [f"{drive}/{name}" for drive in drives], "error_ratio")
        if ratio is not None:
            known.append((ratio, name))
    rows: list[Row] = []
    for ratio, name in sorted(known, reverse=True)[:MOST_FAULTS]:
        each = [f"{drive}/{name}" for drive in drives]
        worst, silent = (f.greatest("faults", each, key) for key in ("error_ratio", "silent_s"))
        rows.append([name, plain(ratio), plain(worst), plain(silent, 1)])
    if not rows:
        return ""
    wrong = sum(f.all("faults", (f"{drive}/{name}/wrong" for drive in drives for name in names)))
    below = sum(ratio < 1.1 for ratio, _ in known)
    text = (
        f"Of {len(known)} faults on {len(drives)} drives {below} cost less than 10 %; those "
        "that cost most are below. Ended programs, poses that are not finite or go back in time, "
        f"and faults of which `STATUS` is silent: {wrong:.0f}.\n\n"
    )
    return text + table(["fault", "error over clean", "worst", "longest silence (s)"], rows)


def anchors(f: Figures) -> str:
    """What fixes give between them, and what faults of a receiver cost."""
    between: list[Row] = []
    against: list[Row] = []
    for name in f.parts("anchors"):
        for kind in f.parts("anchors", 1):
            row = f"{name}/{kind}"
            ratio, over = f.of("anchors", f"{row}/smoothed_ratio"), f"{row}/smoothed_over"
            if ratio is not None:
                keys = ("smoothed_without_m", "smoothed_m", "smoothed_placed_m", "smoothed_site_m")
                cells = [metres(f.of("anchors", f"{row}/{key}")) for key in keys]
                placed = plain(f.of("anchors", f"{row}/smoothed_site_ratio"))
                between.append([name, kind, *cells[:2], plain(ratio), *cells[2:], placed])
            if (smoothed := f.of("anchors", over)) is not None:
                causal, after = (f.of("anchors", f"{row}/{k}") for k in ("causal_over", "after_s"))
                against.append([name, kind, plain(smoothed), plain(causal), plain(after, 0)])
    if not between:
        return ""
    header = [
        "recording",
        "fixes",
        "shape, without",
        "with",
        "over",
        "placed, without",
        "with",
        "over",
    ]
    heads = ["recording", "fault", "afterwards", "live", "named after (s)"]
    days = [f"days/{kind}" for kind in f.parts("anchors", 1)]
    joined = f.all("anchors", (f"{day}/joined" for day in days))
    text = table(header, between) + "\n\n" + table(heads, against)
    if joined:
        off = f.mean("anchors", days, "error_m")
        text += (
            "\n\nMaps of two days on different ground, tied to one datum: joined "
            f"{sum(joined):.0f} of {len(joined)}" + (f", error {metres(off)} m." if off else ".")
        )
    return text


def speed(f: Figures) -> str:
    """Times, on the machine of the run."""
    lines: list[Row] = []
    for log in f.parts("replay_speed"):
        cases = f.parts("replay_speed", 1)
        times = [whole(f.of("replay_speed", f"{log}/{c}/times_real_time_cpu")) for c in cases]
        lines.append(
            [f"replay of {log}: {'; '.join(cases)}", f"{'; '.join(times)} times real time"]
        )
    for log in f.parts("window_solvers"):
        keys = ("ceres_x", "chain_x")
        times = [whole(f.of("window_solvers", f"{log}/{key}")) for key in keys]
        apart = f.of("window_solvers", f"{log}/max_m")
        answer = f"{times[0]} and {times[1]} times real time; {apart:.0e} m"
        lines.append([f"{log} by Ceres and by the chain; apart by", answer])
    for job, name in (("idle", "nothing beside it"), ("busy", "two busy processes beside it")):
        keys = ("latency.imu.p50_ms", "latency.imu.p99_ms", "core_percent", "memory_mb")
        values = [f.of("live", f"{job}/{key}") for key in keys]
        if None not in values:
            p50, p99, core, memory = (plain(value) for value in values)
            answer = f"{p50} ms; {p99} ms; {core} % of a core; {memory} MB"
            lines.append([f"daemon live, {name}: IMU to pose, median; p99; load; memory", answer])
    labels = [label for label in f.parts("smoothers") if f.of("smoothers", f"{label}/median_ms")]
    if labels:
        times = [plain(f.of("smoothers", f"{label}/median_ms")) for label in labels]
        errors = [metres(f.of("smoothers", f"{label}/error_m")) for label in labels]
        both = (f"{time} ms, {error} m" for time, error in zip(times, errors, strict=True))
        what = f"an update, median, and error: {'; '.join(labels)}"
        lines.append([what, "; ".join(both)])
    return table(["what", "measured"], lines) if lines else ""
