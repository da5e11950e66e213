"""The wheel's scale from two fixes 90 m apart, on drives that are simulated."""

from __future__ import annotations

import argparse
import math
from typing import Any

import numpy as np

import gprodom
from gprodom.random_streams import stream
from gprodom.simulate.drive import Bend, DriveSpec, Move, Stop, Track
from gprodom.simulate.recording import as_recording
from gprodom.simulate.sequence import Simulated, Spec, simulate
from program import seeds_of

APART_M = 90.0
SIGMA_M = 0.02
BESIDE_S = 2.0  # after the first fix the robot drives off; it has stood as long before the second
AFTER_S = 8.0  # until the graph has been solved with the second, and STATUS tells it


def drive(seed: int) -> Simulated:
    """A standstill, 90 m straight on with a weave, a standstill."""
    steps = (Stop(6.0), Move(APART_M, 0.8), Stop(BESIDE_S + AFTER_S))
    track = Track((Bend(APART_M + 2.0),), weave=0.04)
    return simulate(Spec(DriveSpec(track, steps), ground=None, station=None), seed)


def limit(run: Simulated) -> float:
    """Standard deviation that two such fixes and the prior leave to the scale: that of a distance
    between two points, with the wheel's own noise over the way. Of a wheel that cannot slip."""
    noise = math.hypot(math.sqrt(2) * SIGMA_M, run.spec.wheel.noise * math.sqrt(APART_M))
    by_fixes = noise / APART_M
    return 1 / math.sqrt(1 / by_fixes**2 + 1 / run.spec.wheel.scale_sigma**2)


def one(seed: int, overrides: list[str]) -> dict[str, Any]:
    """Its scale and sigma at the end, beside the true one."""
    run = drive(seed)
    recording, random = as_recording(run), stream(seed, "two fixes")
    begin = run.imu_utime[0] + round((6.0 - BESIDE_S) * 1e6)
    end = run.imu_utime[-1] - round(AFTER_S * 1e6)
    found: dict[str, Any] = {"seed": seed, "limit": limit(run)}
    true = float(run.wheel.scale[-1])
    for fixes in (False, True):
        estimator = gprodom.Odometry(set=["gpr.enabled=false", *overrides])
        outputs, since = [], 0
        for moment in (int(begin), int(end), None):
            until = moment or np.iinfo(np.int64).max
            outputs.append(estimator.run(**recording.messages(since, until)))
            if moment and fixes:
                motion = run.motion_at(np.array([moment]))
                place = np.array([motion.x[0], motion.y[0], 0.0])
                place += SIGMA_M * random.standard_normal(3)
                estimator.add_fix(moment * 1000, place, SIGMA_M**2 * np.eye(3), quality=4)
            since = until
        name = "" if fixes else "_without"
        odometry = outputs[-1].odometry
        scale, sigma = (float(value) for value in odometry["wheel_scale"][-1])
        if fixes:
            values = [status["values"] for out in outputs for status in out.status]
            scale, sigma = (values[-1][f"fixes.wheel_scale{each}"] for each in ("", "_sigma"))
        off = scale - true
        found |= {f"sigma{name}": sigma, f"error{name}": off, f"nees{name}": (off / sigma) ** 2}
    found["sigma_over_limit"] = found["sigma"] / found["limit"]
    return found


def run(args: argparse.Namespace) -> list[dict[str, Any]]:
    """A row for each seed, and their mean; then the mean of the same drives where no slip is
    expected, as by the limit."""
    rows = [one(seed, args.overrides) for seed in seeds_of(args)]
    sure = [one(seed, [*args.overrides, "wheel.slip_share=0"]) for seed in seeds_of(args)]
    return [*rows, mean_of("mean", rows), mean_of("mean, no slip", sure)]


def mean_of(name: str, rows: list[dict[str, Any]]) -> dict[str, Any]:
    """Of each column."""
    columns = (key for key in rows[0] if key != "seed")
    return {"seed": name} | {key: float(np.mean([row[key] for row in rows])) for key in columns}
