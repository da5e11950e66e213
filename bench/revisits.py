#!/usr/bin/env python3
"""The benefit of revisits: gprodom with and without them, with unknown and known wheel scale.

Each SEQUENCE needs `.json` (scale: the wheel's reported distance over the true one) and, for the
revisits' own errors, `.truth.npz` (t, x, y, yaw) beside it; the estimator sees neither. A row
each: position RMSE aligned in the plane, and by the first 3 m, error at the end, m; causal (c) and
smoothed (s). `scale`: free, as a robot starts that was never calibrated, or true (wheel.scale set
to it, held). `revisits`: found; `wrong`: more than 15 cm from where the robot was; `rms`: of the
others, cm, and over their standard deviation.

    bench/revisits.py ../shared/data/cmu_like/*.zip [-j 2] [--json]
"""

from __future__ import annotations

import json
import sys
import tempfile
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from estimates import run_method
from gprodom.console import format_table
from gprodom.convert.sampling import SAMPLE_INTERVAL
from gprodom.lcm import logs
from gprodom.lcm.constants import kind
from gprodom.odometry.estimate import Estimate, as_log
from gprodom.score.align import FIRST_M, Alignment
from gprodom.score.associate import associate
from gprodom.score.figures import Figures, compare
from gprodom.score.sources import read_truth
from program import in_processes, parser_of, print_rows

METHODS = ("gprodom", "gprodom_full")
WRONG = 0.15  # m
ERRORS = ("se2_c", "se2_s", "first_c", "first_s", "end_c", "end_s")  # m
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

    def figures(found: Estimate, alignment: Alignment) -> list[Figures]:
        """Causal and smoothed."""
        paths = (path for path in (found.trajectory, found.smoothed) if path)
        return [compare(associate(path, truth), alignment, FIRST_M).figures for path in paths]

    rows = []
    with tempfile.TemporaryDirectory() as folder:
        log = as_log(sequence, Path(folder), sample_interval)
        for scale, known in (("free", ()), ("true", held)):
            for name in METHODS:
                output = Path(folder) / f"{name}.lcmlog"
                made = run_method(log, name, output, (*known, *overrides), smooth=True)
                se2, first = figures(made, "se2"), figures(made, "first")
                believed = logs.read(output, ["ODOMETRY"])["ODOMETRY"]["wheel_scale"][-1]
                values = [f.ate_rmse_m for f in (*se2, *first)] + [f.end_m for f in se2]
                row: Row = {"sequence": sequence.stem, "scene": sequence.stem.split("-")[2]}
                row |= {"scale": scale, "method": name, **dict(zip(ERRORS, values, strict=True))}
                row |= {"nees_xy": se2[0].nees_xy, "scale_error": believed / true_scale - 1}
                rows.append(row | errors(sequence, output))
    return rows


def means(rows: list[Row]) -> Iterator[list[str]]:
    """A line for each scale and method: means over the sequences, of the simulated and `beach`."""
    for scale in ("free", "true"):
        for method in METHODS:
            of = [r for r in rows if (r["scale"], r["method"]) == (scale, method)]
            beach = [r for r in of if r["scene"] == "beach"]
            other = [r for r in of if r["scene"] != "beach"]
            for name, some in (("simulated", other), ("beach", beach), ("all", of)):
                if some:
                    values = [float(np.mean([r[key] for r in some])) for key in ERRORS]
                    yield [scale, method, name, *(f"{value:.3f}" for value in values)]


def main() -> int:
    """Runs the command line."""
    parser = parser_of(__doc__, jobs=2, overrides=True)
    parser.add_argument("sequences", metavar="SEQUENCE", type=Path, nargs="+")
    args = parser.parse_args()
    intervals = [3.125e-10 if "beach" in s.name else SAMPLE_INTERVAL for s in args.sequences]
    work = partial(run, overrides=tuple(args.overrides))
    parts = in_processes(args.jobs, "sequences", work, args.sequences, intervals)
    rows = [row for part in parts for row in part]
    print_rows(args, rows)
    if args.json:
        return 0
    print("\n" + format_table(["scale", "method", "ground", *ERRORS], list(means(rows))))
    return 0


if __name__ == "__main__":
    sys.exit(main())
