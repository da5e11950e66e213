"""GTSAM's fixed-lag smoothers on the factors of gprodom's: see bench/smoothers.py.

Of each interval: preintegrated IMU, bias random walk, the wheel's increment turned by the gyro with
what keeps a robot from moving sideways or upwards.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Any

import gtsam
import numpy as np
from gtsam.symbol_shorthand import B, V, X
from numpy.typing import NDArray

from state_intervals import FIRST_SIGMA, GRAVITY, Cut, Interval

Array = NDArray[np.float64]

UNKNOWN = 1.0  # m or rad in a tenth of a second: a standard deviation that says nothing


@dataclass(frozen=True)
class Noise:
    """As gprodom's configuration has them by default; units in config/gprodom.yaml."""

    gyro_walk: float = 1e-5
    accel_walk: float = 1e-4
    forward: float = 0.005
    lateral: float = 0.003
    vertical: float = 0.003
    floor: float = 0.0005
    integration: float = 1e-7  # m^2/s; with less GTSAM's Cholesky gives up more often


@dataclass(frozen=True)
class Updates:
    """Per update: position (n, 3), processor time (n,), s, with covariance and without."""

    position: Array
    cpu: Array
    cpu_update: Array


class Smoother:
    """One of GTSAM's. `covariance` of the newest pose, velocity and bias."""

    def __init__(self, kind: str, lag: float, factorization: str) -> None:
        self._batch = kind == "batch"
        if self._batch:
            params = gtsam.LevenbergMarquardtParams()
            params.setLinearSolverType(f"MULTIFRONTAL_{factorization}")
            self.fixed_lag = gtsam.BatchFixedLagSmoother(lag, params)
        else:
            params = gtsam.ISAM2Params()
            params.setFactorization(factorization)
            self.fixed_lag = gtsam.IncrementalFixedLagSmoother(lag, params)

    def newest(self, k: int) -> tuple[Any, Array, Any]:
        """Pose, velocity and bias of state k."""
        s = self.fixed_lag
        pose, velocity = s.calculateEstimatePose3(X(k)), s.calculateEstimateVector(V(k))
        return pose, velocity, s.calculateEstimateConstantBias(B(k))

    def covariance(self, k: int) -> list[Array] | None:
        """Of pose, velocity and bias of state k; batch has no call for it but that on the graph.

        None where Marginals, which knows Cholesky alone here, gives up.
        """
        keys = (X(k), V(k), B(k))
        if not self._batch:
            return [self.fixed_lag.marginalCovariance(key) for key in keys]
        graph, values = self.fixed_lag.getFactors(), self.fixed_lag.calculateEstimate()
        try:
            marginals = gtsam.Marginals(graph, values)
            return [marginals.marginalCovariance(key) for key in keys]
        except RuntimeError:
            return None


def sigmas(*values: Array | list[float]) -> Any:
    """A diagonal noise model."""
    return gtsam.noiseModel.Diagonal.Sigmas(np.concatenate([np.atleast_1d(v) for v in values]))


def run(whole: Cut, scale: float, lag: float, kind: str, factorization: str) -> Updates:
    """`kind`: batch or incremental. `scale`: of the wheel, reported over true.

    `factorization`: CHOLESKY, GTSAM's default, or QR. RuntimeError where it gives up.
    """
    noise = Noise()
    params = gtsam.PreintegrationParams.MakeSharedU(GRAVITY)
    params.setGyroscopeCovariance(np.eye(3) * whole.gyro_density**2)
    params.setAccelerometerCovariance(np.eye(3) * whole.accel_density**2)
    params.setIntegrationCovariance(np.eye(3) * noise.integration)

    pose = gtsam.Pose3(gtsam.Rot3.Quaternion(*whole.orientation), np.zeros(3))
    velocity = np.zeros(3)
    bias = gtsam.imuBias.ConstantBias(np.zeros(3), whole.gyro_bias)
    graph, values = gtsam.NonlinearFactorGraph(), gtsam.Values()
    graph.push_back(gtsam.PriorFactorPose3(X(0), pose, sigmas(FIRST_SIGMA[:6])))
    graph.push_back(gtsam.PriorFactorVector(V(0), velocity, sigmas(FIRST_SIGMA[6:9])))
    first_bias = sigmas(FIRST_SIGMA[12:15], FIRST_SIGMA[9:12])  # accelerometer, gyro
    graph.push_back(gtsam.PriorFactorConstantBias(B(0), bias, first_bias))
    begin = whole.time
    insert(values, 0, pose, velocity, bias)
    stamps = dict.fromkeys((X(0), V(0), B(0)), 0.0)

    smoother = Smoother(kind, lag, factorization)
    positions, times = [], []
    for k, interval in enumerate(whole.intervals, start=1):
        state = gtsam.NavState(pose, velocity)
        pim = preintegrate(params, bias, interval)
        add_factors(graph, k, interval, pim, state, bias, scale, noise)
        predicted = pim.predict(state, bias)
        insert(values, k, predicted.pose(), predicted.velocity(), bias)
        stamps.update(dict.fromkeys((X(k), V(k), B(k)), (interval.time - begin) * 1e-9))
        clocks = [time.process_time()]
        smoother.fixed_lag.update(graph, values, stamps)
        pose, velocity, bias = smoother.newest(k)
        clocks.append(time.process_time())
        smoother.covariance(k)
        clocks.append(time.process_time())
        times.append(clocks)
        positions.append(pose.translation())
        graph, values, stamps = gtsam.NonlinearFactorGraph(), gtsam.Values(), {}
    begin_s, updated_s, end_s = np.array(times).T
    return Updates(np.array(positions), end_s - begin_s, updated_s - begin_s)


def insert(values: Any, k: int, pose: Any, velocity: Array, bias: Any) -> None:
    """State k."""
    values.insert(X(k), pose)
    values.insert(V(k), velocity)
    values.insert(B(k), bias)


def preintegrate(params: Any, bias: Any, interval: Interval) -> Any:
    """The IMU over an interval."""
    pim = gtsam.PreintegratedImuMeasurements(params, bias)
    for dt, force, rate in zip(interval.dt, interval.force, interval.rate, strict=True):
        pim.integrateMeasurement(force, rate, dt)
    return pim


def add_factors(
    graph: Any,
    k: int,
    interval: Interval,
    pim: Any,
    state: Any,
    bias: Any,
    scale: float,
    noise: Noise,
) -> None:
    """Between state k - 1, estimated as `state` and `bias`, and state k."""
    root_dt = float(np.sqrt(np.sum(interval.dt)))
    graph.push_back(gtsam.ImuFactor(X(k - 1), V(k - 1), X(k), V(k), B(k - 1), pim))
    walk = sigmas([noise.accel_walk * root_dt] * 3, [noise.gyro_walk * root_dt] * 3)
    still_bias = gtsam.imuBias.ConstantBias()
    graph.push_back(gtsam.BetweenFactorConstantBias(B(k - 1), B(k), still_bias, walk))
    speed = float(state.attitude().unrotate(state.velocity())[0])
    wheel = interval.wheel / scale if interval.has_wheel else speed * interval.dt
    turned, moved = gtsam.Rot3(), np.zeros(3)
    for dt, rate, distance in zip(interval.dt, interval.rate, wheel, strict=True):
        turn = (rate - bias.gyroscope()) * dt
        moved += turned.compose(gtsam.Rot3.Expmap(0.5 * turn)).matrix()[:, 0] * distance
        turned = turned.compose(gtsam.Rot3.Expmap(turn))
    path = float(np.sum(np.abs(wheel))) * scale
    across = [np.sqrt(s**2 * path + noise.floor**2) for s in (noise.lateral, noise.vertical)]
    ahead = np.sqrt(noise.forward**2 * path + noise.floor**2) / scale
    sigma = sigmas([UNKNOWN] * 3, [ahead if interval.has_wheel else UNKNOWN, *across])
    increment = gtsam.Pose3(turned, moved)
    graph.push_back(gtsam.BetweenFactorPose3(X(k - 1), X(k), increment, sigma))
