#!/usr/bin/env python3
"""Is a robot located in the map of another day, when the ground has changed since?

Each run draws everything from a seed. On one day a robot drives some 65 m (line, laps, figure of
eight, stops) over ground of scatterers and layers; its map is saved, together with other ground.
On another day a robot with other noise, wheel, gain and pulse, a ringing antenna and faded deep
echoes drives the same route, some centimetres aside, with that map loaded. The permittivity has
changed by a given percentage, unevenly by depth: by all of it or by half as much, drawn for four
depths. In a second drive of that day the ground is a stranger's: to be located there is false.

    located          within so many metres driven, the pose in map being right (0.5 m) at the end
    false            located elsewhere on known ground, or on a stranger's
    along the track  error of the pose in map while located rightly, in the direction of driving

Beside it, in the same drives, what the matcher was before: with a map of version 1, which holds
features alone, no travel time is stretched (--no-beside: without).

    bench/changed_ground.py --runs 100 --change 0 10 -10 20 -20
    bench/changed_ground.py --runs 4 --others 1 --change 10 --json
"""

from __future__ import annotations

import argparse
from dataclasses import asdict, dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

import gprodom
from gprodom import rotation
from gprodom.arrays import Floats
from gprodom.files import temporary_folder
from gprodom.map.ground import read_map
from gprodom.simulate import Simulated, simulate, stream
from gprodom.simulate import radar as radar_of
from gprodom.simulate.ground import Ground, GroundSpec
from gprodom.simulate.recording import as_recording
from program import exit_with, print_figures, table_of
from relocation import Visit, command_line, each_drive, placed, remember_others, simulated, visited

DAY = 86_400_000_000  # us
SCALE = 0.01  # by which the wheel's scale changes at most
SECOND_DAY = 2_000_000  # seeds of the other day begin here
STRANGER = 3_000_000  # and those of ground that is in no map
WITHIN = 20.0  # m


@dataclass(frozen=True)
class Outcome:
    """Of one run at one change."""

    seed: int
    change: float  # percent, of the permittivity
    known: Visit
    before: Visit | None  # with the map as features alone
    stranger: Visit | None


def changed(spec: GroundSpec, percent: float, seed: int) -> GroundSpec:
    """The ground of another day, seen by another radar of the same type."""
    random = stream(seed, f"another day {percent}")
    return replace(
        spec,
        permittivity=tuple(0.01 * percent * random.uniform(0.5, 1.0, 4)),
        frequency=spec.frequency * random.uniform(0.93, 1.07),
        attenuation=spec.attenuation * random.uniform(1.0, 1.4),
        amplitude=spec.amplitude * random.uniform(0.6, 1.5),
        direct=spec.direct * random.uniform(0.8, 1.2),
    )


def antenna_path(run: Simulated, utime: Any) -> tuple[Floats, Floats]:
    """World position of the antenna, m."""
    motion = run.motion_at(utime)
    cos, sin = np.cos(motion.yaw), np.sin(motion.yaw)
    x, y = run.spec.radar.lever_arm
    return motion.x + cos * x - sin * y, motion.y + sin * x + cos * y


def another_day(first: Simulated, percent: float, ground_seed: int) -> Simulated:
    """The route of `first` driven again; the ground is that of the drive `ground_seed`."""
    seed = SECOND_DAY + first.seed
    spec = replace(
        first.spec,
        wheel=replace(first.spec.wheel, slips=()),
        radar=replace(first.spec.radar, ringing=3000.0),
        slips=2,
        start_utime=first.spec.start_utime + DAY,
    )
    assert isinstance(first.spec.ground, GroundSpec)
    again = simulate(spec, seed)
    there = antenna_path(first, first.gpr_utime)
    ground = Ground(
        changed(first.spec.ground, percent, seed), *there, stream(ground_seed, "ground")
    )
    clean = ground.traces(*antenna_path(again, again.gpr_utime))
    time = (again.gpr_utime - spec.start_utime) * 1e-6
    interval, random = again.sample_interval, stream(seed, "radar again")
    assert interval is not None
    traces = radar_of.measure(clean, time, interval, spec.radar, random)
    return replace(again, traces=traces)


def visit(run: Simulated, first: Simulated, origin: int, where: Path, sets: list[str]) -> Visit:
    """Drives with the map of another day. origin: time (us) of the pose at which its frame lies."""
    estimator = gprodom.Odometry(set=sets)
    estimator.load_map(str(where))
    told = as_recording(run).messages()
    scale = stream(run.seed, "scale").uniform(-SCALE, SCALE)
    told["wheel_distance"] = (1 + scale) * told["wheel_distance"]
    outputs = estimator.run(**told)
    pose = outputs.odometry_map
    off = pose["position"][:, :2] - placed(run, pose["time"] // 1000, first, origin)
    yaw = rotation.yaw_of(pose["orientation"])
    return visited(run, outputs, off, off[:, 0] * np.cos(yaw) + off[:, 1] * np.sin(yaw))


def run_one(
    seed: int, changes: list[float], others: Path, sets: list[str], beside: bool
) -> list[Outcome]:
    """One map, and the drives of another day."""
    first = simulated(seed)
    with temporary_folder() as folder:
        where = folder / "day.map"
        estimator = gprodom.Odometry(set=sets)
        estimator.load_map(str(others))
        outputs = estimator.run(**as_recording(first).messages())
        origin = int(outputs.odometry["time"][0]) // 1000
        estimator.reset()
        estimator.save_map(str(where))
        features = folder / "features.map"
        features.write_bytes(read_map(where).ground.features_alone().to_bytes())
        found = []
        for number, percent in enumerate(changes):
            again = another_day(first, percent, seed)
            known = visit(again, first, origin, where, sets)
            before = visit(again, first, origin, features, sets) if beside else None
            stranger = None
            if number == 0:  # what is in no map is not in it at another change either
                away = another_day(first, percent, STRANGER + seed)
                stranger = visit(away, first, origin, where, sets)
            found.append(Outcome(seed, percent, known, before, stranger))
    return found


def summarise(
    change: float, matcher: str, known: list[Visit], strangers: list[Visit]
) -> dict[str, Any]:
    """The figures of one change."""
    right = [one for one in known if one.right]
    after = [one.located_after_m for one in right if one.located_after_m is not None]
    along = np.concatenate([one.along_m for one in right]) if right else np.zeros(0)
    false = sum(one.located and not one.right for one in known)
    return {
        "change_percent": change,
        "matcher": matcher,
        "runs": len(known),
        "right": len(right),
        "right_within_20_m": sum(metres <= WITHIN for metres in after),
        "false_on_known_ground": false,
        "strangers": len(strangers),
        "false_on_strangers": sum(one.located for one in strangers),
        "located_after_m_median": float(np.median(after)) if after else None,
        "along_cm_rms": 100 * float(np.sqrt(np.mean(along**2))) if len(along) else None,
        "along_cm_median": 100 * float(np.median(np.abs(along))) if len(along) else None,
    }


def main() -> None:
    """Runs the command line."""
    parser = command_line(__doc__, others=5)
    parser.add_argument(
        "--change",
        type=float,
        nargs="+",
        default=[0.0, 10.0, -10.0],
        metavar="PERCENT",
        help="of the permittivity (0 10 -10); strangers are tried at the first one",
    )
    parser.add_argument(
        "--beside", action=argparse.BooleanOptionalAction, default=True, help="see above"
    )
    args = parser.parse_args()
    with temporary_folder() as folder:
        others = folder / "others.map"
        remember_others(args.others, others)
        work = partial(
            run_one, changes=args.change, others=others, sets=args.overrides, beside=args.beside
        )
        runs = each_drive(work, args)
    figures = []
    for i, change in enumerate(args.change):
        all_of = [run[i] for run in runs]
        strangers = [one.stranger for one in all_of if one.stranger is not None]
        figures.append(summarise(change, "now", [one.known for one in all_of], strangers))
        before = [one.before for one in all_of if one.before is not None]
        if before:
            figures.append(summarise(change, "before", before, []))
    drives = [asdict(one) for run in runs for one in run]
    print_figures(args, {"figures": figures, "drives": drives}, table_of(figures))


if __name__ == "__main__":
    exit_with(main)
