"""docs/results.md and the table of README.md say what the figures in bench/figures say."""

from __future__ import annotations

import sys
from collections.abc import Iterable

from conftest import CHECKOUT

sys.path.append(str(CHECKOUT / "bench" / "runner"))

from anchoring import BETWEEN, FAULT
from figures import Figure, Measured, Report, read_reports
from layout import Figures
from page import BEGIN, END, page, with_table
from readers import DAY, FOUND, MAP, PAIR, PAIR_FAULT, REVISIT, START, VISIT
from tables import head

METHODS = ("imu_wheel", "gprodom", "gprodom_full")
SETS = {"twelve": 12, "rough": 9, "pairs": 6}
FIGURES = CHECKOUT / "bench" / "figures"
RESULTS = (CHECKOUT / "docs" / "results.md").read_text()
README = (CHECKOUT / "README.md").read_text()
ANEW = "write it anew with bench/run --publish NAME (of a bench that is measured already)"


def test_results_say_what_was_measured() -> None:
    assert page(read_reports(FIGURES)) == RESULTS, f"docs/results.md: {ANEW}"
    assert len(RESULTS.splitlines()) <= 150


def test_readme_says_what_was_measured() -> None:
    assert with_table(README, read_reports(FIGURES)) == README, f"README.md: {ANEW}"


def report(name: str, values: dict[str, float]) -> Report:
    """Of figures with these values."""
    figures = tuple(Figure(key, value, "m", "lower") for key, value in values.items())
    job = Measured("all", "command", "abc", "2026-01-01", "machine", 60.0, {}, "key", figures)
    return Report(name, name, (job,), {})


def test_a_figure_that_changes_changes_the_page() -> None:
    """A mean, a geometric mean and its worst, by hand."""
    drives = {f"{d}/gprodom_full/dead_m": float(d) for d in (1, 3)}
    drives |= {f"{d}/gprodom_full/causal_m": 0.5 * d for d in (1, 3)}
    drives |= {f"{d}/gprodom_full/smoothed_m": 0.25 for d in (1, 3)}
    over = {"a/over": 2.0, "b/over": 0.5, "b (pair)/over": 9.0}
    over |= {"a/smoothed_over": 4.0, "b/smoothed_over": 1.0}
    table = head(Figures({"rough": report("rough", drives), "robots": report("robots", over)}))
    rough, robots = table.splitlines()[2:]
    assert rough.endswith("(2 drives) | 2.000 | 1.000 | 0.250 |")
    assert robots.endswith("| 1 | 1.00 (2.00) | 2.00 (4.00) |")


def rows_of(rows: Iterable[str], *keys: str) -> list[str]:
    """Names of figures."""
    return [f"{row}/{key}" for row in rows for key in keys]


def test_all_that_is_measured_fits_on_the_page() -> None:
    """Every bench of the table, each with as many figures as it can give."""
    names: dict[str, list[str]] = {}
    keys = ("dead_m", "causal_m", "smoothed_m", "nees_odom", "nees_map")
    for bench, count in SETS.items():
        names[bench] = rows_of([f"{i}/{m}" for i in range(count) for m in METHODS], *keys)
    robots = [f"robot{i}" for i in range(14)]
    keys = ("wheel_m", "causal_m", "smoothed_m", "over", "smoothed_over", "nees_xy")
    names["robots"] = rows_of(robots, *keys)
    names["variations"] = rows_of(
        [f"{robot}/kind{i}" for robot in robots for i in range(43)], "over"
    )
    ways = ("wheel/causal", *(f"{m}/causal" for m in METHODS), "gprodom_full/smoothed")
    kinds = [f"{way}/{i}-0-x" for way in ways for i in range(20)]
    names["slip_kinds"] = rows_of(kinds, "ate_rmse_m", "nees_xy")
    names["methods"] = rows_of([f"method{i}/causal/1-0-x" for i in range(8)], "ate_rmse_m")
    names["faults"] = rows_of([f"1/fault{i}" for i in range(87)], "error_ratio")
    names["pair_distance"] = rows_of([f"{g}/case{i}" for g in "abc" for i in range(11)], *PAIR)
    names["pair_faults"] = rows_of(["rebar/none/gprodom", "beach/none/gprodom"], *PAIR_FAULT)
    between = rows_of([f"{n}/{k} m" for n in "abc" for k in (1, 3)] + ["husky/own"], *BETWEEN)
    receiver = rows_of([f"{n}/fault{i}" for n in "ab" for i in range(9)], *FAULT)
    names["anchors"] = between + receiver + ["days/1/joined"]
    names["mid_drive"] = rows_of(["1/30 s"], *START)
    cut = [f"{how}, {use}_m" for how in ("missing", "stuck") for use in ("never", "contradicted")]
    names["wheel_fails"] = rows_of("1", *cut)
    names["immobilised"] = ["in_time", "cases", "false_alarms", "km"]
    names["motion"] = rows_of("1", "prompt", "episodes", "standing_recall", "standing_false")
    names["coverage"] = [*MAP]
    names["consistency"] = rows_of(["car, floor", "cart, floor"], "nees_xy")
    names["revisits"] = rows_of(["1/free/gprodom_full", "1/true/gprodom_full"], *FOUND)
    names["relocation"] = [*VISIT]
    names["changed_ground"] = rows_of(["0 %", "10 %"], *VISIT)
    names["another_day"] = rows_of(["beach", "field"], *VISIT)
    names["days"] = rows_of(["same", "strangers"], "located", "drives") + rows_of(["same/1"], *DAY)
    names["merge"] = rows_of(["0 %"], "proven", "runs", "before_m", "after_m")
    names["revisit_along"] = rows_of(["all"], *REVISIT)
    names["radar_time_offset"] = rows_of(["rays/0 ms"], "rms_s")
    names["fdtd"] = ["pipe_ns"]
    names["hostile_packets"] = ["packets", "wrong"]
    names["process_faults"] = ["faults", "wrong", "killed/pose_after_s"]
    names["replay_speed"] = rows_of(["1/a", "1/b", "2/a", "2/b"], "times_real_time_cpu")
    names["window_solvers"] = rows_of("12", "ceres_x", "chain_x", "max_m")
    live = ("latency.imu.p50_ms", "latency.imu.p99_ms", "core_percent", "memory_mb")
    names["live"] = rows_of(["idle", "busy"], *live)
    names["smoothers"] = rows_of(["a", "b"], "median_ms", "p99_ms", "error_m")
    reports = {name: report(name, dict.fromkeys(rows, 1.0)) for name, rows in names.items()}
    assert len(page(reports).splitlines()) <= 150
    for name in reports:
        rest = {other: each for other, each in reports.items() if other != name}
        assert tables_of(rest) != tables_of(reports), f"{name} is nowhere on the page"


def tables_of(reports: dict[str, Report]) -> str:
    """The page below its first words, which count the jobs."""
    return page(reports).partition("## What matters")[2]


def test_a_page_without_measurements_has_no_empty_tables() -> None:
    text = page({})
    assert text.count("\n## ") == 1
    assert with_table(f"{BEGIN} gone {END}", {}).startswith(BEGIN)
