"""The effect of a fault on the poses and their error, and what STATUS reported."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from gprodom import rotation
from gprodom.arrays import Floats, Ints
from gprodom.errors import Error
from gprodom.lcm import logs
from gprodom.score.align import FIRST_M
from gprodom.score.associate import associate
from gprodom.score.figures import compare
from gprodom.trajectory import Trajectory, without_repeats

# Values of STATUS that any run has; the others are counts of what went wrong.
ORDINARY = ("solver.", "radar.", "states", "displacements.", "odom.", "revisits.", "map.")


@dataclass(frozen=True)
class Outcome:
    """Of one replay.

    error_m: position RMSE in `map`, as published, aligned in the plane; NaN without enough poses.
    finite, monotone: every pose of ODOMETRY and ODOMETRY_MAP is finite and later than the one
      before.
    silent_s: longest time without a pose, from the first on.
    said: reasons and counts of STATUS. recovered_s: from the fault's end until STATUS was well.
    """

    error_m: float
    finite: bool
    monotone: bool
    silent_s: float
    said: dict[str, float]
    recovered_s: float

    def as_dict(self) -> dict[str, Any]:
        """By name."""
        return asdict(self)


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


def error_m(log: Path, truth: Trajectory) -> float:
    """Position RMSE; NaN where there are too few poses with the truth's times."""
    poses = read_poses(log, "ODOMETRY_MAP")
    if len(poses) == 0:
        return float("nan")
    try:
        pairs = associate(without_repeats(poses), truth)
        return compare(pairs, "se2", FIRST_M).figures.ate_rmse_m
    except Error:
        return float("nan")


def judge(log: Path, truth: Trajectory, begin: int, end: float) -> Outcome:
    """The outcome of a replay whose fault lasted from `begin` to `end` (us)."""
    times, messages = statuses(log)
    said = said_in(messages)
    poses = read_poses(log, "ODOMETRY")
    steps = np.diff(poses.time)
    in_map = np.diff(read_poses(log, "ODOMETRY_MAP").time)
    monotone = bool(np.all(steps > 0) and np.all(in_map > 0))
    unwell = [
        t for t, m in zip(times.tolist(), messages, strict=True) if m.health != m.OK and t > begin
    ]
    recovered = max(0.0, (unwell[-1] - end) * 1e-6) if unwell else 0.0
    return Outcome(
        error_m=error_m(log, truth),
        finite=all_finite(log),
        monotone=monotone,
        silent_s=float(steps.max()) * 1e-6 if len(steps) else float("inf"),
        said=said,
        recovered_s=recovered if np.isfinite(recovered) else 0.0,
    )


def news(faulty: dict[str, float], clean: dict[str, float]) -> list[str]:
    """What STATUS said that it does not say, or not as often, without the fault."""
    return [name for name, count in faulty.items() if count > clean.get(name, 0.0)]


def growth(poses: Trajectory, truth: dict[str, Floats], begin: int, metres: float) -> Floats:
    """Relative position errors (m) over stretches of 5 m, from the first pose after `begin` (us).

    The stretches begin half a metre apart, for `metres`, and each is held against the truth with
    place and heading aligned where it begins: what a gap has lost of them is not counted again.
    Truth: t (s), x, y, yaw, and s along the track.
    """
    published = poses.time[np.searchsorted(poses.time, begin) :]
    if len(published) == 0:
        return np.zeros(0)
    begin = int(published[0])
    t = truth["t"]
    travelled = np.concatenate([[0], np.cumsum(np.hypot(np.diff(truth["x"]), np.diff(truth["y"])))])
    start = np.interp(begin * 1e-6, t, travelled)
    cuts = np.arange(start, start + metres - 5.0 + 1e-9, 0.5)
    if start + metres > travelled[-1]:
        return np.zeros(0)
    driving = np.concatenate([[True], np.diff(travelled) > 1e-6])  # a time for each place
    errors = []
    for a, b in zip(cuts, cuts + 5.0, strict=True):
        times = np.interp([a, b], travelled[driving], t[driving])
        xy = np.stack([np.interp(times, t, truth[k]) for k in "xy"], axis=1)
        yaw = np.interp(times, t, np.unwrap(truth["yaw"]))
        right = np.searchsorted(poses.time * 1e-6, times)
        if right[-1] >= len(poses):
            return np.zeros(0)
        ours_xy = poses.position[right, :2]
        assert poses.orientation is not None
        ours_yaw = float(rotation.yaw_of(poses.orientation[right[:1]])[0])
        errors.append(
            np.linalg.norm(
                _turned(ours_xy[1] - ours_xy[0], -ours_yaw) - _turned(xy[1] - xy[0], -yaw[0])
            )
        )
    return np.array(errors)


def _turned(vector: Floats, angle: float) -> Floats:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([c * vector[0] - s * vector[1], s * vector[0] + c * vector[1]])
