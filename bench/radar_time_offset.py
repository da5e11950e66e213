#!/usr/bin/env python3
"""Is the radar's time offset found? Over simulated drives whose offset is known.

Drives of 40 m with many stops and three slips, on every ground there is, with the radar's stamps
late by each --late; `gprodom calibrate time` has to tell it. Exit code 1 where the RMS error on a
ground is beyond --bound.

    bench/radar_time_offset.py
    bench/radar_time_offset.py --seeds 3 --late 0.05 --json
"""

from __future__ import annotations

from functools import partial
from itertools import product

import numpy as np

from gprodom.calibrate.offset import Offset
from gprodom.calibrate.radar_timing import find_radar_offset
from gprodom.ground.survey import find_survey, shipped
from gprodom.simulate import make_route, simulate, stream
from gprodom.simulate.ground import GroundSpec
from gprodom.simulate.robot import robot
from gprodom.simulate.sequence import SurveySpec
from program import add_seeds, exit_with, in_processes, parser_of, print_figures, seeds_of, table_of

RAYS = "rays"
Case = tuple[str, int]  # ground, seed


def measure(case: Case, late: list[float]) -> list[Offset]:
    """What is told of one drive, for each lateness (s) of the radar's stamps."""
    ground, seed = case
    rays = ground == RAYS
    length = None if rays else find_survey(ground).length
    route = make_route("stops", 40.0, 0.6, 4.0, stream(seed, "route"), length)
    spec = robot(route, GroundSpec() if rays else SurveySpec(ground), slips=3)
    drive = simulate(spec, seed)
    log = {
        "wheel": {
            "utime": drive.wheel_utime,
            "ticks": drive.wheel.ticks,
            "metres_per_tick": np.full(len(drive.wheel_utime), spec.wheel.quantum),
        }
    }
    traces = {"samples": drive.traces, "sample_interval": np.array([drive.sample_interval])}
    return [
        find_radar_offset(
            {**log, "gpr_trace": {**traces, "utime": drive.gpr_utime + round(1e6 * s)}}
        )
        for s in late
    ]


def main() -> int:
    """Runs the command line."""
    parser = parser_of(__doc__, jobs=2)
    add_seeds(parser, "--seeds", 10, first=100)
    parser.add_argument("--late", type=float, nargs="+", default=[0.0, 0.05], metavar="S")
    parser.add_argument(
        "--bound", type=float, default=0.015, help="of the RMS error, s (%(default)s)"
    )
    args = parser.parse_args()
    cases = list(product([RAYS, *shipped()], seeds_of(args)))
    found = in_processes(args.jobs, "drives", partial(measure, late=args.late), cases)
    rows = []
    for ground, (at, late) in product([RAYS, *shipped()], enumerate(args.late)):
        own = [o[at] for case, o in zip(cases, found, strict=True) if case[0] == ground]
        error = np.array([o.offset_s + late for o in own])
        told = np.array([o.sigma_s for o in own])
        rows.append({
            "ground": ground,
            "late_s": late,
            "mean_s": float(np.mean(error)),
            "rms_s": float(np.sqrt(np.mean(error**2))),
            "worst_s": float(np.abs(error).max()),
            "told_s": float(np.sqrt(np.mean(told**2))),
        })  # fmt: skip
    print_figures(args, {"rows": rows}, table_of(rows))
    return 0 if all(row["rms_s"] <= args.bound for row in rows) else 1


if __name__ == "__main__":
    exit_with(main)
