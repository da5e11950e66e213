"""The tables of docs/results.md; empty where nothing of one was measured."""

from __future__ import annotations

from collections.abc import Sequence
from statistics import geometric_mean

from layout import Figures, Row, metres, plain, table, whole

REAL_GROUND = ("1700010000", "1700011000", "1700012000")  # of the twelve: the beach
ALL = "gprodom_full"
METHODS = ("imu_wheel", "gprodom", ALL)


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


def methods(f: Figures) -> str:
    """Mean over the twelve, a column a method."""
    names = [name for name in f.parts("methods") if not name.endswith("_signed")]
    drives = f.parts("methods", 2)

    def line(title: str, mode: str, key: str, digits: int) -> Row:
        rows = ([f"{name}/{mode}/{drive}" for drive in drives] for name in names)
        return [title, *(plain(f.mean("methods", each, key), digits) for each in rows)]

    lines = [
        line("live", "causal", "ate_rmse_m", 3),
        line("afterwards", "smoothed", "ate_rmse_m", 3),
        line("NEES x,y", "causal", "nees_xy", 1),
    ]
    return table(["", *(f"`{name}`" for name in names)], lines) if names else ""


def pair_distance(f: Figures) -> str:
    """Error and its limit, a column a case."""
    cases = f.parts("pair_distance", 1)
    lines: list[Row] = []
    for ground in f.parts("pair_distance"):
        cells = []
        for case in cases:
            row = f"{ground}/{case}"
            error, limit = (f.of("pair_distance", f"{row}/{k}_percent") for k in ("rms", "limit"))
            cells.append(f"{plain(error)} ({plain(limit)})")
        lines.append([ground, *cells])
    return table(["ground", *cases], lines) if lines else ""


def anchors(f: Figures) -> str:
    """What fixes give between them, and what faults of a receiver cost."""
    names, kinds = f.parts("anchors"), f.parts("anchors", 1)
    keys = ("smoothed_without_m", "smoothed_m", "smoothed_placed_m", "smoothed_site_m")
    between: list[Row] = []
    for row in (f"{name}/{kind}" for name in names for kind in kinds):
        ratio = f.of("anchors", f"{row}/smoothed_ratio")
        if ratio is not None:
            cells = [metres(f.of("anchors", f"{row}/{key}")) for key in keys]
            placed = plain(f.of("anchors", f"{row}/smoothed_site_ratio"))
            body = metres(f.of("anchors", f"{row}/smoothed_body_m"))
            between.append([*row.split("/"), *cells[:2], plain(ratio), body, *cells[2:], placed])
    if not between:
        return ""
    shape, placed = (["without", "with", "over"] for _ in range(2))
    shape[0], placed[0] = "shape, without", "placed, without"
    text = table(["recording", "fixes", *shape, "body", *placed], between)
    return text + "\n\n" + receiver_faults(f, names, kinds)


def receiver_faults(f: Figures, names: Sequence[str], kinds: Sequence[str]) -> str:
    """A row a fault, three columns a recording."""
    keys = ("smoothed_over", "causal_over", "after_s")
    against = [n for n in names if f.all("anchors", (f"{n}/{k}/{keys[0]}" for k in kinds))]
    lines: list[Row] = []
    for kind in kinds:
        cells = [[f.of("anchors", f"{name}/{kind}/{key}") for key in keys] for name in against]
        if any(each[0] is not None for each in cells):
            texts = ((plain(after), plain(live), whole(told)) for after, live, told in cells)
            lines.append([kind, *(cell for each in texts for cell in each)])
    header = (h for n in against for h in (f"{n}: afterwards", "live", "named after (s)"))
    return table(["fault", *header], lines)
