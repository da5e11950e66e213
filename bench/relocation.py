#!/usr/bin/env python3
"""Is a robot that was reset found again on the ground it knows, and never on ground it does not?

Each run draws everything from a seed: a drive of some 65 m (line, laps, figure of eight, stops)
over ground of scatterers and layers, with slips and the errors of the sensors. The estimator first
loads a map of other ground. It is reset in the pause nearest the middle of the drive; from there
on another wheel's scale and more noise hold. So there are two questions in each run:

    first half    its ground is in no map: to be located is false
    second half   its ground was driven over in the first: to be located is right where the pose in
                  map ends within half a metre of the truth, false elsewhere

The truth is placed by the first half's first pose, so what the first half's map is off by counts.

    bench/relocation.py --runs 100
    bench/relocation.py --runs 20 --others 40 --json
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

import gprodom
from gprodom.arrays import Floats
from gprodom.console import Progress
from gprodom.files import temporary_folder
from gprodom.simulate import Simulated, Spec, make_route, simulate, stream
from gprodom.simulate.recording import as_recording
from program import add_seeds, exit_with, in_processes, list_of, parser_of, print_figures, seeds_of

T = TypeVar("T")

ROUTES = ("line", "loop", "eight", "stops")
DISTANCE = 65.0  # m
SPEED = 0.7  # m/s, at most
STANDSTILL = 4.0  # s, at first
NOISE = 30.0  # counts, more on each sample of the second half
SCALE = 0.01  # by which the wheel's scale changes at most
RIGHT = 0.5  # m
OTHERS = 1_000_000  # seeds of other ground begin here


@dataclass(frozen=True)
class Visit:
    """Of a drive with the map of another day."""

    located_after_m: float | None
    end_m: float  # error of the pose in map at the end; of no meaning where not located
    along_m: list[float]  # errors along the track while located, one a second

    @property
    def located(self) -> bool:
        """Rightly or not."""
        return self.located_after_m is not None

    @property
    def right(self) -> bool:
        """Located, and the pose in map is near the truth at the end."""
        return self.located and self.end_m < RIGHT


@dataclass(frozen=True)
class Relocation(Visit):
    """Of the second half of a run; errors along the track are not told."""

    seed: int
    driven_m: float
    located_first: bool  # in the first half, falsely


def simulated(seed: int) -> Simulated:
    """The drive of one run."""
    route = make_route(ROUTES[seed % 4], DISTANCE, SPEED, STANDSTILL, stream(seed, "route"))
    return simulate(Spec(route, station=None, slips=2), seed)


def middle_pause(run: Simulated) -> int:
    """Time (us) at which the pause begins that is nearest the middle of the drive."""
    standing = np.abs(run.truth.v) < 1e-3
    begins = np.flatnonzero(standing[1:] & ~standing[:-1]) + 1
    middle = 0.5 * run.truth.travelled[-1]
    return int(run.truth_utime[begins[np.argmin(np.abs(run.truth.travelled[begins] - middle))]])


def located_at(outputs: Any) -> int | None:
    """Time (ns) of the first status that says so."""
    times = (told["time"] for told in outputs.status if told["values"].get("map.located"))
    return next(times, None)


def travelled(run: Simulated, time: int) -> float:
    """Metres until a time (ns)."""
    return float(np.interp(time // 1000, run.truth_utime, run.truth.travelled))


def visited(run: Simulated, outputs: Any, off: Floats, along: Floats) -> Visit:
    """off (n, 2), along (n,): errors of the poses in map, m; along the track."""
    at, pose = located_at(outputs), outputs.odometry_map
    if at is None:
        return Visit(None, np.inf, [])
    seconds = np.flatnonzero(np.diff(pose["time"] // 10**9, prepend=0) > 0)
    since = seconds[pose["time"][seconds] >= at]
    return Visit(travelled(run, at), float(np.linalg.norm(off[-1])), along[since].tolist())


def relocate(seed: int, others: Path, overrides: list[str]) -> Relocation:
    """One run."""
    run = simulated(seed)
    recording, reset = as_recording(run), middle_pause(run)
    estimator = gprodom.Odometry(set=overrides)
    estimator.load_map(str(others))
    first = estimator.run(**recording.messages(until=reset))
    estimator.reset()
    random = stream(seed, "second half")
    told = recording.messages(since=reset)
    told["wheel_distance"] = (1 + random.uniform(-SCALE, SCALE)) * told["wheel_distance"]
    told["traces"] = told["traces"] + NOISE * random.standard_normal(told["traces"].shape)
    second = estimator.run(**told)
    pose = second.odometry_map
    [truth] = run.position_from(first.odometry["time"][0] // 1000, pose["time"][-1:] // 1000)
    before, at = travelled(run, reset * 1000), located_at(second)
    return Relocation(
        None if at is None else travelled(run, at) - before,
        float(np.linalg.norm(pose["position"][-1, :2] - truth)),
        [],
        seed,
        run.truth.travelled[-1] - before,
        located_at(first) is not None,
    )


def placed(run: Simulated, utime: Any, frame: Simulated, origin: int) -> Floats:
    """Positions (n, 2) of a drive in the frame that lies where another one was at `origin` (us)."""
    start, motion = frame.motion_at(np.array([origin])), run.motion_at(utime)
    cos, sin = np.cos(start.yaw), np.sin(start.yaw)
    dx, dy = motion.x - start.x, motion.y - start.y
    return np.column_stack([cos * dx + sin * dy, cos * dy - sin * dx])


def remember_others(count: int, file: Path) -> float:
    """Drives over `count` pieces of other ground, kept in `file`. Returns the metres."""
    estimator, metres = gprodom.Odometry(), 0.0
    with Progress("other ground", count) as progress:
        for seed in range(OTHERS, OTHERS + count):
            run = simulated(seed)
            # The clock goes on from drive to drive.
            told = as_recording(run).messages()
            for time in ("imu_time", "wheel_time", "gpr_time"):
                told[time] = told[time] + (seed - OTHERS - count) * 10**12
            estimator.run(**told)
            estimator.reset()
            metres += run.truth.travelled[-1]
            progress.advance()
    estimator.save_map(str(file))
    return metres


def summarise(runs: list[Relocation], other_m: float) -> dict[str, Any]:
    """The figures of ``--json``."""
    after = [run.located_after_m for run in runs if run.located_after_m is not None]
    right = [run.end_m for run in runs if run.right]
    return {
        "runs": len(runs),
        "other_ground_m": other_m,
        "driven_m_mean": float(np.mean([run.driven_m for run in runs])),
        "located": sum(run.located for run in runs),
        "right": len(right),
        "false_on_known_ground": sum(run.located and not run.right for run in runs),
        "false_on_unknown_ground": sum(run.located_first for run in runs),
        "located_after_m_median": float(np.median(after)) if after else None,
        "located_after_m_90": float(np.percentile(after, 90)) if after else None,
        "end_m_rms": float(np.sqrt(np.mean(np.square(right)))) if right else None,
    }


def command_line(description: str | None, others: int) -> argparse.ArgumentParser:
    """The options of a bench that drives on known ground. others: drives in the map, by default."""
    parser = parser_of(description, jobs=2, overrides=True)
    add_seeds(parser, "--runs", 100)
    parser.add_argument(
        "--others", type=int, default=others, help="drives over other ground (%(default)s)"
    )
    return parser


def each_drive(work: Callable[[int], T], args: argparse.Namespace) -> list[T]:
    """Runs `work` for each seed of the command line, in other processes."""
    return in_processes(args.jobs, "drives", work, seeds_of(args))


def main() -> None:
    """Runs the command line."""
    args = command_line(__doc__, others=10).parse_args()
    with temporary_folder() as folder:
        others = folder / "others.map"
        other_m = remember_others(args.others, others)
        work = partial(relocate, others=others, overrides=args.overrides)
        runs = each_drive(work, args)
    figures = summarise(runs, other_m)
    print_figures(args, figures | {"drives": [vars(run) for run in runs]}, list_of(figures))


if __name__ == "__main__":
    exit_with(main)
