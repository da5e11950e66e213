"""The benches of `gprodom view` and `gprodom report`."""

from __future__ import annotations

from job import Bench, Job

from figures import TIME_SPREAD, Unit, one_row, rows

VIEW = {
    "open_processor_s": Unit("s", "lower", TIME_SPREAD),
    "recording_mb": Unit("MB", "lower"),
    "live_to_file_core_pct": Unit("%", "lower", TIME_SPREAD),
    "live_to_viewer_core_pct": Unit("%", "lower", TIME_SPREAD),
}
# The drives of report_pages.py.
ROUGH = "1720005000-0-nsh_b-cmu-gpr.zip"
DAYS = ("1700005000-0-nsh_b-cmu-gpr.zip", "1700006000-0-nsh_b-cmu-gpr.zip")
PAGE = {
    "errors": Unit("", "lower"),
    "cut": Unit("", "lower"),
    "console": Unit("", "lower"),
    "contrast": Unit("", "higher"),
    "sheets": Unit("", "lower"),
}


def looking(basement: str) -> tuple[Bench, ...]:
    """Of a drive in a basement, and of the pages of three others."""
    drives = ("robots/phil1", f"rough/{ROUGH}", *(f"cmu_like/{day}" for day in DAYS))
    data = tuple(f"{{data}}/{each}" for each in drives)
    return (
        Bench(
            "view_load",
            "Looking at a drive of an hour, and at a running robot",
            "view_load.py",
            one_row(VIEW),
            (Job("all", (basement,), (basement,)),),
            alone=True,
            settable=False,
        ),
        Bench(
            "report_pages",
            "Pages of `gprodom report`, as Chromium shows and prints them",
            "report_pages.py",
            rows((), PAGE),
            (Job("all", ("{data}",), data, ("{data}", "--only=robot")),),
            settable=False,
        ),
    )
