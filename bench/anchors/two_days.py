"""Two days on different ground, with fixes in one datum: do their maps become one?"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

import numpy as np

import gprodom
from gprodom.files import temporary_folder
from gprodom.map.ground import MapFile, read_map
from gprodom.random_streams import stream
from gprodom.simulate.recording import as_recording
from gprodom.simulate.sequence import Simulated
from program import seeds_of
from relocation import simulated

SIGMA_M = 0.03
EVERY_S = 1.0
APART_M = np.array([60.0, 25.0])  # of the second day's ground from the first's, in site
DAY_US = 86_400_000_000


def truth(run: Simulated, utime: Any, place: Any) -> Any:
    """Positions (n, 2) in site."""
    motion = run.motion_at(utime)
    return np.column_stack([motion.x, motion.y]) + place


def drive(run: Simulated, late_us: int, place: Any, path: Path, sets: list[str]) -> MapFile:
    """Drives with fixes, and saves the map."""
    estimator, recording = gprodom.Odometry(set=sets), as_recording(run)
    random, since = stream(run.seed, "fixes of a day"), 0
    moments = np.arange(run.imu_utime[0], run.imu_utime[-1], round(EVERY_S * 1e6))
    for moment in [*moments.tolist(), np.iinfo(np.int64).max]:
        told = recording.messages(since, moment)
        for time in ("imu_time", "wheel_time", "gpr_time"):
            told[time] = told[time] + late_us * 1000
        estimator.run(**told)
        if moment < np.iinfo(np.int64).max:
            x, y = truth(run, np.array([moment]), place)[0] + SIGMA_M * random.standard_normal(2)
            cov = SIGMA_M**2 * np.eye(3)
            estimator.add_fix(int(moment + late_us) * 1000, np.array([x, y, 0.0]), cov)
        since = moment
    estimator.reset()
    estimator.save_map(str(path))
    return read_map(path)


def one(seed: int, sets: list[str]) -> dict[str, Any]:
    """Both days of a seed; `error_m` of all poses in site, where the maps were joined."""
    runs = simulated(seed), simulated(seed + 500)
    places = np.zeros(2), APART_M
    with temporary_folder() as folder:
        files = [
            drive(run, day * DAY_US, place, folder / f"{day}.map", sets)
            for day, (run, place) in enumerate(zip(runs, places, strict=True))
        ]
    join = files[0].ground.merged(files[1].ground)["joins"][0]
    found: dict[str, Any] = {"seed": seed, "joined": bool(join["proven"]), "error_m": None}
    if found["joined"]:
        known = [
            truth(run, file.places["time"] // 1000 - day * DAY_US, place)
            for day, (run, file, place) in enumerate(zip(runs, files, places, strict=True))
        ]
        off = np.column_stack([join["x"], join["y"]]) - np.vstack(known)
        found["error_m"] = float(np.sqrt(np.mean(np.sum(off**2, axis=1))))
    return found


def run(args: argparse.Namespace) -> list[dict[str, Any]]:
    """A row for each seed."""
    return [one(seed, args.overrides) for seed in seeds_of(args)]
