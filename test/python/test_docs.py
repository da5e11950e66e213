"""The documentation: it builds without a broken link, and its tutorial runs."""

import os
import re
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest
from figures import Figure, Measured, Report, read_reports
from layout import Figures
from page import BEGIN, END, page, with_table
from tables import head

import gprodom
from conftest import CHECKOUT, colours_in, run_program

DOCS = CHECKOUT / "docs"


@pytest.mark.usefixtures("compiled")
def test_tutorial_runs(tmp_path: Path) -> None:
    """Its blocks in order: commands by a shell, Python in one interpreter."""
    blocks = re.findall(r"^```(\w+)\n(.*?)^```$", (DOCS / "tutorial.md").read_text(), re.M | re.S)
    assert {kind for kind, _ in blocks} == {"sh", "python"}
    command = tmp_path / "bin" / "gprodom"
    command.parent.mkdir()
    command.write_text(f'#!/bin/sh\nexec {sys.executable} -m gprodom "$@"\n')
    command.chmod(0o755)
    work = tmp_path / "work"
    work.mkdir()
    # One program: each shell block as a call, so that Python blocks see what came before.
    lines = ["import os, subprocess", f"os.chdir({str(work)!r})"]
    for kind, text in blocks:
        run = f"subprocess.run(['sh', '-ec', {text!r}], check=True)"
        lines.append(text if kind == "python" else run)
    paths = f"{command.parent}:{os.environ['PATH']}"
    scripts = str(Path(gprodom.__file__).resolve().parents[1])
    run_program(sys.executable, "-c", "\n".join(lines), PATH=paths, PYTHONPATH=scripts)
    for name in ("radar.png", "paths.png", "flags.png", "report/report.html", "many/report.html"):
        content = (work / name).read_bytes()
        assert not name.endswith(".png") or len(colours_in(content)) > 10


def test_documentation_builds(tmp_path: Path) -> None:
    if find_spec("mkdocs") is None:
        pytest.skip("MkDocs is not installed (the extra docs)")
    arguments = ["build", "--strict", "--quiet", "-f", str(CHECKOUT / "mkdocs.yml")]
    run_program(sys.executable, "-m", "mkdocs", *arguments, "-d", tmp_path / "site")
    pages = list((tmp_path / "site").rglob("*.html"))
    assert len(pages) > len(list(DOCS.glob("*.md")))
    outside = re.compile(r"""<(?:script|link|img)[^>]*(?:src|href)=["'](?:https?:)?//""")
    assert [page.name for page in pages if outside.search(page.read_text())] == []


# What code comments and README.md name of the documents is there (MkDocs checks the rest).


SOURCES = ("src", "include", "scripts", "bench", "test", "ros", "ros2", "examples")


def titles(document: str) -> list[str]:
    """Of headings and of paragraphs that begin in bold."""
    text = (DOCS / document).read_text()
    found = re.findall(r"^#+ (.*)$", text, re.M)
    return [*found, *re.findall(r"\*\*([^*]+?)\*\*", text)]


def test_sections_that_comments_name_are_there() -> None:
    listed = subprocess.run(
        ["git", "ls-files", *SOURCES], cwd=CHECKOUT, capture_output=True, text=True, check=True
    )
    named = []
    for name in listed.stdout.split():
        if not name.endswith((".h", ".cpp", ".py")):
            continue
        # A comment of several lines as one.
        text = re.sub(r"\n\s*(?://|#)\s?", " ", (CHECKOUT / name).read_text())
        for document, quoted in re.findall(r'docs/(\w+\.md), ((?:"[^"\n]+"(?: and |, )?)+)', text):
            assert (DOCS / document).is_file(), (name, document)
            named += [(name, document, title) for title in re.findall(r'"([^"]+)"', quoted)]
    assert len(named) > 20
    there = {document: titles(document) for _, document, _ in named}
    missing = [place for place in named if not any(place[2] in title for title in there[place[1]])]
    assert missing == []


def test_links_of_the_readme_lead_somewhere() -> None:
    links = re.findall(r"\]\(([^)#\s]*)(?:#([^)]*))?\)", (CHECKOUT / "README.md").read_text())
    links = [link for link in links if not link[0].startswith("http")]
    assert len(links) > 20
    for path, anchor in links:
        assert (CHECKOUT / path).exists(), path
        if anchor:
            headings = re.findall(r"^#+ (.*)$", (CHECKOUT / path).read_text(), re.M)
            slugs = {re.sub(r"[^\w\- ]", "", h).strip().lower().replace(" ", "-") for h in headings}
            assert anchor in slugs, (path, anchor)


# docs/results.md and the table of README.md say what the figures in bench/figures say.


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
