"""docs/results.md and the table of README.md say what the figures in bench/figures say."""

from figures import Figure, Measured, Report, read_reports
from layout import Figures
from page import BEGIN, END, page, with_table
from tables import head

from conftest import CHECKOUT

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


# Measured for themselves: their figures are nowhere on the page.
APART = {"commission", "doctor", "kernels", "lateral", "realism", "report_pages", "salient"}
APART |= {"sample", "triggers", "view_load"}


def test_all_other_benches_are_on_the_page() -> None:
    reports = read_reports(FIGURES)
    whole = tables_of(reports)
    for name in reports:
        rest = {other: each for other, each in reports.items() if other != name}
        assert (tables_of(rest) == whole) == (name in APART), name


def tables_of(reports: dict[str, Report]) -> str:
    """The page below its first words, which count the jobs."""
    return page(reports).partition("## What matters")[2]


def test_a_page_without_measurements_has_no_empty_tables() -> None:
    assert page({}).count("\n## ") == 1
    assert with_table(f"{BEGIN} gone {END}", {}).startswith(BEGIN)
