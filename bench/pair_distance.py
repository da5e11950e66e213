#!/usr/bin/env python3
"""Distance by two antennas in a row alone, over 50 m, beside what is possible.

Simulated drives on ground of FDTD, of real lines of a beach and of a field (docs/simulation.md):
antennas with faults of their own, 0.3 m apart, the rear one 1 cm aside, ground 20 dB above noise,
0.4 m/s, 20 traces a second; and one of these at a time another. The distance of the antennas is
exact, and the wheel true, so that only the passages are measured. A drive's error is that of the
sum of all passages' distances over that of the true ways between their times. Columns:

    passages       of a drive; three for the antennas' distance at most
    rms_percent    error of the distance, over drives; beside it the limit
    bias_percent   its mean
    match_mm       standard deviation of a passage; beside it the limit for 0.4 m of ground
    nees           mean of the passages' squared error over their variance
    wrong          by more than 3 sigma and 2 cm

The limit is that of Knapp and Carter (1976), of noise and of ground that differs beside the track
(docs/pair.md), from the ground without noise: all wave numbers along the track, frequencies, and
four parts of the depth.

    bench/pair_distance.py ../shared/data/real_ground [--drives 5] [--plot docs/pair.png] [--json]
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from gprodom import canvas
from gprodom.arrays import Floats
from gprodom.ground.survey import Survey
from gprodom.random_streams import stream
from gprodom.simulate.drive import Move
from pair_drives import (
    GROUNDS,
    antennas_in_a_row,
    drive,
    make_ground,
    passages,
    straight,
    strength,
    to_and_fro,
)
from program import exit_with, in_processes, parser_of, print_rows

WAY_M = 50.0
PATCH_M = 0.4  # of ground to a match
SEGMENT, PARTS = 64, 4  # columns, and parts of the depth, whose spectra are averaged


@dataclass(frozen=True)
class Case:
    """What is asked. b_m, aside_m: of the antennas."""

    name: str = "centre"
    b_m: float = 0.3
    aside_m: float = 0.01
    snr_db: float = 20.0
    speed: float = 0.4  # m/s
    rate: float = 20.0  # traces a second
    turns_back: bool = False


CASES = (
    Case(),
    Case("b 0.2 m", b_m=0.2),
    Case("b 0.5 m", b_m=0.5),
    Case("0 cm aside", aside_m=0.0),
    Case("3 cm aside", aside_m=0.03),
    Case("10 dB", snr_db=10.0),
    Case("0.1 m per s", speed=0.1),
    Case("1 m per s", speed=1.0),
    Case("50 traces per s", rate=50.0),
    Case("100 traces per s", rate=100.0),
    Case("stops, reversals", turns_back=True),
)


def information(survey: Survey, case: Case) -> float:
    """Of the ground under both antennas about an offset along the track, 1/m^2 for a metre."""
    spacing = case.speed / case.rate
    view = survey.decorrelating().turned_traces
    along = np.arange(0.0, survey.length, spacing)
    pictures = [view(along, np.full_like(along, y)) for y in (0.03, 0.03 + case.aside_m)]
    noise = strength(survey) * 10 ** (-case.snr_db / 20)
    window = np.hanning(SEGMENT)
    depth = pictures[0].shape[1] // PARTS
    starts = range(0, len(along) - SEGMENT + 1, SEGMENT // 2)

    def spectra(picture: Floats) -> Floats:
        cut = picture - picture.mean(axis=0)
        segments = [cut[at : at + SEGMENT, : PARTS * depth] for at in starts]
        parts = np.reshape(segments, (len(starts), SEGMENT, PARTS, depth))
        over_depth = np.fft.rfft(parts * window[:, None, None], axis=3)[..., 1:]
        return np.fft.fft(over_depth, axis=1)

    front, rear = (spectra(picture) for picture in pictures)
    floor = noise**2 * depth * np.sum(window**2)
    powers = [np.mean(np.abs(part) ** 2, axis=0) + floor for part in (front, rear)]
    coherence = np.abs(np.mean(front * np.conj(rear), axis=0)) ** 2 / (powers[0] * powers[1])
    number = 2 * np.pi * np.fft.fftfreq(SEGMENT, spacing)
    each = 2 * number[:, None, None] ** 2 * coherence / (1 - coherence)
    return float(np.sum(each) / (SEGMENT * spacing))


def measure(ground: str, case: Case, data: Path, seed: int) -> dict[str, float]:
    """One drive: error (relative), passages, their sums of squares (m^2), and information."""
    survey = make_ground(ground, seed, data)
    noise = strength(survey) * 10 ** (-case.snr_db / 20)
    antennas = antennas_in_a_row(seed, case.b_m, case.aside_m, noise)
    spec = straight([Move(WAY_M, case.speed)])
    if case.turns_back:
        spec = to_and_fro(WAY_M, case.speed, stream(seed, "pair route"))
    found = passages(drive(spec, survey, antennas, seed, case.rate))
    error, way = (found.told - found.true) * np.sign(found.true), np.abs(found.true)
    return {
        "passages": len(way),
        "error": float(error.sum() / way.sum()) if len(way) else np.nan,
        "square": float(np.sum((error - error.mean()) ** 2)) if len(way) else 0.0,
        "nees": float(np.sum((error / found.sigma) ** 2)),
        "wrong": len(found.wrong),
        "information": information(survey, case),
    }


def summary(ground: str, case: Case, drives: list[dict[str, float]]) -> dict[str, Any]:
    """Of all drives of a case; None of drives without any passage."""
    of = {key: np.array([each[key] for each in drives]) for key in drives[0]}
    count = of["passages"].sum()
    known = of["error"][np.isfinite(of["error"])]
    # The mean over drives is that of variances: a drive's limit is one over its information.
    limit = np.sqrt(np.mean(1 / of["information"]))
    return {
        "ground": ground,
        "case": case.name,
        "drives": len(drives),
        "passages": float(of["passages"].mean()),
        "rms_percent": 100 * float(np.sqrt(np.mean(known**2))) if len(known) else None,
        "bias_percent": 100 * float(np.mean(known)) if len(known) else None,
        "match_mm": 1e3 * float(np.sqrt(of["square"].sum() / count)) if count else None,
        "nees": float(of["nees"].sum() / count) if count else None,
        "wrong": int(of["wrong"].sum()),
        "limit_percent": 100 * float(limit / np.sqrt(WAY_M) / case.b_m),
        "limit_mm": 1e3 * float(limit / np.sqrt(PATCH_M)),
    }


def picture(rows: list[dict[str, Any]], path: Path) -> None:
    """A passage's standard deviation over its limit."""
    figure, (axes,) = canvas.new_figure(height=5.0)
    colours = dict(zip(GROUNDS, canvas.COLOURS[:3], strict=True))
    marks = dict(zip((case.name for case in CASES), "o<>^v*sDPXp", strict=True))
    for row in rows:
        if row["match_mm"] is not None:
            look = {"marker": marks[row["case"]], "color": colours[row["ground"]]}
            axes.plot(row["limit_mm"], row["match_mm"], **look)
    for ground, colour in colours.items():
        axes.plot([], [], "s", color=colour, label=ground)
    driven = {row["case"] for row in rows}
    for name, mark in ((name, mark) for name, mark in marks.items() if name in driven):
        axes.plot([], [], mark, color="0.5", label=name)
    ends = np.array([0.05, 20.0])
    axes.plot(ends, ends, "k-", linewidth=0.8, label="limit")
    axes.set(
        xlabel="limit of a passage (mm)",
        ylabel="standard deviation of a passage (mm)",
        title="Passages of two antennas in a row",
    )
    canvas.log_scales(axes, "x", "y")
    canvas.legend_beside(axes)
    path.write_bytes(canvas.png(figure))


def main() -> None:
    """Runs the command line."""
    parser = parser_of(__doc__, jobs=1)
    parser.add_argument("data", metavar="DATA", type=Path, help="folder real_ground")
    parser.add_argument("--drives", type=int, default=5, help="of each (default: %(default)s)")
    parser.add_argument("--ground", choices=GROUNDS, action="append", help="default: all")
    parser.add_argument(
        "--case", choices=[case.name for case in CASES], action="append", help="default: all"
    )
    parser.add_argument("--plot", metavar="FILE", type=Path, help="picture: measured and limit")
    args = parser.parse_args()
    asked = [
        (ground, case)
        for ground in args.ground or GROUNDS
        for case in CASES
        if not args.case or case.name in args.case
    ]
    seeds = range(1, args.drives + 1)
    rows = []
    for ground, case in asked:
        work = partial(measure, ground, case, args.data)
        rows.append(summary(ground, case, in_processes(args.jobs, case.name, work, seeds)))
    if args.plot:
        picture(rows, args.plot)
    print_rows(args, rows)


if __name__ == "__main__":
    exit_with(main)
