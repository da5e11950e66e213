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
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path

import numpy as np

from gprodom.console import format_table
from gprodom.convert.sampling import SAMPLE_INTERVAL
from gprodom.lcm import logs
from gprodom.lcm.constants import kind
from gprodom.odometry.estimate import as_log, estimate
from gprodom.odometry.methods import find_method
from gprodom.score.align import FIRST_M, Alignment
from gprodom.score.associate import associate
from gprodom.score.figures import Figures, compare
from gprodom.score.sources import read_truth
from gprodom.trajectory import Trajectory
from program import in_processes, parser_of, print_rows

METHODS = ("gprodom", "gprodom_full")
WRONG = 0.15  # m


@dataclass(frozen=True)
class Row:
    """One method on one sequence. rms_sigma: of the errors over their standard deviation."""

    sequence: str
    scene: str
    scale: str
    method: str
    se2_c: float
    se2_s: float
    first_c: float
    first_s: float
    end_c: float
    end_s: float
    nees_xy: float | None
    scale_error: float  # of the wheel's scale at the end, relative
    revisits: int
    wrong: int
    rms_cm: float
    rms_sigma: float


def errors(sequence: Path, log: Path) -> tuple[int, int, float, float]:
    """Of the revisits found: how many, how many wrong, RMS (cm) of the others, and over sigma."""
    told = logs.read(log, ["GPR_DISPLACEMENT"]).get("GPR_DISPLACEMENT")
    if told is None or not np.any(told["kind"] == kind("REVISIT")):
        return 0, 0, 0.0, 0.0
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
    rms = float(np.sqrt(np.mean(error[right] ** 2))) if right.any() else 0.0
    ratio = float(np.sqrt(np.mean((error[right] / sigma[right]) ** 2))) if right.any() else 0.0
    return int(kept.sum()), int((~right).sum()), 100 * rms, ratio


def run(sequence: Path, sample_interval: float, overrides: tuple[str, ...]) -> list[Row]:
    """All rows of one sequence."""
    truth = read_truth(sequence).trajectory
    true_scale = json.loads(sequence.with_suffix(".json").read_text())["scale"]
    held = (f"wheel.scale={true_scale}", "wheel.scale_sigma=0")

    def figures(trajectory: Trajectory, alignment: Alignment) -> Figures:
        return compare(associate(trajectory, truth), alignment, FIRST_M).figures

    rows = []
    with tempfile.TemporaryDirectory() as folder:
        log = as_log(sequence, Path(folder), sample_interval)
        for scale, known in (("free", ()), ("true", held)):
            for name in METHODS:
                output = Path(folder) / f"{name}.lcmlog"
                settings = (*known, *overrides)
                made = estimate(log, find_method(name), (), settings, output, smooth=True)
                assert made.smoothed is not None
                both = (made.trajectory, made.smoothed)
                se2 = [figures(t, "se2") for t in both]
                first = [figures(t, "first") for t in both]
                believed = logs.read(output, ["ODOMETRY"])["ODOMETRY"]["wheel_scale"][-1]
                rows.append(
                    Row(
                        sequence.stem,
                        sequence.stem.split("-")[2],
                        scale,
                        name,
                        *(f.ate_rmse_m for f in se2),
                        *(f.ate_rmse_m for f in first),
                        *(f.end_m for f in se2),
                        se2[0].nees_xy,
                        believed / true_scale - 1,
                        *errors(sequence, output),
                    )
                )
    return rows


def means(rows: list[Row]) -> Iterator[list[str]]:
    """A line for each scale and method: means over the sequences, of the simulated and `beach`."""
    for scale in ("free", "true"):
        for method in METHODS:
            of = [r for r in rows if (r.scale, r.method) == (scale, method)]
            beach = [r for r in of if r.scene == "beach"]
            other = [r for r in of if r.scene != "beach"]
            for name, some in (("simulated", other), ("beach", beach), ("all", of)):
                if some:
                    columns = ("se2_c", "se2_s", "first_c", "first_s", "end_c", "end_s")
                    values = [float(np.mean([getattr(r, key) for r in some])) for key in columns]
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
    print_rows(args, [asdict(row) for row in rows])
    if args.json:
        return 0
    heads = ["scale", "method", "ground", "se2_c", "se2_s", "first_c", "first_s", "end_c", "end_s"]
    print("\n" + format_table(heads, list(means(rows))))
    return 0


if __name__ == "__main__":
    sys.exit(main())
