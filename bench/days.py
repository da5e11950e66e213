#!/usr/bin/env python3
"""Drives on other days: does the map of an earlier drive help, and is it ever taken wrongly?

FOLDER holds sequences in CMU-GPR format, as they are: zips named TIME-0-SCENE-cmu-gpr.zip, those of
a SCENE over the same ground (a robot need not drive the same route). The first of a scene makes the
map; each later one begins with it, and is run without it, too. A row each:

    located    after so many metres driven (none: not located in it)
    error      RMSE of position from there on, aligned in the plane, m, with the map and without
    NEES       of x and y with the map, likewise; 2 is right

With --strangers the map is that of the next scene: to be located in it is false.

    bench/days.py FOLDER [--strangers] [-j 2] [--json]
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any

from estimates import planar_figures, run_method
from gprodom.errors import Error
from gprodom.files import temporary_folder
from gprodom.odometry.estimate import Estimate
from gprodom.score.figures import Figures
from gprodom.score.frames import in_last_frame
from gprodom.score.record import scene_of
from gprodom.score.sources import read_truth
from gprodom.trajectory import Trajectory
from program import exit_with, in_processes, parser_of, print_rows
from zips import log_of, sequences_of

METHOD = "gprodom_full"


def pairs_of(sequences: Sequence[Path], strangers: bool) -> list[tuple[Path, Path]]:
    """(whose map, who begins with it). Without two of a scene, or two scenes, there are none."""
    scenes: dict[str, list[Path]] = {}
    for path in sequences:
        scenes.setdefault(scene_of(path.stem), []).append(path)
    names = list(scenes)
    if strangers:
        following = zip(names, [*names[1:], *names[:1]], strict=True)
        return [(scenes[b][0], drive) for a, b in following if a != b for drive in scenes[a]]
    return [(drives[0], later) for drives in scenes.values() for later in drives[1:]]


def run(pair: tuple[Path, Path], overrides: Sequence[str]) -> dict[str, Any]:
    """Of one pair; the drive without the map is scored from where it was located with it."""
    first, second = pair
    with temporary_folder() as folder:
        state = folder / "state"
        state.mkdir()

        def estimated(source: Path, *settings: str) -> Estimate:
            log, output = log_of(source, folder), folder / "out.lcmlog"
            return run_method(log, METHOD, output, [*settings, *overrides])

        estimated(first, f"state.directory={state}")
        if not (state / "ground.map").is_file():
            raise Error(f"{first.name}: has left no map")
        known = (f"state.directory={state}", "state.map=read_only")
        informed, alone = estimated(second, *known), estimated(second)
    located = informed.frame
    truth = read_truth(second).trajectory

    def figures(path: Trajectory) -> Figures:
        return planar_figures(in_last_frame(path, located), truth)

    told = figures(informed.trajectory)
    return {
        "sequence": second.stem,
        "map_of": first.stem,
        "located_after_m": located.driven_m if located else None,
        "with_map_m": told.ate_rmse_m,
        "without_m": figures(alone.trajectory).ate_rmse_m,
        "nees_xy": told.nees_xy,
    }


def main() -> None:
    """Runs the command line."""
    parser = parser_of(__doc__, jobs=2, overrides=True)
    parser.add_argument("sequences", metavar="FOLDER", type=Path, nargs="+")
    parser.add_argument("--strangers", action="store_true", help="maps of other scenes")
    args = parser.parse_args()
    pairs = pairs_of(sequences_of(args.sequences), args.strangers)
    if not pairs:
        raise Error("no two drives of a scene (with --strangers: of two scenes)")
    days = in_processes(args.jobs, "drives", partial(run, overrides=args.overrides), pairs)
    header = ["drive", "map of", "located after (m)", "error (m)", "without", "NEES x,y"]
    print_rows(args, days, header)


if __name__ == "__main__":
    exit_with(main)
