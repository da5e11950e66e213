"""The figures at the head of docs/results.md and in the README are those of the tables below."""

from __future__ import annotations

import re

from conftest import CHECKOUT

RESULTS = (CHECKOUT / "docs" / "results.md").read_text()
HEAD, REST = RESULTS.split("## About the figures", 1)
README = (CHECKOUT / "README.md").read_text()


def row(text: str, start: str) -> list[str]:
    """The cells of the one row of a table that begins so."""
    rows = re.findall(rf"^\| (?:\*\*)?{re.escape(start)}.*$", text, re.M)
    assert len(rows) == 1, f"{start}: {len(rows)} rows"
    return [cell.strip() for cell in rows[0].strip("|").split("|")]


def section(title: str) -> str:
    """A section of the results, from its heading on."""
    return REST.split(f"## {title}\n", 1)[1].split("\n## ", 1)[0]


def test_rough_drives() -> None:
    table = section("Drives on which the wheel slips gradually")
    mean = row(table, "mean |")[1:4]
    assert row(HEAD, "rough")[1:4] == mean, "the head of docs/results.md has other figures"
    assert row(README, "rough")[1:4] == mean, "README.md has other figures"
    worst = max(re.findall(r"^\| (1720\d+) ", table, re.M), key=lambda d: float(row(table, d)[2]))
    assert row(HEAD, "the worst of the rough nine")[1:4] == row(table, worst)[1:4]


def test_real_robots() -> None:
    table = section("Robots as they are")
    for start, short, name in (
        ("real robot**, car 1", "real robots without radar: car 1", "wid02"),
        ("real robot**, car 2", "car 2", "wid09"),
        ("real robot**, Warthog", "Warthog", "warthog_a"),
        ("real robot**, Husky", "Husky", "husky"),
    ):
        cells = row(table, name)  # recording, wheel, before, imu_wheel, smoothed
        measured = [cells[1], cells[3], cells[4]]
        assert row(HEAD, start)[1:4] == measured, f"{name}: the head has other figures"
        assert row(README, short)[1:4] == measured, f"{name}: README.md has other figures"


def test_gentle_drives() -> None:
    table = section("What revisits buy")
    for ground, start, short in (
        ("simulated", "gentle**, nine", "gentle: nine"),
        ("beach", "gentle**, three", "gentle: three"),
    ):
        cells = row(table, f"unknown | `gprodom_full` | {ground}")
        measured = [cells[3], cells[6]]  # SE(2), live and smoothed
        assert row(HEAD, start)[2:4] == measured
        assert row(README, short)[2:4] == measured
