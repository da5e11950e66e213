#!/usr/bin/env python3
"""Two antennas in a row on ground that repeats itself, and with faults that robots have.

Simulated drives at 0.4 m/s, the antennas 0.3 m apart, their distance exact; the wheel slips in
ramps of 5 to 35 %, or there is no wheel message (`radar_imu`).

    rebar      bars across the track at exactly the antennas' distance (`pitch`), half or a third of
               it, 0.08 m deep, 12 dB above the strongest scatterer; the same ground without: `none`
    fdtd, ...  undamaged; swapped cables; the rear antenna silent for 10 s in mid-drive; its time
               zero drifting by 1 ns in 10 min

Columns: passages; those wrong by more than 3 sigma and 2 cm; error of the distance by all passages
(%); standard deviation of a passage (mm); how long after its return a silent antenna is used again
(s); what STATUS said of the pair.

    bench/pair_faults.py ../shared/data/real_ground [--km 1] [--minutes 10] [--json]
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from gprodom.console import Progress
from gprodom.convert.cmu import Traces
from gprodom.ground.survey import Survey
from gprodom.random_streams import stream
from gprodom.simulate.antennas import AntennaSpec
from gprodom.simulate.drive import Move
from gprodom.simulate.ground import Ground, GroundSpec
from gprodom.simulate.sequence import Simulated
from gprodom.simulate.wheel import WheelSpec
from pair_drives import (
    GROUNDS,
    Passages,
    antennas_in_a_row,
    drive,
    make_ground,
    passages,
    straight,
    strength,
)
from program import exit_with, parser_of, print_rows

B_M, SPEED = 0.3, 0.4  # m, m/s
PIECE_M = 100.0  # of the drives over rebar
REBAR_M = 30.0  # length of their ground, driven over again and again: 100 bars, 200 half as far
SPACING_M = 0.01  # of its traces
_LOUD = 4  # bars, in strongest scatterers: 12 dB
SILENT_S = 10.0
DRIFT = 1e-9 / 600  # s/s
WHEEL = WheelSpec(scale_sigma=0.0, lasting="ramps", quantum=1.82e-4)
METHODS = ("gprodom", "radar_imu")
Row = dict[str, Any]


def rebar(pitch_m: float | None, seed: int) -> Survey:
    """Closed ground by rays with bars at that pitch; None: the same without."""
    along = np.arange(0.0, REBAR_M, SPACING_M)
    bars = () if pitch_m is None else [x * pitch_m for x in range(-5, round(REBAR_M / pitch_m) + 5)]
    # So that bars, too, keep within full scale.
    spec = GroundSpec(amplitude=5000.0, direct=6000.0, pipes=_LOUD * tuple((x, 0.08) for x in bars))
    lines = []
    for y in (0.0, 0.06):
        # The ends: beyond them the same scatterers are seen from the other side, half by half.
        ground = Ground(spec, along, np.array([0.0, 0.06]), stream(seed, "rebar"))
        here = ground.traces(along, np.full_like(along, y))
        there = ground.traces(along - REBAR_M, np.full_like(along, y))
        share = np.clip((along - REBAR_M + 1.0) / 1.0, 0.0, 1.0)[:, None]
        lines.append((1 - share) * here + share * there)
    counts = np.rint(lines).astype(np.int16)
    return Survey("rebar", counts, SPACING_M, np.array([0.0, 0.06]), 2e-10, 0.0)


def swapped(simulated: Simulated) -> Simulated:
    """With its cables swapped."""
    rear = simulated.more_antennas[1]
    front = Traces(simulated.gpr_utime, simulated.traces)
    return replace(simulated, gpr_utime=rear.utime, traces=rear.counts, more_antennas={1: front})


def silent(simulated: Simulated) -> tuple[Simulated, float]:
    """The rear antenna gives nothing for `SILENT_S` in mid-drive; until when, s from the start."""
    rear = simulated.more_antennas[1]
    begin = (rear.utime[0] + rear.utime[-1]) // 2
    end = begin + round(1e6 * SILENT_S)
    kept = (rear.utime < begin) | (rear.utime >= end)
    more = {1: Traces(rear.utime[kept], rear.counts[kept])}
    return replace(simulated, more_antennas=more), (end - simulated.spec.start_utime) * 1e-6


def row(
    ground: str, fault: str, method: str, drives: list[Simulated], back_s: float | None = None
) -> Row:
    """Replays the drives."""
    found: list[Passages] = [passages(each, method=method) for each in drives]
    told, true = (np.concatenate([getattr(p, key) for p in found]) for key in ("told", "true"))
    error, way = (told - true) * np.sign(true), np.abs(true)
    after = [] if back_s is None else found[0].time[found[0].time > back_s]
    said = dict.fromkeys(r for p in found for r in p.reasons if "pair" in r or "antenna" in r)
    return {
        "ground": ground,
        "fault": fault,
        "method": method,
        "metres": float(sum(each.truth.travelled[-1] for each in drives)),
        "passages": len(way),
        "wrong": sum(len(p.wrong) for p in found),
        "distance_percent": 100 * float(error.sum() / way.sum()) if len(way) else None,
        "match_mm": 1e3 * float(np.std(error)) if len(way) else None,
        "back_after_s": float(after[0] - back_s) if len(after) and back_s is not None else None,
        "said": list(said),
    }


def over_rebar(km: float) -> list[Row]:
    """Drives over bars, and over the same ground without."""
    rows = []
    seeds = range(1, 1 + max(1, round(1000 * km / PIECE_M)))
    with Progress("rebar", 4) as progress:
        for name, pitch in (("none", None), ("pitch", B_M), ("half", B_M / 2), ("third", B_M / 3)):
            drives = []
            for seed in seeds:
                survey = rebar(pitch, seed)
                antennas = antennas_in_a_row(seed, B_M, 0.01, 0.1 * strength(rebar(None, seed)))
                spec = straight([Move(min(PIECE_M, 1000 * km), SPEED)])
                drives.append(drive(spec, survey, antennas, seed, wheel=WHEEL))
            rows += [row("rebar", name, method, drives) for method in METHODS]
            progress.advance()
    return rows


def faults(minutes: float, grounds: list[str], data: Path) -> list[Row]:
    """The other faults."""
    rows = []
    spec = straight([Move(60 * minutes * SPEED, SPEED)])
    with Progress("faults", 5 * len(grounds)) as progress:
        for name in grounds:
            survey = make_ground(name, 1, data)
            antennas = antennas_in_a_row(1, B_M, 0.01, 0.1 * strength(survey))
            rear = replace(antennas[1], time_zero_rate=DRIFT)

            def driven(pair: tuple[AntennaSpec, ...], survey: Survey = survey) -> Simulated:
                return drive(spec, survey, pair, 1, wheel=WHEEL)

            whole = driven(antennas)
            gone, back_s = silent(whole)
            for fault, method, simulated, back in (
                ("none", METHODS[0], whole, None),
                ("swapped", METHODS[0], swapped(whole), None),
                ("swapped", METHODS[1], swapped(whole), None),
                ("silent", METHODS[0], gone, back_s),
                ("time zero", METHODS[0], driven((antennas[0], rear)), None),
            ):
                rows.append(row(name, fault, method, [simulated], back))
                progress.advance()
    return rows


def main() -> None:
    """Runs the command line."""
    parser = parser_of(__doc__)
    parser.add_argument("data", metavar="DATA", type=Path, help="folder real_ground")
    parser.add_argument("--km", type=float, default=1.0, help="over rebar; 0: none")
    parser.add_argument("--minutes", type=float, default=10.0, help="of other faults; 0: none")
    parser.add_argument(
        "--ground", choices=GROUNDS, action="append", help="of other faults; default: all"
    )
    args = parser.parse_args()
    rows = over_rebar(args.km) if args.km > 0 else []
    if args.minutes > 0:
        rows += faults(args.minutes, args.ground or list(GROUNDS), args.data)
    print_rows(args, rows)


if __name__ == "__main__":
    exit_with(main)
