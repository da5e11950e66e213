#!/usr/bin/env python3
"""The pages of `gprodom report` for three drives: valid, whole, and pictures of them to look at.

The drives are a recording of a real robot, a rough drive with revisits, and a drive that begins
with the map of another day; DATA is the folder of the shared data. Of each, DIR gets the page,
what Chromium shows of it at each width, light and dark, and what it prints. Printed are errors of
the HTML, what is cut at any width, lines of the browser's console, the least contrast of a text
(WCAG AA asks for 4.5) and the sheets of A4 (at most four). Exit code 1 where a page fails. Without
Chromium (package chromium) only the HTML is judged.

    bench/report_pages.py DATA [-o DIR] [--only robot] [--json]
"""

from __future__ import annotations

import shutil
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import justhtml

from estimates import mount_in, mounting_setting
from gprodom.files import temporary_folder
from gprodom.odometry.replay import run_replay
from recordings import convert, recordings_of
from zips import log_of

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "test" / "python"))
import browser

from program import command, exit_with, parser_of, print_figures, table_of, told_wrong

WIDTHS = (360, 768, 1920)
LEAST_CONTRAST, MOST_SHEETS = 4.5, 4
ROBOT = "phil1"
ROUGH = "rough/1720005000-0-nsh_b-cmu-gpr.zip"
DAYS = ("cmu_like/1700005000-0-nsh_b-cmu-gpr.zip", "cmu_like/1700006000-0-nsh_b-cmu-gpr.zip")


def robot(data: Path, folder: Path) -> tuple[Path, Path]:
    """Output and input of a replay of a real robot's recording."""
    sensors, out = folder / "robot.lcmlog", folder / "robot.out.lcmlog"
    recording = recordings_of(data / "robots")[ROBOT]
    convert(recording, data / "robots", sensors)
    run_replay(sensors, out, overrides=(mounting_setting(mount_in(sensors)), *recording.settings))
    return out, sensors


def rough(data: Path, folder: Path) -> tuple[Path, Path]:
    """Of a rough drive."""
    sensors, out = log_of(data / ROUGH, folder), folder / "rough.out.lcmlog"
    run_replay(sensors, out)
    return out, sensors


def another_day(data: Path, folder: Path) -> tuple[Path, Path]:
    """Of a drive that begins with the map of another."""
    state = folder / "state"
    state.mkdir()
    out = folder / "day.out.lcmlog"
    for drive, more in zip(DAYS, ((), ("state.map=read_only",)), strict=True):
        sensors = log_of(data / drive, folder)
        run_replay(sensors, out, overrides=(f"state.directory={state}", *more))
    return out, sensors


DRIVES: dict[str, Callable[[Path, Path], tuple[Path, Path]]] = {
    "robot": robot,
    "rough": rough,
    "another_day": another_day,
}


def judge(page: Path, folder: Path) -> tuple[dict[str, Any], list[str]]:
    """Its figures, and what is wrong with it; pictures of it are put beside it."""
    document = justhtml.JustHTML(page.read_text(), collect_errors=True, sanitize=False)
    errors = [str(each) for each in document.errors]
    figures: dict[str, Any] = {"errors": len(errors), "kB": page.stat().st_size / 1000}
    if browser.program() is None:
        print("report_pages: nothing is shown: Chromium is not installed", file=sys.stderr)
        return figures, errors
    cut: list[str] = []
    said: list[str] = []
    contrast = float("inf")
    for scheme in browser.SCHEMES:
        shown = browser.show(page, list(WIDTHS), scheme, folder)
        said += shown.console
        for frame in shown.frames:
            cut += [f"{frame['width']} px: cut: {each}" for each in frame["cut"]]
            contrast = min(contrast, frame["contrast"])
            height = frame["height"] + frame["width"] // 4  # without the scroll bar all is larger
            shot = browser.picture(page, frame["width"], height, scheme, folder)
            shot.save(page.with_name(f"{page.stem}-{frame['width']}-{scheme}.png"))
    sheets = browser.printed_pages(page, folder)
    shutil.move(folder / "paper.pdf", page.with_suffix(".pdf"))
    wrong = [*errors, *cut, *said]
    if contrast < LEAST_CONTRAST:
        wrong.append(f"contrast {contrast:.1f}")
    if sheets > MOST_SHEETS:
        wrong.append(f"{sheets} sheets")
    counts = {"cut": len(cut), "console": len(said), "contrast": contrast, "sheets": sheets}
    return figures | counts, wrong


def main() -> int:
    """Runs the command line."""
    parser = parser_of(__doc__)
    parser.add_argument("data", metavar="DATA", type=Path)
    parser.add_argument("-o", "--output", metavar="DIR", type=Path, help="pages and pictures")
    parser.add_argument("--only", action="append", choices=sorted(DRIVES))
    args = parser.parse_args()
    found: dict[str, dict[str, Any]] = {}
    wrong: list[str] = []
    for name in args.only or DRIVES:
        with temporary_folder() as folder:
            output = args.output or folder / "pages"
            output.mkdir(parents=True, exist_ok=True)
            out, sensors = DRIVES[name](args.data, folder)
            page = output / f"{name}.html"
            command("report", out, "--sensors", sensors, "-o", page)
            found[name], told = judge(page, folder)
            wrong += [f"{name}: {each}" for each in told]
    print_figures(args, found, table_of([{"drive": name, **row} for name, row in found.items()]))
    return told_wrong(wrong)


if __name__ == "__main__":
    exit_with(main)
