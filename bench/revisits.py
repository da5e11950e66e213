#!/usr/bin/env python3
"""The benefit of revisits: gprodom with and without them, with unknown and known wheel scale.

Each SEQUENCE needs `.json` (scale: the wheel's reported distance over the true one) and, for the
revisits' own errors, `.truth.npz` (t, x, y, yaw) beside it; the estimator sees neither. A row
each: position RMSE aligned in the plane, m, causal (c) and smoothed (s). `scale`: free, as a robot
starts that was never calibrated, or true (wheel.scale set to it, held). `revisits`: found; `wrong`:
more than 15 cm from where the robot was; `rms`: of the others, cm, and over their standard
deviation.

    bench/revisits.py ../shared/data/cmu_like/*.zip [-j 2] [--json]
"""

from __future__ import annotations

import json
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from estimates import planar_figures, run_method
from gprodom.convert.sampling import SAMPLE_INTERVAL
from gprodom.files import temporary_folder
from gprodom.lcm import logs
from gprodom.lcm.constants import kind
from gprodom.odometry.estimate import as_log
from gprodom.score.sources import read_truth
from program import exit_with, in_processes, parser_of, print_rows

METHODS = ("gprodom", "gprodom_full")
WRONG = 0.15  # m
Row = dict[str, Any]


def errors(sequence: Path, log: Path) -> dict[str, float]:
    """Of the revisits found: how many, how many wrong, RMS of the others, and over sigma."""
    told = logs.read(log, ["GPR_DISPLACEMENT"]).get("GPR_DISPLACEMENT")
    if told is None or not np.any(told["kind"] == kind("REVISIT")):
        return {"revisits": 0, "wrong": 0, "rms_cm": 0.0, "rms_sigma": 0.0}
    kept = told["kind"] == kind("REVISIT")
    with np.load(sequence.with_suffix(".truth.npz")) as truth:
        times = [told[at][kept] * 1e-6 for at in ("utime_from", "utime_to")]
        x, y, yaw = (
            [np.interp(time, truth["t"], values) for time in times]
            for values in (truth["x"], truth["y"], np.unwrap(truth["yaw"]))
        )
    along = (x[1] - x[0]) * np.cos(yaw[0]) + (y[1] - y[0]) * np.sin(yaw[0])
    error, sigma = along - told["distance"][kept], told["sigma"][kept]
    right = np.abs(error) <= WRONG
    rms, ratio = (
        float(np.sqrt(np.mean(off[right] ** 2))) if right.any() else 0.0
        for off in (error, error / sigma)
    )
    found = {"revisits": int(kept.sum()), "wrong": int((~right).sum())}
    return found | {"rms_cm": 100 * rms, "rms_sigma": ratio}


def run(sequence: Path, sample_interval: float, overrides: tuple[str, ...]) -> list[Row]:
    """All rows of one sequence."""
    truth = read_truth(sequence).trajectory
    true_scale = json.loads(sequence.with_suffix(".json").read_text())["scale"]
    held = (f"wheel.scale={true_scale}", "wheel.scale_sigma=0")
    rows = []
    with temporary_folder() as folder:
        log = as_log(sequence, folder, sample_interval)
        for scale, known in (("free", ()), ("true", held)):
            for name in METHODS:
                output = folder / f"{name}.lcmlog"
                made = run_method(log, name, output, (*known, *overrides), smooth=True)
                assert made.smoothed is not None
                causal = planar_figures(made.trajectory, truth)
                believed = logs.read(output, ["ODOMETRY"])["ODOMETRY"]["wheel_scale"][-1]
                row: Row = {"sequence": sequence.stem, "scale": scale, "method": name}
                row |= {"se2_c": causal.ate_rmse_m, "nees_xy": causal.nees_xy}
                row |= {"se2_s": planar_figures(made.smoothed, truth).ate_rmse_m}
                row |= {"scale_error": believed / true_scale - 1}
                rows.append(row | errors(sequence, output))
    return rows


def main() -> None:
    """Runs the command line."""
    parser = parser_of(__doc__, jobs=2, overrides=True)
    parser.add_argument("sequences", metavar="SEQUENCE", type=Path, nargs="+")
    args = parser.parse_args()
    intervals = [3.125e-10 if "beach" in s.name else SAMPLE_INTERVAL for s in args.sequences]
    work = partial(run, overrides=tuple(args.overrides))
    parts = in_processes(args.jobs, "sequences", work, args.sequences, intervals)
    print_rows(args, [row for part in parts for row in part])


if __name__ == "__main__":
    exit_with(main)
