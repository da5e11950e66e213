#!/usr/bin/env python3
"""gprodom's fixed-lag smoother beside GTSAM's, in one run, with the same factors and the same data.

Each sequence is cut into state intervals (state_intervals.py): IMU samples, wheel increments, where
the wheel slips. gprodom's smoother with either solver (bench/smoother_update.cpp), GTSAM's
BatchFixedLagSmoother and its IncrementalFixedLagSmoother (smoothers_gtsam.py, default parameters)
get the same factors of them: preintegrated IMU, bias walk, the wheel's increment with no motion
sideways or upwards; none robust, the wheel's scale given. An update ends with the
newest pose, velocity and biases and their covariance, which GTSAM's batch smoother does not keep:
there it is asked of the graph (Marginals); its update without it is told beside. GTSAM's default,
Cholesky, gives up on some sequences ("indeterminate linear system"); those are run with QR, and
their times told apart: gprodom is compared with the batch smoother by Cholesky.

gprodom's time holds preintegration and making the factors, GTSAM's holds its smoother alone. All
run on one core, --repeats times in turn; an update's time is the median of its repeats. A plain EKF
on IMU and wheel (plain_ekf.py) is there for its accuracy.

Times are of the processor. Wants gtsam: pip install 'scripts[bench]'. Sequences have truth and,
beside them as SEQUENCE.json, the "scale" of their wheel. Exit code 1 where gprodom's median is over
--max-median of the batch smoother's, its p99 over --max-p99 of it, or its error 5 % over it, with
smoother.solver: ceres.

    bench/smoothers.py SEQ...
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import gprodom
import plain_ekf
import smoothers_gtsam
import state_intervals
from gprodom.benchmark.motion import rmse
from gprodom.console import Progress
from gprodom.convert.cmu import read_recording
from gprodom.errors import Error
from gprodom.files import temporary_folder
from gprodom.score.sources import read_truth
from gprodom.trajectory import Trajectory
from program import exit_with, parser_of, print_figures, table_of
from smoothers_gtsam import Updates

Array = NDArray[np.float64]
OURS, CHAIN = "gprodom, ceres", "gprodom, chain"
BATCH, INCREMENTAL = "GTSAM batch", "GTSAM incremental"
SOLVERS = {OURS: "ceres", CHAIN: "chain"}  # smoother.solver
QR = ", QR"
EKFS = {"EKF": False, "EKF, gyro less its first bias": True}


@dataclass
class Result:
    """Over all sequences: times of each update, s, and errors of each sequence, m."""

    times: dict[str, list[Array]]  # by what: cpu, cpu_update
    errors: list[float]


def ours(program: Path, file: Path, lag: float, overrides: list[str]) -> Updates:
    """bench/smoother_update.cpp on a file of measurements."""
    out = file.with_suffix(".csv")
    keys = [f"smoother.lag={lag}", "wheel.scale_sigma=0", "wheel.robust_threshold=0"]
    keys += overrides
    subprocess.run([program, file, out, *keys], check=True)
    table = np.genfromtxt(out, delimiter=",", names=True)
    position = np.column_stack([table[axis] for axis in "xyz"])
    return Updates(position, table["cpu_s"], table["cpu_s"])


def known_scale(source: Path) -> float:
    """Of the wheel, from what is told beside a simulated sequence."""
    beside = source.with_suffix(".json")
    if not beside.is_file():
        raise Error(f"{beside}: missing")
    return float(json.loads(beside.read_text())["scale"])


def measure(source: Path, args: argparse.Namespace, results: dict[str, Result], tick: Any) -> int:
    """One sequence; the number of updates."""
    recording, truth = read_recording(source), read_truth(source, frame=None).trajectory
    scale = known_scale(source)
    whole = state_intervals.cut(recording, args.rate)
    stamps = np.array([each.time // 1000 for each in whole.intervals])
    with temporary_folder() as folder:
        file = folder / "intervals.txt"
        state_intervals.write(file, whole, scale)
        runs: dict[str, list[Updates]] = {label: [] for label in (*SOLVERS, BATCH, INCREMENTAL)}
        solver = {BATCH: "CHOLESKY", INCREMENTAL: "CHOLESKY"}
        for _ in range(args.repeats):
            for label, name in SOLVERS.items():
                keys = [*args.overrides, f"smoother.solver={name}"]
                runs[label].append(ours(args.program, file, args.lag, keys))
            for label, kind in ((BATCH, "batch"), (INCREMENTAL, "incremental")):
                try:
                    run = smoothers_gtsam.run(whole, scale, args.lag, kind, solver[label])
                except RuntimeError:  # "indeterminate linear system"
                    solver[label] = "QR"
                    run = smoothers_gtsam.run(whole, scale, args.lag, kind, solver[label])
                runs[label].append(run)
                tick()
    for label, repeats in runs.items():
        timed = label + (QR if solver.get(label) == "QR" else "")
        for what in ("cpu", "cpu_update"):
            each = np.median([getattr(run, what) for run in repeats], axis=0)
            results[timed].times.setdefault(what, []).append(each)
        results[label].errors.append(rmse(Trajectory(stamps, repeats[0].position), truth))
    for label, less_bias in EKFS.items():
        reckoned = Trajectory(*plain_ekf.run(recording, scale, less_bias))
        results[label].errors.append(rmse(reckoned, truth))
    return len(stamps)


def quantiles(result: Result, what: str) -> tuple[float, float, float]:
    """Median, p99 and greatest, s."""
    all_times = np.concatenate(result.times[what])
    return (*(float(q) for q in np.quantile(all_times, [0.5, 0.99])), float(all_times.max()))


def main() -> int:
    """Runs the command line."""
    parser = parser_of(__doc__, overrides=True)
    parser.add_argument("sources", metavar="SEQ", type=Path, nargs="+")
    program = (gprodom._build or Path("build")) / "bench" / "bench_smoother_update"
    parser.add_argument("--program", type=Path, default=program, help="default: of the build")
    parser.add_argument("--rate", type=float, default=10.0, help="states/s (default: %(default)s)")
    parser.add_argument("--lag", type=float, default=5.0, help="s (default: %(default)s)")
    parser.add_argument("--repeats", type=int, default=3, help="default: %(default)s")
    parser.add_argument("--max-median", type=float, default=0.6, help="default: %(default)s")
    parser.add_argument("--max-p99", type=float, default=1 / 3, help="default: a third")
    args = parser.parse_args()
    os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})
    labels = (*SOLVERS, BATCH, BATCH + QR, INCREMENTAL, INCREMENTAL + QR, *EKFS)
    results = {label: Result({}, []) for label in labels}
    updates = 0
    with Progress("smoothers", 2 * args.repeats * len(args.sources)) as progress:
        for source in args.sources:
            updates += measure(source, args, results, progress.advance)
    figures = summary(results)
    figures["updates"] = updates
    print_figures(args, figures, shown(figures))
    over = figures["over_batch"]["cpu"]
    fast, even = over["median"] <= args.max_median, over["p99"] <= args.max_p99
    exact = figures["error_m"][OURS] <= 1.05 * figures["error_m"][BATCH]
    return 0 if fast and even and exact else 1


def summary(results: dict[str, Result]) -> dict[str, Any]:
    """The figures of ``--json``; times in s."""
    names = ("median", "p99", "greatest")
    times = {
        label: {
            what: dict(zip(names, quantiles(result, what), strict=True)) for what in result.times
        }
        for label, result in results.items()
        if result.times
    }
    over = {
        what: {name: times[OURS][what][name] / times[BATCH][what][name] for name in names}
        for what in times[OURS]
    }
    return {
        "times_s": times,
        "over_batch": over,
        "error_m": {label: float(np.mean(r.errors)) for label, r in results.items() if r.errors},
        "sequences": {label: len(r.times["cpu"]) for label, r in results.items() if r.times},
        "errors_m": {label: result.errors for label, result in results.items()},
    }


def shown(figures: dict[str, Any]) -> str:
    """As tables; ms."""
    columns = [(what, name) for what in ("cpu", "cpu_update") for name in ("median", "p99")]
    rows = []
    for label in figures["errors_m"]:
        row = {"smoother": label, "timed": figures["sequences"].get(label)}
        if told := figures["times_s"].get(label):
            row |= {f"{what} {name}": 1e3 * told[what][name] for what, name in columns}
        rows.append(row | {"error (m)": figures["error_m"].get(label)})
    over = [{"over batch": what} | ratios for what, ratios in figures["over_batch"].items()]
    return f"{table_of(rows)}\n{figures['updates']} updates\n{table_of(over)}"


if __name__ == "__main__":
    exit_with(main, failed=2)
