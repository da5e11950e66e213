"""The effect of a fault on the poses and their error, and what STATUS reported."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from gprodom.arrays import Ints
from gprodom.benchmark.motion import rmse
from gprodom.errors import Error
from gprodom.lcm import logs
from gprodom.trajectory import Trajectory, without_repeats

# Values of STATUS that any run has; the others are counts of what went wrong.
ORDINARY = ("solver.", "radar.", "states", "displacements.", "odom.", "revisits.", "map.")


def read_poses(log: Path, channel: str) -> Trajectory:
    """Poses of a channel in the order published."""
    told = logs.read(log, [channel]).get(channel)
    if told is None:
        return Trajectory(np.zeros(0, np.int64), np.zeros((0, 3)), np.zeros((0, 4)))
    return Trajectory(told["utime"], told["position"], told["orientation"])


def all_finite(log: Path) -> bool:
    """Whether every number published is finite."""
    read = logs.read(log, ["ODOMETRY", "ODOMETRY_MAP", "CORRECTION"])
    return all(
        bool(np.all(np.isfinite(values)))
        for channel in read.values()
        for values in channel.values()
        if isinstance(values, np.ndarray) and values.dtype.kind == "f"
    )


def statuses(log: Path) -> tuple[Ints, list[Any]]:
    """Stamps and messages of STATUS."""
    told = logs.read(log, ["STATUS"]).get("STATUS")
    return (np.zeros(0, np.int64), []) if told is None else (told["utime"], told["messages"])


def said_in(messages: list[Any]) -> dict[str, float]:
    """How many of the messages gave a reason, by reason, and the largest value of each count."""
    said: dict[str, float] = {}
    for m in messages:
        for reason in m.reasons:
            if m.health != m.OK:
                key = "health: " + reason
                said[key] = said.get(key, 0) + 1
        for name, value in zip(m.names, m.values, strict=True):
            if not name.startswith(ORDINARY):
                said[name] = max(said.get(name, 0.0), value)
    return said


def error_m(log: Path, truth: Trajectory, begin: float, jump: float) -> float:
    """Position RMSE; NaN where there are too few poses with the truth's times.

    Clocks that jumped at `begin` (us): by the poses' stamps or by those less the jump, whichever
    the poses follow.
    """
    poses = read_poses(log, "ODOMETRY_MAP")
    clocks = [poses.time]
    if jump:
        since = poses.time > begin + max(jump, 0.0)
        clocks.append(poses.time - np.where(since, round(jump), 0))
    errors = [_rmse(replace(poses, time=time), truth) for time in clocks]
    return min((error for error in errors if np.isfinite(error)), default=float("nan"))


def _rmse(poses: Trajectory, truth: Trajectory) -> float:
    within = (poses.time >= truth.time[0]) & (poses.time <= truth.time[-1])
    if np.sum(within) < 0.9 * len(poses) or not within.any():  # they follow another clock
        return float("nan")
    try:
        return rmse(without_repeats(poses), truth)
    except Error:
        return float("nan")


def judge(log: Path, truth: Trajectory, begin: int, end: float, jump: float) -> dict[str, Any]:
    """The outcome of a replay whose fault lasted from `begin` to `end` (us).

    error_m: position RMSE in `map`, as published, aligned in the plane; NaN without enough poses.
    finite, monotone: every pose of ODOMETRY and ODOMETRY_MAP is finite and later than the one
      before.
    silent_s: longest time without a pose, from the first on.
    said: reasons and counts of STATUS. recovered_s: from the fault's end until STATUS was well.
    """
    times, messages = statuses(log)
    steps = np.diff(read_poses(log, "ODOMETRY").time)
    in_map = np.diff(read_poses(log, "ODOMETRY_MAP").time)
    unwell = [
        t for t, m in zip(times.tolist(), messages, strict=True) if m.health != m.OK and t > begin
    ]
    recovered = max(0.0, (unwell[-1] - end) * 1e-6) if unwell else 0.0
    return {
        "error_m": error_m(log, truth, begin, jump),
        "finite": all_finite(log),
        "monotone": bool(np.all(steps > 0) and np.all(in_map > 0)),
        "silent_s": float(steps.max()) * 1e-6 if len(steps) else float("inf"),
        "said": said_in(messages),
        "recovered_s": recovered if np.isfinite(recovered) else 0.0,
    }


def news(faulty: dict[str, float], clean: dict[str, float]) -> list[str]:
    """What STATUS said that it does not say, or not as often, without the fault."""
    return [name for name, count in faulty.items() if count > clean.get(name, 0.0)]
