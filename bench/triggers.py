#!/usr/bin/env python3
"""What is lost where the wheel triggers the radar's traces, in place of a clock?

The same simulated drives with the same faults, on each ground of the simulator, once with 20 traces
a second and once with a trace each so many centimetres: with stops and moments of slip, and with
slip that lasts. Error of the pose in map (m, RMS, aligned at the start) with the radar by each
trigger, and without a radar; and how many places were found again.

    bench/triggers.py [--seeds 3] [--spacing 0.02]... [--ground NAME]... [--json]
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from estimates import planar_figures, run_method
from gprodom.files import temporary_folder
from gprodom.ground.survey import shipped
from gprodom.lcm import logs
from gprodom.lcm.constants import kind
from gprodom.score.sources import read_truth
from program import command, exit_with, one_by_one, parser_of, print_rows

GROUNDS = ("rays", *shipped())
SLIPS = {
    "moments": ("--route=stops", "--slips=4"),
    "lasting": ("--route=line", "--lasting=ramps"),
}
TIME = "time"


def drive(log: Path, ground: str, slip: str, seed: int, spacing: float) -> None:
    """Simulates it. spacing: m between traces; 0 for those of a clock."""
    words = ["simulate", f"--seed={seed}", f"--ground={ground}", *SLIPS[slip], "-o", str(log)]
    if spacing:
        words.append(f"--trigger-distance={spacing}")
    command(*words)


def error_m(log: Path, method: str, settings: Sequence[str] = ()) -> tuple[float, int]:
    """And the number of displacements to places seen before."""
    out = log.with_suffix(".out.lcmlog")
    found, truth = run_method(log, method, out, settings), read_truth(log, frame=None)
    error = planar_figures(found.trajectory, truth.trajectory).ate_rmse_m
    told = logs.read(out, ["GPR_DISPLACEMENT"])
    if "GPR_DISPLACEMENT" not in told:
        return error, 0
    seen = told["GPR_DISPLACEMENT"]
    return error, int(np.sum((seen["kind"] == kind("REVISIT")) & (seen["valid"] != 0)))


def measure(
    ground: str, slip: str, seed: int, spacings: Sequence[float]
) -> Iterator[dict[str, Any]]:
    """A row for each trigger."""
    with temporary_folder() as folder:
        log = folder / "drive.lcmlog"
        drive(log, ground, slip, seed, 0.0)
        without, _ = error_m(log, "imu_wheel")
        for spacing in (0.0, *spacings):
            way = f"{100 * spacing:g} cm" if spacing else TIME
            if spacing:
                drive(log, ground, slip, seed, spacing)
            error, revisits = error_m(
                log, "gprodom_full", [f"gpr.trigger={'distance' if spacing else 'time'}"]
            )
            row = {"ground": ground, "slip": slip, "trigger": way, "seed": seed}
            yield row | {"error_m": error, "without_m": without, "revisits": revisits}


def summary(rows: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """Means over seeds."""
    cases = dict.fromkeys((row["ground"], row["slip"], row["trigger"]) for row in rows)
    found = []
    for case in cases:
        of = [row for row in rows if (row["ground"], row["slip"], row["trigger"]) == case]
        keys = ("error_m", "without_m", "revisits")
        mean = {key: float(np.mean([row[key] for row in of])) for key in keys}
        found.append(dict(zip(("ground", "slip", "trigger"), case, strict=True)) | mean)
    return found


def main() -> None:
    """Measures and prints."""
    parser = parser_of(__doc__)
    parser.add_argument("--seeds", type=int, default=3, metavar="N")
    parser.add_argument("--spacing", type=float, action="append", metavar="M")
    parser.add_argument("--ground", choices=GROUNDS, action="append")
    args = parser.parse_args()
    spacings = args.spacing or [0.02, 0.05]
    cases = list(product(args.ground or GROUNDS, SLIPS, range(args.seeds)))
    rows: list[dict[str, Any]] = []
    for case in one_by_one("drives", cases):
        rows += measure(*case, spacings)
    print_rows(args, summary(rows))


if __name__ == "__main__":
    exit_with(main)
