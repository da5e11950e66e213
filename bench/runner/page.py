"""docs/results.md, and the table in README.md, of the figures that were measured."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping

from layout import Figures
from questions import questions
from tables import anchors, drives, head, methods, pair_distance, robots

from figures import Report

BEGIN, END = "<!-- figures: written by bench/run -->", "<!-- end of figures -->"
SECTIONS: tuple[tuple[str, str, Callable[[Figures], str]], ...] = (
    (
        "Drives",
        "`bench/run twelve rough pairs`. RMSE of position (m), SE(2)-aligned, all three without a "
        "setting of their own. NEES of x and y is that of `gprodom_full`: 2 is right.",
        drives,
    ),
    (
        "Real robots",
        "`bench/run robots variations`. No radar; the only setting is the mounting that `gprodom "
        'calibrate mount` finds. "Over" is (error + 15 mm) over that of `wheel`. Of two recordings '
        "the truth tells the distance alone. Sources and errors of the truth: "
        "`bench/recordings.py`. Varied are rates, delays, biases, mounting, encoder, losses, part "
        "of the drive.",
        robots,
    ),
    (
        "Distance by two antennas alone",
        "`bench/run pair_distance`. RMS error over 50 m, %, and in brackets its limit; at the "
        "centre 0.3 m apart, 1 cm aside, 20 dB, 0.4 m/s, 20 traces/s.",
        pair_distance,
    ),
    ("What else", "`bench/run NAME` with the bench of the row.", questions),
    (
        "The paper's method and what it is compared with",
        "`bench/run methods`. Mean RMSE (m) over the twelve gentle drives; `_signed` rows fuse the "
        "displacement with its sign. K is fitted on the other sequences of a scene.",
        methods,
    ),
    (
        "Positions from outside",
        "`bench/run anchors`. Fixes in the first and last tenth of the path (of the Husky: its "
        "own, a minute withheld); error in between of the smoothed solution, m: of the shape, "
        "aligned by itself, and placed by the fixes. The truth is of an antenna: with fixes, that "
        "of the one found (`body`: of the body, as without). Then each fault of a receiver in "
        "the middle of a drive with fixes of 3 cm: error from its begin on over that without "
        "fixes, and when `STATUS` named it.",
        anchors,
    ),
)


def page(reports: Mapping[str, Report]) -> str:
    """docs/results.md."""
    f = Figures(reports)
    jobs = [job for report in reports.values() for job in report.jobs]
    told = [
        ", ".join(dict.fromkeys(sorted(getattr(job, key) for job in jobs)))
        for key in ("date", "commit", "machine")
    ]
    minutes = sum(job.seconds for job in jobs) / 60
    failed = [f"{name}/{job}" for name, report in reports.items() for job in report.failed]
    source = (
        "Written by `bench/run --publish` from the JSON files in `bench/figures/`; [how, and how "
        "to compare two commits](benchmark.md#everything-that-is-measured). What the figures are: "
        "[scoring](scoring.md). What was tried and not kept: [lessons](lessons.md). "
        f"Measured {told[0]} with {told[1]} on {told[2]}: {len(jobs)} jobs, {minutes:.0f} minutes "
        f"of one core. {f'Failed: {chr(44).join(failed)}.' if failed else 'No job failed.'} "
        "**Nothing is measured yet on the real CMU-GPR dataset**, nor on a real robot with a radar."
    )
    meaning = (
        "Position error (RMSE, m). *Live* is the pose as published, *afterwards* the solution over "
        "all data; dead reckoning is wheel distance and gyro heading. Motion, IMU and wheel of the "
        "drives are simulated; their ground is simulated, or made of recorded radar lines."
    )
    text = f"# Results\n\n{source}\n\n## What matters to a user\n\n{meaning}\n\n{head(f)}\n"
    for title, how, section in SECTIONS:
        content = section(f)
        if content:
            text += f"\n## {title}\n\n{how}\n\n{content}\n"
    return text


def with_table(readme: str, reports: Mapping[str, Report]) -> str:
    """README.md with the present table between its two marks."""
    pattern = re.compile(f"{re.escape(BEGIN)}.*?{re.escape(END)}", re.S)
    made, count = pattern.subn(f"{BEGIN}\n{head(Figures(reports))}\n{END}", readme)
    if count != 1:
        raise ValueError(f"README.md: expected one place between {BEGIN} and {END}")
    return made
