#!/usr/bin/env python3
"""Standstill, slip and coherence against the truth beside each sequence, by replay.

Each SEQUENCE needs `.json` (slip episodes: start s, duration s, wheel factor) and `.truth.npz`
(t, s along the track, v) beside it; the estimator sees neither. Columns:

    recall         share of standstill (true speed below 5 mm/s for 1 s or more, 0.2 s at its edges
                   left out) that the radar claims, over traces with a radar signal: a dead antenna
                   is never claimed to stand
    flagged        the same of the published flag, which is causal and so late by its delay
    false          radar claims at 5 mm/s or more, over all such time
    unseen_mm      the farthest that the antenna moved within a claim
    prompt         episodes (overlapping ones joined) flagged within 0.5 s of their start
    false_flags    more than 0.5 s from any episode
    coherence      RMS relative error of its distances over a span, where the truth is 0.1 m or
                   more; share of them within twice the standard deviation told
    wheel, ...     RMSE of position by each method, SE(2)-aligned, m

With --cut the wheel fails in mid-run, for so many seconds: its messages stop (missing), or its
count stands still (stuck). Columns: RMSE without and with the coherence, m.

    bench/motion.py ../shared/data/cmu_like/*.zip
    bench/motion.py --cut 10 ../shared/data/cmu_like/*.zip
"""

from __future__ import annotations

from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import numpy as np

from estimates import run_method
from gprodom import canvas
from gprodom.benchmark.motion import Outcome, measure, read_beside, rmse
from gprodom.convert.cmu import Recording, read_recording
from gprodom.convert.streams import streams
from gprodom.files import temporary_folder
from gprodom.lcm.log_writer import write_log
from gprodom.score.sources import read_truth
from program import exit_with, one_by_one, parser_of, print_figures, table_of

Row = dict[str, Any]


def fail_wheel(recording: Recording, how: str, seconds: float) -> Recording:
    """The recording with its wheel `missing` or `stuck` for so long in mid-run."""
    time = recording.wheel_utime
    start = (time[0] + time[-1]) // 2
    cut = (time >= start) & (time < start + round(seconds * 1e6))
    if how == "missing":
        return replace(recording, wheel_utime=time[~cut], ticks=recording.ticks[~cut])
    first, end = np.flatnonzero(cut)[[0, -1]]
    ticks = recording.ticks.copy()
    ticks[end + 1 :] -= ticks[end] - ticks[first]
    ticks[cut] = ticks[first]
    return replace(recording, ticks=ticks)


def measure_cut(sequence: Path, seconds: float, overrides: list[str], folder: Path) -> Row:
    """Replays a sequence whose wheel fails, with and without the coherence."""
    _, interval = read_beside(sequence)
    recording = read_recording(sequence)
    log, output = folder / "in.lcmlog", folder / "out.lcmlog"
    errors = {}
    for how in ("missing", "stuck"):
        write_log(log, streams(fail_wheel(recording, how, seconds), interval))
        total_station = read_truth(log).trajectory
        for use in ("never", "contradicted"):
            settings = [*overrides, f"gpr.coherence.use={use}"]
            made = run_method(log, "gprodom", output, settings)
            errors[f"{how}, {use}"] = rmse(made.trajectory, total_station)
    return {"sequence": sequence.stem, "rmse": errors}


def in_short(row: Row) -> Row:
    """A row for people: without the single spans."""
    flat = {key: value for key, value in row.items() if key not in ("standing", "rmse", "told")}
    return flat | row.get("standing", {}) | row["rmse"]


def draw(outcomes: list[Outcome], path: Path) -> None:
    """Coherence's distances against the true way, a panel for each scene and a colour for each of
    its sequences."""
    scenes: dict[str, list[Outcome]] = {}
    for outcome in outcomes:
        parts = outcome.sequence.split("-")
        scenes.setdefault(parts[2] if len(parts) > 2 else outcome.sequence, []).append(outcome)
    figure, panels = canvas.new_figure(
        1, len(scenes), width=3.0 * len(scenes), height=4.6, sharex=True, sharey=True
    )
    for panel, (scene, of_scene) in zip(panels, scenes.items(), strict=True):
        for i, outcome in enumerate(of_scene):
            moved, distance, sigma = np.array(outcome.told).reshape(-1, 3).T
            look = {"color": canvas.COLOURS[i % 7], "marker": canvas.MARKERS[i % 7]}
            name = f"{outcome.sequence.split('-')[0]}, ± σ"
            panel.errorbar(
                moved, distance, sigma, ls="", ms=2.5, lw=0.3, alpha=0.6, label=name, **look
            )
        panel.axline((0, 0), slope=1, color="black", lw=0.8, label="equal")
        panel.set_aspect("equal")
        error = np.mean([outcome.coherence_error for outcome in of_scene])
        panel.set_title(f"{scene}: error {100 * error:.0f} %", fontsize=9)
        panel.set_xlabel("true way over a span (m)", fontsize=8)
        canvas.legend_below(panel, 1, fontsize=7)
    panels[0].set(xlim=(0, 0.9), ylim=(0, 0.9))
    panels[0].set_ylabel("way by coherence (m)", fontsize=8)
    path.write_bytes(canvas.png(figure, dpi=80))


def main() -> None:
    """Command line."""
    parser = parser_of(__doc__, overrides=True)
    parser.add_argument("sequences", nargs="+", type=Path, metavar="SEQUENCE")
    parser.add_argument("--cut", type=float, metavar="SECONDS", help="for which the wheel fails")
    parser.add_argument("--plot", type=Path, metavar="PNG", help="coherence against the truth")
    arguments = parser.parse_args()
    outcomes: list[Outcome] = []
    rows: list[Row] = []
    with temporary_folder() as folder:
        for sequence in one_by_one("replaying", arguments.sequences):
            given = (arguments.overrides, folder)
            if arguments.cut is None:
                outcomes.append(measure(sequence, *given))
                rows.append(asdict(outcomes[-1]))
            else:
                rows.append(measure_cut(sequence, arguments.cut, *given))
    if arguments.plot is not None and outcomes:
        draw(outcomes, arguments.plot)
    print_figures(arguments, rows, table_of([in_short(row) for row in rows]))


if __name__ == "__main__":
    exit_with(main)
