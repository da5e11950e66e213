"""The effect of a fault on the poses and their error, and what STATUS reported."""

from __future__ import annotations

import zlib
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import kinds
import numpy as np

from gprodom.benchmark.motion import rmse
from gprodom.config import Configs
from gprodom.errors import Error
from gprodom.files import temporary_folder
from gprodom.lcm import logs
from gprodom.odometry.replay import run_replay
from gprodom.score.sources import read_truth
from gprodom.trajectory import Trajectory, without_repeats
from log_events import read_events, write_events

BEGIN = 0.45  # of the run, where faults begin
POSES = ("ODOMETRY", "ODOMETRY_MAP")
# Values of STATUS that any run has; the others are counts of what went wrong.
ORDINARY = ("solver.", "radar.", "states", "displacements.", "odom.", "revisits.", "map.")


def replayed(log: Path, fault: str, combinations: int, configs: Configs) -> dict[str, Any]:
    """The outcome of a replay with that fault; empty: without one."""
    truth, messages = read_truth(log).trajectory, read_events(log)
    first, last = messages[0][0], messages[-1][0]
    begin = round(first + BEGIN * (last - first))
    with temporary_folder() as folder:
        seconds, jump, made = 0.0, 0.0, folder / "out.lcmlog"
        if fault:
            found = kinds.faults_of(combinations)[fault]
            rng = np.random.default_rng([1, zlib.crc32(fault.encode())])
            log = write_events(found.apply(messages, rng, begin), folder / "in.lcmlog")
            jump = found.jump
            seconds = (last - begin) * 1e-6 if found.seconds is None else found.seconds
        try:
            run_replay(log, made, configs, poses_needed=False)  # silence is judged too
            return judge(made, truth, begin, begin + seconds * kinds.SECOND, jump)
        except Error as error:
            return {"ended": str(error)}


def judge(log: Path, truth: Trajectory, begin: int, end: float, jump: float) -> dict[str, Any]:
    """The outcome of a replay whose fault lasted from `begin` to `end` (us).

    error_m: position RMSE in `map`, as published, aligned in the plane; NaN without enough poses.
    finite, monotone: every pose of ODOMETRY and ODOMETRY_MAP is finite and later than the one
      before.
    silent_s: longest time without a pose, from the first on.
    said: reasons and counts of STATUS. recovered_s: from the fault's end until STATUS was well.
    """
    read = logs.read(log, [*POSES, "CORRECTION", "STATUS"])
    messages = read.pop("STATUS")["messages"] if "STATUS" in read else []
    steps = [np.diff(read[name]["utime"]) if name in read else np.zeros(0) for name in POSES]
    unwell = [m.utime for m in messages if m.health != m.OK and m.utime > begin]
    recovered = max(0.0, (unwell[-1] - end) * 1e-6) if unwell else 0.0
    numbers = [
        values
        for channel in read.values()
        for values in channel.values()
        if isinstance(values, np.ndarray) and values.dtype.kind == "f"
    ]
    return {
        "error_m": error_m(read.get("ODOMETRY_MAP"), truth, begin, jump),
        "finite": all(bool(np.isfinite(values).all()) for values in numbers),
        "monotone": all(bool((each > 0).all()) for each in steps),
        "silent_s": float(steps[0].max()) * 1e-6 if len(steps[0]) else float("inf"),
        "said": said_in(messages),
        "recovered_s": recovered if np.isfinite(recovered) else 0.0,
    }


def said_in(messages: Sequence[Any]) -> dict[str, float]:
    """How many of the messages gave a reason, by reason, and the largest value of each count."""
    said: dict[str, float] = {}
    for m in messages:
        for reason in m.reasons if m.health != m.OK else ():
            said[f"health: {reason}"] = said.get(f"health: {reason}", 0) + 1
        for name, value in zip(m.names, m.values, strict=True):
            if not name.startswith(ORDINARY):
                said[name] = max(said.get(name, 0.0), value)
    return said


def error_m(told: logs.Channel | None, truth: Trajectory, begin: float, jump: float) -> float:
    """Position RMSE; NaN where there are too few poses with the truth's times.

    Clocks that jumped at `begin` (us): by the poses' stamps or by those less the jump, whichever
    the poses follow.
    """
    if told is None:
        return float("nan")
    poses = Trajectory(told["utime"], told["position"], told["orientation"])
    since = poses.time > begin + max(jump, 0.0)
    errors = []
    for clock in (poses.time, poses.time - np.where(since, round(jump), 0))[: 2 if jump else 1]:
        within = (clock >= truth.time[0]) & (clock <= truth.time[-1])
        if within.sum() >= 0.9 * len(clock) and within.any():  # else they follow another clock
            try:
                errors.append(rmse(without_repeats(replace(poses, time=clock)), truth))
            except Error:
                continue
    return min((error for error in errors if np.isfinite(error)), default=float("nan"))
