#!/usr/bin/env python3
"""What two sessions become when their maps are merged, and that a stranger's map changes nothing.

Each run draws everything from a seed, as bench/changed_ground.py does: a drive of some 65 m, and on
another day the same route, some centimetres aside, by another wheel and radar, on ground whose
permittivity has changed. Each day's map is saved, and both are merged, either way. A third map is
of the same route on ground of its own: a stranger's.

    error    of the poses in the map, RMS, the truth being placed by where the first map's frame
             lies (before: each day's map by its own)
    NEES     of the position at the end of the drive (2 where the covariance is right), by that of
             the join, of the day that joins the other, at its last place where ground is stored

    bench/merge.py --runs 40 --change 0 10
    bench/merge.py --runs 2 --change 10 --json
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

import gprodom
from changed_ground import STRANGER, another_day
from gprodom.arrays import Bools, Floats
from gprodom.files import temporary_folder
from gprodom.map.ground import MapFile, read_map
from gprodom.simulate import Simulated
from gprodom.simulate.recording import as_recording
from program import exit_with, list_of, print_figures
from relocation import command_line, each_drive, placed, simulated


@dataclass(frozen=True)
class Session:
    """The map of a drive."""

    run: Simulated
    file: MapFile
    origin: int  # time (us) of the pose at which the frame lies

    def truth(self, time: Any, frame: Session) -> Floats:
        """Position of the robot at times (ns), in the frame of a map."""
        return placed(self.run, np.asarray(time) // 1000, frame.run, frame.origin)


def drive(run: Simulated, path: Path, sets: list[str]) -> Session:
    """Drives, and saves the map."""
    estimator = gprodom.Odometry(set=sets)
    outputs = estimator.run(**as_recording(run).messages())
    estimator.reset()  # what was driven last is in the map, too
    estimator.save_map(str(path))
    return Session(run, read_map(path), int(outputs.odometry["time"][0]) // 1000)


def rms(off: Floats) -> float:
    """Of distances."""
    return float(np.sqrt(np.mean(np.sum(off**2, axis=1))))


def nees(off: Floats, covariance: Floats) -> float:
    """Of a position."""
    return float(off @ np.linalg.solve(covariance, off))


def at_columns(file: MapFile) -> Bools:
    """Of the places those that lie at their column, whose time is known. A place at which no ground
    was stored has the nearest column, half a metre off at most."""
    runs, column = file.runs, file.places["column"]
    run = np.searchsorted(runs["first"], column, side="right") - 1
    along = file.ground.spacing * (column - runs["first"][run])
    distance = runs["distance"][run] + runs["direction"][run] * along
    return np.asarray(np.abs(distance - file.places["distance"]) < 1.5 * file.ground.spacing)


def errors(one: Session, found: Floats, frame: Session) -> Floats:
    """Of the places of a map, whose positions are given in the frame of another one."""
    chosen = at_columns(one.file)
    return found[chosen] - one.truth(one.file.places["time"][chosen], frame)


def error_before(one: Session) -> Floats:
    """Of the poses in a day's own map."""
    places = one.file.places
    return errors(one, np.column_stack([places["x"], places["y"]]), one)


def error_after(first: Session, second: Session, join: dict[str, Any]) -> tuple[Floats, Floats]:
    """Of the poses of both days, where the second has joined the first."""
    found = np.column_stack([join["x"], join["y"]])
    count = len(first.file.places["x"])
    return errors(first, found[:count], first), errors(second, found[count:], first)


def run_one(seed: int, changes: list[float], sets: list[str]) -> list[dict[str, Any]]:
    """Two days and a stranger's, at each change."""
    with temporary_folder() as work:
        first_run = simulated(seed)
        first = drive(first_run, work / "first.map", sets)
        found = []
        for change in changes:
            days = first, drive(another_day(first_run, change, seed), work / "second.map", sets)
            away = another_day(first_run, change, STRANGER + seed)
            found.append(compare(days, drive(away, work / "away.map", sets)))
        return found


def compare(days: tuple[Session, Session], away: Session) -> dict[str, Any]:
    """Merges both days, either way, and a stranger's with the first. Of each of the two days; and
    the most by which a pose of the first map has moved by a stranger's."""
    joins = [a.file.ground.merged(b.file.ground)["joins"][0] for a, b in (days, days[::-1])]
    proven = [bool(join["proven"]) for join in joins]
    after, ends = [], []
    if proven[0]:
        after = [rms(off) for off in error_after(*days, joins[0])]
    for (a, b), join in zip((days, days[::-1]), joins, strict=True):
        if join["proven"]:
            covariance = np.reshape(join["covariance"], (3, 3))[:2, :2]
            ends.append(nees(error_after(a, b, join)[1][-1], covariance))
    stranger = days[0].file.ground.merged(away.file.ground)
    kept, places = stranger["ground"].places(), days[0].file.places
    moved = np.hypot(kept["x"] - places["x"], kept["y"] - places["y"])
    return {
        "proven": proven,
        "before_m": [rms(error_before(day)) for day in days],
        "after_m": after,
        "nees_after": ends[::-1],  # the first day joins the second in the second way
        "stranger_joined": any(join["proven"] for join in stranger["joins"]),
        "stranger_changed_m": float(moved.max()),
    }


def summarise(change: float, runs: list[dict[str, Any]]) -> dict[str, Any]:
    """The figures of one change."""
    joined = [one for one in runs if all(one["proven"])]
    figures: dict[str, Any] = {
        "change_percent": change,
        "runs": len(runs),
        "proven": len(joined),
        "strangers_joined": sum(one["stranger_joined"] for one in runs),
        "moved_by_strangers_m": max(one["stranger_changed_m"] for one in runs),
    }
    for name in ("before_m", "after_m", "nees_after"):
        mean = np.mean([one[name] for one in joined], axis=0).tolist() if joined else None
        figures[name] = mean
    return figures


def main() -> None:
    """Runs the command line."""
    parser = command_line(__doc__, others=0)
    parser.add_argument(
        "--change", type=float, nargs="+", default=[0.0, 10.0], metavar="PERCENT",
        help="of the permittivity (0 10)",
    )  # fmt: skip
    args = parser.parse_args()
    runs = each_drive(partial(run_one, changes=args.change, sets=args.overrides), args)
    figures = [summarise(change, [run[i] for run in runs]) for i, change in enumerate(args.change)]
    texts = [
        {k: ", ".join(f"{x:.4g}" for x in v) if isinstance(v, list) else v for k, v in one.items()}
        for one in figures
    ]
    print_figures(args, figures, "\n".join(map(list_of, texts)))


if __name__ == "__main__":
    exit_with(main)
