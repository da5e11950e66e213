"""The estimator in-process on simulated drives: its errors, and whether its covariance is right."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

import gprodom
from gprodom import rotation
from gprodom.arrays import Floats, Ints
from gprodom.errors import Error
from gprodom.odometry.causal_yaw import causal_yaw
from gprodom.odometry.dead_reckoning import integrate
from gprodom.score.align import FIRST_M
from gprodom.score.associate import associate
from gprodom.score.figures import compare
from gprodom.simulate.drives import plain_drive, robot_drive
from gprodom.simulate.recording import as_recording, side_distances
from gprodom.simulate.robot import KINDS
from gprodom.simulate.sequence import Simulated
from gprodom.trajectory import Trajectory

BAND = 0.99  # of chi-square, in which a mean should lie


@dataclass(frozen=True)
class End:
    """Error and covariance at the end of one run: x, y (m), yaw (rad).

    rmse_m, reckoned_m: error of all poses, aligned by se2, and that of dead reckoning.
    """

    seed: int
    error: tuple[float, float, float]
    covariance: list[list[float]]  # of x, y, yaw
    rmse_m: float
    reckoned_m: float

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
    """End of a plain drive, or of one of `KINDS` on a surface, with the first poses made equal."""
    simulated = robot_drive(seed, kind, surface) if kind else plain_drive(seed)
    sensors, settings = as_recording(simulated).messages(), list(overrides)
    if kind:
        sensors["wheel_distance"] = side_distances(simulated)
        settings = ["gpr.enabled=false", *KINDS[kind].settings, *overrides]
    odometry = gprodom.Odometry(set=settings).run(**sensors).odometry
    if not len(odometry["time"]):
        raise Error(f"seed {seed}: no odometry")
    yaw = float(rotation.yaw_of(odometry["orientation"][-1]))
    ends = odometry["time"][[0, -1]] // 1000
    dx, dy = odometry["position"][-1, :2] - simulated.position_from(ends[0], ends)[1]
    turned = np.diff(simulated.motion_at(ends).yaw)[0]
    error = (float(dx), float(dy), math.remainder(yaw - turned, 2 * math.pi))
    rows = np.ix_([0, 1, 5], [0, 1, 5])
    covariance = odometry["pose_covariance"][-1].reshape(6, 6)[rows]
    found = Trajectory(odometry["time"] // 1000, odometry["position"])
    reckoned = integrate(*_reckoning(simulated))
    rmse, reckoned_rmse = (_rmse(simulated, each) for each in (found, reckoned))
    return End(seed, error, covariance.tolist(), rmse, reckoned_rmse)


def _reckoning(simulated: Simulated) -> tuple[Ints, Floats, Ints, Floats]:
    """Time and distance of the wheel (of a pair the mean), time and yaw of the gyro, causal."""
    time, imu = simulated.wheel_utime, simulated.imu
    if simulated.pair is not None:
        distance = side_distances(simulated).mean(axis=1)
    else:
        distance = simulated.wheel.ticks * simulated.spec.wheel.quantum
    yaw = causal_yaw(simulated.imu_utime, imu.acceleration, imu.angular_velocity, time, distance)
    return time, distance, simulated.imu_utime, yaw


def _rmse(simulated: Simulated, found: Trajectory) -> float:
    truth = simulated.truth
    position = np.column_stack([truth.x, truth.y, np.zeros(len(truth.x))])
    pairs = associate(found, Trajectory(simulated.truth_utime, position))
    return compare(pairs, "se2", FIRST_M).figures.ate_rmse_m


def judge(nees: Sequence[float], freedom: int, band: float = BAND) -> dict[str, Any]:
    """Mean of `nees` with these degrees of freedom, and the band of a right covariance."""
    from scipy.stats import chi2

    count = len(nees)
    tail = 0.5 * (1 - band)
    low, high = chi2.ppf([tail, 1 - tail], count * freedom) / count
    mean = float(np.mean(nees))
    inside = bool(low <= mean <= high)
    return {"mean": mean, "low": float(low), "high": float(high), "inside": inside}


def estimate_told(
    run: Simulated, overrides: Sequence[str] = (), told: Sequence[dict[str, Any]] = ()
) -> list[Any]:
    """The outputs up to each time of a displacement from outside, and to the end.

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
