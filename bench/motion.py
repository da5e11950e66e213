#!/usr/bin/env python3
"""Standstill, slip and coherence against the truth beside each sequence, by replay.

Each SEQUENCE needs `.json` (slip episodes: start s, duration s, wheel factor) and `.truth.npz`
(t, s along the track, v) beside it; the estimator sees neither. Columns:

    standing       recall: share of standstill (true speed below 5 mm/s for 1 s or more, 0.2 s at
                   its edges left out) that the radar claims, over traces with a radar signal: a
                   dead antenna is never claimed to stand
    flagged        the same of the published flag, which is causal and so late by its delay
    false          radar claims at 5 mm/s or more, over all such time
    unseen         the farthest that the antenna moved within a claim
    slip           episodes (overlapping ones joined) flagged within 0.5 s of their start
    false/100m     flags more than 0.5 s from any episode, per 100 m
    coherence      RMS relative error of its distances over a span, where the truth is 0.1 m or more
    in 2 sigma     share of them within twice the standard deviation told
    gprodom        RMSE of position, SE(2)-aligned, m; over dead reckoning; over imu_wheel

With --cut the wheel fails in mid-run, for so many seconds: its messages stop (missing), or its
count stands still (stuck). Columns: RMSE without and with the coherence, m.

    bench/motion.py ../shared/data/cmu_like/*.zip
    bench/motion.py --cut 10 ../shared/data/cmu_like/*.zip
"""

from __future__ import annotations

import sys
import tempfile
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import numpy as np

from gprodom import canvas
from gprodom.benchmark.motion import Outcome, measure, read_beside, rmse
from gprodom.console import format_table
from gprodom.convert.cmu import Recording, read_recording
from gprodom.convert.streams import streams
from gprodom.lcm.log_writer import write_log
from gprodom.odometry.estimate import estimate
from gprodom.odometry.methods import find_method
from gprodom.score.sources import read_truth
from program import one_by_one, parser_of, print_figures


@dataclass(frozen=True)
class CutOutcome:
    """RMSE (m) of one sequence whose wheel fails, by how it fails and what is used."""

    sequence: str
    rmse: dict[str, float]


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


def measure_cut(sequence: Path, seconds: float, overrides: list[str], folder: Path) -> CutOutcome:
    """Replays a sequence whose wheel fails, with and without the coherence."""
    _, interval = read_beside(sequence)
    recording = read_recording(sequence)
    method = find_method("gprodom")
    log, output = folder / "in.lcmlog", folder / "out.lcmlog"
    errors = {}
    for how in ("missing", "stuck"):
        write_log(log, streams(fail_wheel(recording, how, seconds), interval))
        total_station = read_truth(log).trajectory
        for use in ("never", "contradicted"):
            settings = [*overrides, f"gpr.coherence.use={use}"]
            trajectory = estimate(log, method, (), settings, output).trajectory
            errors[f"{how}, {use}"] = rmse(trajectory, total_station)
    return CutOutcome(sequence.stem, errors)


def table(outcomes: list[Outcome]) -> str:
    """The figures, one sequence a line, and of all together."""
    heads = ["sequence", "standing", "flagged", "false", "unseen mm", "slip", "false/100m"]
    heads += ["coherence", "in 2 sigma", "gprodom", "/ reckoning", "/ imu_wheel"]
    rows = []
    for o in outcomes:
        rows.append([o.sequence, f"{100 * o.standing.recall:.1f} %"])
        rows[-1] += [f"{100 * o.standing.flagged:.1f} %", f"{100 * o.standing.false:.2f} %"]
        rows[-1] += [f"{o.standing.unseen_mm:.1f}", f"{o.prompt} of {o.episodes}"]
        rows[-1] += [f"{100 * o.false_flags / o.metres:.2f}", f"{100 * o.coherence_error:.1f} %"]
        rows[-1] += [f"{100 * o.coherence_covered:.0f} %", f"{o.rmse['gprodom']:.3f}"]
        rows[-1] += [f"{o.rmse['gprodom'] / o.rmse[name]:.2f}" for name in ("wheel", "imu_wheel")]
    mean = {name: float(np.mean([o.rmse[name] for o in outcomes])) for name in outcomes[0].rmse}
    standing = [o.standing for o in outcomes]
    false = 100 * sum(o.false_flags for o in outcomes) / sum(o.metres for o in outcomes)
    rows.append(
        ["all", f"{100 * np.mean([s.recall for s in standing]):.1f} %"]
        + [f"{100 * np.mean([s.flagged for s in standing]):.1f} %"]
        + [f"{100 * np.mean([s.false for s in standing]):.2f} %"]
        + [f"{max(s.unseen_mm for s in standing):.1f}"]
        + [f"{sum(o.prompt for o in outcomes)} of {sum(o.episodes for o in outcomes)}"]
        + [f"{false:.2f}", f"{100 * np.nanmean([o.coherence_error for o in outcomes]):.1f} %"]
        + [f"{100 * np.nanmean([o.coherence_covered for o in outcomes]):.0f} %"]
        + [f"{mean['gprodom']:.3f}"]
        + [f"{mean['gprodom'] / mean[name]:.2f}" for name in ("wheel", "imu_wheel")]
    )
    return format_table(heads, rows)


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


def cut_table(outcomes: list[CutOutcome]) -> str:
    """RMSE of each sequence, and their mean."""
    names = list(outcomes[0].rmse)
    rows = [[o.sequence, *(f"{o.rmse[name]:.3f}" for name in names)] for o in outcomes]
    rows.append(["mean", *(f"{np.mean([o.rmse[name] for o in outcomes]):.3f}" for name in names)])
    return format_table(["sequence", *names], rows)


def main() -> int:
    """Command line."""
    parser = parser_of(__doc__, overrides=True)
    parser.add_argument("sequences", nargs="+", type=Path, metavar="SEQUENCE")
    parser.add_argument("--cut", type=float, metavar="SECONDS", help="for which the wheel fails")
    parser.add_argument("--plot", type=Path, metavar="PNG", help="coherence against the truth")
    arguments = parser.parse_args()
    outcomes: list[Outcome] = []
    cuts: list[CutOutcome] = []
    with tempfile.TemporaryDirectory() as folder:
        for sequence in one_by_one("replaying", arguments.sequences):
            if arguments.cut is None:
                outcomes.append(measure(sequence, arguments.overrides, Path(folder)))
            else:
                cuts.append(measure_cut(sequence, arguments.cut, arguments.overrides, Path(folder)))
    if arguments.plot is not None and outcomes:
        draw(outcomes, arguments.plot)
    figures = [asdict(outcome) for outcome in [*outcomes, *cuts]]
    print_figures(arguments, figures, table(outcomes) if outcomes else cut_table(cuts))
    return 0


if __name__ == "__main__":
    sys.exit(main())
