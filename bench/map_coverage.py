#!/usr/bin/env python3
"""Is the pose in map as sure as it says, and does it withstand wrong revisits? Simulated drives.

Each run draws everything from a seed: a line driven to and fro or laps, of some 45 m, over ground
of scatterers and layers, the wheel's scale, the errors of the sensors, two episodes of slip. The
truth is placed by its first pose. Of the position in `map`:

    coverage   share of the drives, at their end, in which the 95 % ellipse holds the truth; and the
               same of all moments, a second apart, from the first revisit on
    --wrong    the same drives with wrong revisits told by another process besides: every 20 m one
               that is 0.3 to 3 m off, and three a metre apart that agree with each other, one pitch
               of 0.5 m off. Prints how far the final pose lies from that of the clean run.

    bench/map_coverage.py --runs 100
    bench/map_coverage.py --runs 20 --wrong
    bench/map_coverage.py --runs 50 --distance 200
"""

from __future__ import annotations

import argparse
import math
import sys
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

import gprodom
from gprodom.console import Progress, add_json_flag, format_table, print_json
from gprodom.simulate import Simulated, Spec, make_route, simulate, stream
from gprodom.simulate.recording import as_recording

DISTANCE = 45.0  # m
AGAIN = 14.0  # m of ground that longer drives stay on, about what is driven of in one of 45 m
SPEED = 0.7  # m/s, at most
STANDSTILL = 4.0  # s, at first
ELLIPSE = -2 * math.log(0.05)  # chi-square of 2 degrees of freedom, 95 %
EVERY = 20.0  # m between wrong revisits


@dataclass(frozen=True)
class Drive:
    """Of one run. nees: of x, y in map, at moments a second apart from the first revisit on."""

    seed: int
    revisits: int
    nees: list[float]
    end_m: float  # error at the end
    moved_m: float = 0.0  # of the final pose, by wrong revisits


def simulated(seed: int, distance: float = DISTANCE) -> Simulated:
    """The drive of one run, of `distance` m."""
    name = ("line", "loop")[seed % 2]
    ground = AGAIN if distance > DISTANCE else None
    route = make_route(name, distance, SPEED, STANDSTILL, stream(seed, "route"), ground)
    return simulate(Spec(route, station=None, slips=round(2 * distance / DISTANCE)), seed)


def wrong_revisits(run: Simulated) -> list[dict[str, Any]]:
    """Arguments of add_displacement."""
    random = stream(run.seed, "wrong")
    travelled, time = run.truth.travelled, run.truth_utime * 1000
    told = []

    def tell(metres: float, back: float, offset: float) -> None:
        to, since = (int(np.interp(at, travelled, time)) for at in (metres, metres - back))
        turn = np.interp([since, to], time, run.truth.yaw)
        speed = np.interp([since, to], time, run.truth.v)
        mirrored = (math.cos(turn[1] - turn[0]) < 0) != (speed.prod() < 0)  # driven, not faced
        told.append({
            "time": to, "time_from": since, "time_to": to, "distance": offset, "sigma": 0.02,
            "revisit": True, "mirrored": mirrored,
        })  # fmt: skip

    for metres in np.arange(EVERY, travelled[-1], EVERY):
        here = np.searchsorted(travelled, metres)
        # A place passed before, as close as there is.
        before = np.flatnonzero(travelled < metres - 5.0)
        apart = np.hypot(
            run.truth.x[before] - run.truth.x[here], run.truth.y[before] - run.truth.y[here]
        )
        back = metres - travelled[before[np.argmin(apart)]]
        tell(metres, back, random.choice([-1, 1]) * random.uniform(0.3, 3.0))
        for k in range(3):
            tell(metres + 1.0 + k, back, 0.5)
    return told


def estimate(run: Simulated, overrides: list[str], told: list[dict[str, Any]]) -> list[Any]:
    """The outputs up to each time at which the estimator is told something, and to the end."""
    estimator = gprodom.Odometry(set=overrides)
    recording = as_recording(run)
    outputs, since = [], 0
    for message in [*told, None]:
        until = message["time"] // 1000 if message else np.iinfo(np.int64).max
        outputs.append(estimator.run(**recording.messages(since, until)))
        if message:
            estimator.add_displacement(**message)
        since = until
    return outputs


def drive(seed: int, overrides: list[str], wrong: bool, distance: float = DISTANCE) -> Drive:
    """One run."""
    run = simulated(seed, distance)
    [outputs] = estimate(run, overrides, [])
    pose = outputs.odometry_map
    time = pose["time"]
    first = outputs.corrections[0]["time"] if outputs.corrections else time[-1]
    moments = np.unique(np.append(np.searchsorted(time, np.arange(first, time[-1], 10**9)),
                                  len(time) - 1))  # fmt: skip
    truth = run.position_from(time[0] // 1000, time[moments] // 1000)
    error = pose["position"][moments, :2] - truth
    covariance = pose["pose_covariance"][moments].reshape(-1, 6, 6)[:, :2, :2]
    nees = np.einsum("ni,ni->n", error, np.linalg.solve(covariance, error[:, :, None])[:, :, 0])
    moved = 0.0
    if wrong:
        other = estimate(run, overrides, wrong_revisits(run))[-1].odometry_map["position"][-1]
        moved = float(np.linalg.norm(other - pose["position"][-1]))
    revisits = outputs.corrections[-1]["revisits"] if outputs.corrections else 0
    return Drive(seed, revisits, nees.tolist(), float(np.linalg.norm(error[-1])), moved)


def summarise(drives: list[Drive], wrong: bool) -> dict[str, Any]:
    """The figures of ``--json``."""
    tied = [run for run in drives if run.revisits > 0]
    inside = np.concatenate([np.array(run.nees) <= ELLIPSE for run in tied])
    figures: dict[str, Any] = {
        "runs": len(drives),
        "with_revisits": len(tied),
        "revisits_mean": float(np.mean([run.revisits for run in drives])),
        "coverage_end": float(np.mean([run.nees[-1] <= ELLIPSE for run in drives])),
        "coverage_all": float(inside.mean()),
        "nees_end_mean": float(np.mean([run.nees[-1] for run in drives])),
        "end_m_rms": float(np.sqrt(np.mean([run.end_m**2 for run in drives]))),
    }
    if wrong:
        moved = [run.moved_m for run in drives]
        figures |= {"moved_m_max": max(moved), "moved_m_median": float(np.median(moved))}
    return figures


def main() -> int:
    """Runs the command line."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--runs", type=int, default=100, help="default: %(default)s")
    parser.add_argument("--first-seed", type=int, default=0, help="default: %(default)s")
    parser.add_argument("--jobs", type=int, default=2, help="at once (default: %(default)s)")
    parser.add_argument(
        "--distance",
        type=float,
        default=DISTANCE,
        metavar="M",
        help=f"beyond {DISTANCE:g}: {AGAIN:g} m of ground again and again (default: %(default)s)",
    )
    parser.add_argument("--wrong", action="store_true", help="wrong revisits besides")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", dest="overrides")
    add_json_flag(parser)
    args = parser.parse_args()
    seeds = range(args.first_seed, args.first_seed + args.runs)
    work = partial(drive, overrides=args.overrides, wrong=args.wrong, distance=args.distance)
    with ProcessPoolExecutor(args.jobs) as pool, Progress("drives", len(seeds)) as progress:
        drives = []
        for run in pool.map(work, seeds):
            drives.append(run)
            progress.advance()
    figures = summarise(drives, args.wrong)
    if args.json:
        print_json(figures | {"drives": [vars(run) for run in drives]})
    else:
        print(format_table(["figure", "value"], [[k, f"{v:.4g}"] for k, v in figures.items()]))
    return 0


if __name__ == "__main__":
    sys.exit(main())
