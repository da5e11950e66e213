#!/usr/bin/env python3
"""Salient regions: are the apexes of pipes found where they are, and what does a map of pipes give?

apexes: on full-wave lines of 2.4 m over soil of three strengths of clutter, with a pipe of 5 cm at
0.5 m (of metal, plastic or water) and without one; they are in test/python/pipe_lines.npz, and
`--make FILE` makes them anew by gprMax (some 20 minutes on a core). Place and depth of the apex at
the pipe against the truth, and apexes elsewhere for each metre.

drives: N laps over the FDTD basement, whose six pipes are mapped: position error of wheel,
imu_wheel and salient, without the map and with it; with it also the share of pipe crossings that
were answered, and of the answers those that are wrong by more than 3 sigma.

windows: what the shift of the windows observes of the true displacement, on sequences with the
file beside them that tells their radar's sample interval.

    bench/salient.py apexes|drives|windows [SEQ ...] [--drives N] [--make FILE] [--json]
"""

from __future__ import annotations

import time
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from gprodom.benchmark.motion import read_beside, rmse
from gprodom.calibrate.k import measure_shifts
from gprodom.config import STANDARD
from gprodom.files import temporary_folder
from gprodom.gpr import find_apexes
from gprodom.ground.scene import Layer, Pipe, Scene, Stones, read_scene
from gprodom.lcm.constants import kind
from gprodom.lcm.logs import read_roles
from gprodom.odometry.dead_reckoning import wheel_distance
from gprodom.odometry.estimate import as_log, estimate
from gprodom.odometry.methods import find_method
from gprodom.plot.observability import measure, observe, pool
from gprodom.random_streams import stream
from gprodom.score.sources import read_truth
from gprodom.simulate.files import write_sequence
from gprodom.simulate.robot import robot
from gprodom.simulate.routes import make_route
from gprodom.simulate.sequence import SurveySpec, simulate
from program import exit_with, parser_of, print_rows

CHECKOUT = Path(__file__).resolve().parents[1]
LINES = CHECKOUT / "test" / "python" / "pipe_lines.npz"
CLUTTER = {"weak": (0.03, 5), "medium": (0.08, 12), "strong": (0.15, 25)}  # variation, stones
MATERIALS = {"none": None, "metal": (1.0, 1e6), "plastic": (1.0, 0.0), "water": (80.0, 0.05)}
CASES = (
    *((clutter, pipe) for pipe in ("metal", "none") for clutter in CLUTTER),
    ("weak", "plastic"),
    ("weak", "water"),
)
PLACE_M, DEPTH_M, RADIUS_M, PERMITTIVITY = 1.0, 0.5, 0.025, 8.0
HALF_CELL_M = 0.005  # by which gprMax's ground lies before its coordinates (ground/fdtd.py)


def scene(clutter: str, material: str) -> Scene:
    """A line over the pipe."""
    variation, stones = CLUTTER[clutter]
    contents = MATERIALS[material]
    pipes = () if contents is None else (Pipe(PLACE_M, DEPTH_M, RADIUS_M, *contents),)
    soil = Layer("soil", PERMITTIVITY, 0.005, variation=variation, grain=(0.1, 0.06))
    clutter_stones = (Stones(stones, (0.12, 1.0), (0.03, 0.08), (5.0, 12.0)),)
    return Scene(
        clutter, (soil,), pipes=pipes, stones=clutter_stones, length=2.4, aside=(0.0,), seed=5
    )


def make_lines(path: Path) -> None:
    """All of them, int16."""
    from gprodom.console import Progress
    from gprodom.ground.fdtd import simulate_lines, source_delay
    from gprodom.ground.survey import to_counts

    lines: dict[str, Any] = {}
    with Progress("lines", len(CASES) * scene(*CASES[0]).traces) as progress:
        for clutter, material in CASES:
            made = scene(clutter, material)
            lines[f"{clutter}_{material}"] = to_counts(simulate_lines(made, progress.advance))[0]
    lines |= {"spacing": made.spacing, "sample_interval": made.sample_interval}
    np.savez_compressed(path, surface_time=source_delay(made), **lines)


def apexes() -> list[dict[str, Any]]:
    """A row for each line: of the apex at the pipe, and of the others."""
    rows = []
    with np.load(LINES) as data:
        spacing, interval = float(data["spacing"]), float(data["sample_interval"])
        for clutter, material in CASES:
            traces = data[f"{clutter}_{material}"].astype(np.float64)
            found = find_apexes(
                traces - traces.mean(axis=0),
                sample_interval=interval,
                time_zero=float(data["surface_time"]),
                least_widening=2 * spacing / 1.75e8,
                most_widening=2 * spacing / 0.55e8,
            )
            row: dict[str, Any] = {"clutter": clutter, "pipe": material}
            off = [apex.column * spacing + HALF_CELL_M - PLACE_M for apex in found]
            others = list(range(len(found)))
            if material != "none":
                near = [i for i in others if abs(off[i]) < 0.1]
                row["found"] = int(bool(near))
                if near:
                    apex = found[near[0]]
                    others = [i for i in others if abs(off[i]) > 0.1]
                    depth = apex.time * 299_792_458.0 / np.sqrt(PERMITTIVITY) / 2
                    speed = 2 * spacing / apex.widening
                    row |= {
                        "off_m": float(off[near[0]]),
                        "depth_error": float(depth / DEPTH_M - 1),
                        "permittivity_ratio": float((299_792_458.0 / speed) ** 2 / PERMITTIVITY),
                    }
            row["others_per_m"] = len(others) / (len(traces) * spacing)
            rows.append(row)
    return rows


def basement_pipes(folder: Path) -> Path:
    """The map of the shipped basement, from its scene."""
    ground = read_scene(CHECKOUT / "config" / "scenes" / "basement.yaml")
    speed = 299_792_458.0 / float(np.sqrt(ground.layers[1].permittivity))
    pipes = [{"x": pipe.x, "depth": pipe.depth} for pipe in ground.pipes]
    path = folder / "pipes.yaml"
    path.write_text(
        yaml.safe_dump({"pipes": pipes, "wave_speed": speed, "length": ground.length}),
        encoding="utf-8",
    )
    return path


def drive(seed: int) -> dict[str, Any]:
    """The figures of a drive of some 60 m with two slips."""
    with temporary_folder() as folder:
        route = make_route("loop", 60.0, 0.6, 6.0, stream(seed, "route"), 10.0)
        run = simulate(robot(route, SurveySpec("basement"), kind="loop", slips=2), seed)
        (zipped, *_) = write_sequence(run, folder / "1700000000-0-pipes-cmu-gpr.zip")
        log = as_log(zipped, folder)
        truth = read_truth(zipped).trajectory
        row: dict[str, Any] = {"seed": seed}
        pipes = basement_pipes(folder)
        for method, label in (
            (find_method("wheel"), "wheel"),
            (find_method("imu_wheel"), "imu_wheel"),
            (find_method("salient"), "salient"),
            (find_method("salient", pipes=pipes), "salient_pipes"),
        ):
            begun = time.process_time()
            found = estimate(log, method, (), (), folder / f"{label}.lcmlog")
            row[f"{label}_s"] = time.process_time() - begun
            row[f"{label}_m"] = rmse(found.trajectory, truth)
            if found.answered is not None:
                row[f"{label}_answered"] = found.answered.share
        row |= judged(log, folder, pipes, run)
    return row


def judged(log: Path, folder: Path, pipes: Path, run: Any) -> dict[str, Any]:
    """What the map's answers are against the truth: of crossings between two pipes."""
    from gprodom.ground.pipes import read_pipes
    from gprodom.lcm.answers import answers_to
    from gprodom.odometry.pipes import PipeTeller

    estimate(log, find_method("imu_wheel"), (), (), folder / "track.lcmlog")
    mapped = read_pipes(pipes)
    told = answers_to(log, PipeTeller(mapped), STANDARD, folder / "track.lcmlog")
    seconds = 1e-6 * (run.truth_utime - run.truth_utime[0])
    steps = 0.5 * (run.truth.v[1:] + run.truth.v[:-1]) * np.diff(seconds)
    along = np.concatenate([[0.0], np.cumsum(steps)])  # backwards it falls
    ends = [[each.utime_from, each.utime_to] for each in told] or np.zeros((0, 2))
    begin, end = np.interp(ends, run.truth_utime, along).T
    error = mapped.apart(np.array([each.distance for each in told]) - (end - begin))
    wrong = np.abs(error) > 3 * np.array([each.sigma for each in told] or [1.0])[: len(error)]
    crossings = run.truth.travelled[-1] / mapped.length * len(mapped.x)
    told_pipes = {each.utime_to for each in told}
    return {
        "crossings": float(crossings),
        "answered": len(told_pipes) / crossings,
        "answers": len(told),
        "revisits": sum(each.kind == kind("REVISIT") for each in told),
        "wrong": int(wrong.sum()),
        "rms_m": float(np.sqrt(np.mean(error**2))) if len(error) else None,
    }


def windows(sequences: list[Path]) -> dict[str, Any]:
    """The figures of all windows together."""
    method = find_method("salient")
    seen = []
    for sequence in sequences:
        with temporary_folder() as folder:
            log = as_log(sequence, folder, read_beside(sequence)[1])
            truth = read_truth(sequence).trajectory
            shifts = measure_shifts(log, method, (), (), truth, folder / "output.lcmlog")
            wheel = wheel_distance(read_roles(log, STANDARD.of("wheel")))
            seen.append(observe(shifts, *wheel))
    return asdict(measure(pool(seen)))


def main() -> int:
    """Runs one part."""
    parser = parser_of(__doc__)
    parser.add_argument("part", choices=("apexes", "drives", "windows"))
    parser.add_argument("sequences", type=Path, nargs="*", metavar="SEQ", help="of windows")
    parser.add_argument("--drives", type=int, default=6, metavar="N", help="default %(default)s")
    parser.add_argument("--make", type=Path, metavar="FILE", help="make the lines, to this file")
    args = parser.parse_args()
    if args.make:
        make_lines(args.make)
        return 0
    if args.part == "windows":
        rows = [windows(args.sequences)]
    else:
        rows = apexes() if args.part == "apexes" else [drive(seed) for seed in range(args.drives)]
    print_rows(args, rows)
    return 0


if __name__ == "__main__":
    exit_with(main)
