"""The estimator in-process on simulated drives: its errors, and whether its covariance is true."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

import gprodom
from gprodom.errors import Error
from gprodom.simulate.drives import plain_drive, robot_drive
from gprodom.simulate.recording import as_recording, side_distances
from gprodom.simulate.robot import KINDS
from gprodom.simulate.sequence import Simulated

BAND = 0.99  # of chi-square, in which a mean should lie


@dataclass(frozen=True)
class End:
    """Error and covariance at the end of one run: x, y (m), yaw (rad)."""

    seed: int
    error: tuple[float, float, float]
    covariance: list[list[float]]  # of x, y, yaw

    @property
    def nees_xy(self) -> float:
        """Normalised squared error of the position."""
        error, covariance = np.array(self.error[:2]), np.array(self.covariance)[:2, :2]
        return float(error @ np.linalg.solve(covariance, error))

    @property
    def nees_yaw(self) -> float:
        """Normalised squared error of the yaw."""
        return self.error[2] ** 2 / self.covariance[2][2]


def end_of_drive(
    seed: int, overrides: Sequence[str] = (), kind: str | None = None, surface: str = "floor"
) -> End:
    """Of a plain drive, or of one of `KINDS` on a surface; the truth placed by its first pose."""
    simulated = robot_drive(seed, kind, surface) if kind else plain_drive(seed)
    sensors, settings = as_recording(simulated).messages(), list(overrides)
    if kind:
        sensors["wheel_distance"] = side_distances(simulated)
        settings = ["gpr.enabled=false", *KINDS[kind].settings, *overrides]
    odometry = gprodom.Odometry(set=settings).run(**sensors).odometry
    if not len(odometry["time"]):
        raise Error(f"seed {seed}: no odometry")
    w, x, y, z = odometry["orientation"][-1]
    yaw = math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
    ends = odometry["time"][[0, -1]] // 1000
    dx, dy = odometry["position"][-1, :2] - simulated.position_from(ends[0], ends)[1]
    turned = np.diff(simulated.motion_at(ends).yaw)[0]
    error = (float(dx), float(dy), math.remainder(yaw - turned, 2 * math.pi))
    rows = np.ix_([0, 1, 5], [0, 1, 5])
    covariance = odometry["pose_covariance"][-1].reshape(6, 6)[rows]
    return End(seed, error, covariance.tolist())


def judge(nees: Sequence[float], freedom: int) -> dict[str, Any]:
    """Mean of `nees` of so many degrees of freedom, and the band it lies in where it is true."""
    from scipy.stats import chi2

    count = len(nees)
    tail = 0.5 * (1 - BAND)
    low, high = chi2.ppf([tail, 1 - tail], count * freedom) / count
    mean = float(np.mean(nees))
    inside = bool(low <= mean <= high)
    return {"mean": mean, "low": float(low), "high": float(high), "inside": inside}


def estimate_told(
    run: Simulated, overrides: Sequence[str] = (), told: Sequence[dict[str, Any]] = ()
) -> list[Any]:
    """The outputs up to each time at which the estimator is told something, and to the end.

    told: arguments of `gprodom.Odometry.add_displacement`, in time order.
    """
    estimator = gprodom.Odometry(set=list(overrides))
    recording = as_recording(run)
    outputs, since = [], 0
    for message in [*told, None]:
        until = message["time"] // 1000 if message else np.iinfo(np.int64).max
        outputs.append(estimator.run(**recording.messages(since, until)))
        if message:
            estimator.add_displacement(**message)
        since = until
    return outputs
