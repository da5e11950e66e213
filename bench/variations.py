"""What may differ in a recording's sensors from one robot to the next."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
from scipy.ndimage import gaussian_filter1d

from gprodom import rotation
from gprodom.arrays import Floats, Ints
from sensors import FINEST_M, Sensors, rate_hz

SHORTEST_S = 1e-3  # between samples; some recordings have two of one stamp
TURN_S = 0.05  # standard deviation of the weights
SLOW_HZ = 20.0  # to which a wheel is thinned before its stamps or samples get worse

Change = Callable[[Sensors, np.random.Generator], Sensors]


def slower_imu(s: Sensors, _: np.random.Generator, hz: float, mean: bool) -> Sensors:
    """Every kth sample, or the mean of k with the stamp of their middle, as a sensor's filter."""
    k = max(round(rate_hz(s.imu_time) / hz), 1)
    if not mean:
        return s.imu_at(slice(None, None, k))
    n = len(s.imu_time) // k

    def of(values: Floats) -> Floats:
        return np.asarray(values[: n * k].reshape(n, k, -1).mean(axis=1))

    first = s.imu_time[0]
    time = first + of((s.imu_time - first).astype(float))[:, 0].astype(np.int64)
    return replace(s, imu_time=time, force=of(s.force), rate=of(s.rate))


def slower_wheel(s: Sensors, hz: float) -> Sensors:
    """Every kth sample."""
    k = max(round(rate_hz(s.wheel_time) / hz), 1)
    return s.wheel_at(slice(None, None, k))


def held_wheel(s: Sensors, _: np.random.Generator, seconds: float) -> Sensors:
    """The driver repeats a speed until it has the next: so much later it is the path's."""
    corners = np.arange(s.wheel_time[0], s.wheel_time[-1], seconds * 1e6)
    held = [
        np.interp(s.wheel_time, corners + seconds * 1e6, np.interp(corners, s.wheel_time, w))
        for w in s.wheels.T
    ]
    return replace(s, wheels=np.column_stack(held))


def jittered_wheel(s: Sensors, generator: np.random.Generator) -> Sensors:
    """Stamps up to 30 ms off, as of a busy computer."""
    slow = slower_wheel(s, SLOW_HZ)
    off = generator.uniform(-30e3, 30e3, len(slow.wheel_time)).astype(np.int64)
    return replace(slow, wheel_time=np.maximum.accumulate(slow.wheel_time + off + 30_000))


def lost(time: Ints, share: float, burst_s: float, generator: np.random.Generator) -> Ints:
    """Indices of what is left if so much of the time is lost, in bursts (0: single samples)."""
    length = max(round(burst_s * rate_hz(time)), 1)
    begins = np.flatnonzero(generator.random(len(time)) < share / length)
    gone = np.unique(np.concatenate([begins + i for i in range(length)] or [begins]))
    return np.setdiff1d(np.arange(len(time)), gone)


def lossy_wheel(s: Sensors, generator: np.random.Generator, burst_s: float) -> Sensors:
    """5 % of the samples."""
    slow = slower_wheel(s, SLOW_HZ)
    return slow.wheel_at(lost(slow.wheel_time, 0.05, burst_s, generator))


def lossy_imu(s: Sensors, generator: np.random.Generator, burst_s: float) -> Sensors:
    """5 % of the samples."""
    return s.imu_at(lost(s.imu_time, 0.05, burst_s, generator))


def noisy_wheel(s: Sensors, generator: np.random.Generator, share: float) -> Sensors:
    """White noise on each speed, of so much of it."""
    slow = slower_wheel(s, SLOW_HZ)
    steps = np.diff(slow.wheels, axis=0, prepend=slow.wheels[:1])
    noise = 1 + share * generator.standard_normal(steps.shape)
    return replace(slow, wheels=slow.wheels[0] + np.cumsum(steps * noise, axis=0))


def shaken(s: Sensors, _: np.random.Generator, times: float) -> Sensors:
    """What changes within half a second is so many times larger."""
    n = max(round(0.5 * rate_hz(s.imu_time)), 1)

    def of(values: Floats) -> Floats:
        padded = np.pad(values, ((n // 2, n - 1 - n // 2), (0, 0)), mode="edge")
        summed = np.cumsum(np.vstack([np.zeros((1, 3)), padded]), axis=0)
        smooth = (summed[n:] - summed[:-n]) / n
        return np.asarray(smooth + times * (values - smooth))

    return replace(s, force=of(s.force), rate=of(s.rate))


def noisy_imu(s: Sensors, generator: np.random.Generator) -> Sensors:
    """As much white noise again as there is from sample to sample."""

    def of(values: Floats) -> Floats:
        size = np.median(np.abs(np.diff(values, n=2, axis=0)), axis=0) * 1.483 / np.sqrt(6)
        return np.asarray(values + size * generator.standard_normal(values.shape))

    return replace(s, force=of(s.force), rate=of(s.rate))


def mirrored(s: Sensors, _: np.random.Generator) -> Sensors:
    """Left is right. Rates are axial vectors."""
    flip = np.array([1.0, -1.0, 1.0])
    return replace(
        s, force=s.force * flip, rate=-s.rate * flip, wheels=s.wheels[:, ::-1], truth=s.truth * flip
    )


def turned(s: Sensors, _: np.random.Generator, quaternion: tuple[float, ...]) -> Sensors:
    """The IMU is mounted otherwise."""
    R = rotation.to_matrix(np.array(quaternion) / np.linalg.norm(quaternion))
    return replace(s, force=s.force @ R, rate=s.rate @ R)


def displaced(s: Sensors, _: np.random.Generator, place_m: tuple[float, ...]) -> Sensors:
    """The IMU sits so far from the reference point. The gyro's rate is smoothed over `TURN_S`, so
    that its noise does not count as turning."""
    samples = TURN_S * rate_hz(s.imu_time)
    rate = gaussian_filter1d(s.rate, samples, axis=0)
    step_s = np.maximum(np.gradient(s.seconds), SHORTEST_S)
    return replace(s, force=s.force + rotation.added_by_turning(rate, step_s, np.array(place_m)))


def reversed_axis(s: Sensors, _: np.random.Generator) -> Sensors:
    """The accelerometer's x has the wrong sign."""
    return replace(s, force=s.force * np.array([-1.0, 1.0, 1.0]))


def turned_aside(s: Sensors, generator: np.random.Generator, degrees: float) -> Sensors:
    """The IMU is mounted with another yaw than is believed: force and rate of the body, turned."""
    half = np.radians(degrees) / 2
    return turned(s, generator, (float(np.cos(half)), 0.0, 0.0, float(np.sin(half))))


def silent(
    s: Sensors, _: np.random.Generator, seconds: float, imu: bool = True, wheel: bool = True
) -> Sensors:
    """No messages for so long, from the middle of the recording on."""
    begin = (s.imu_time[0] + s.imu_time[-1]) // 2

    def rest(time: Ints) -> Ints:
        return np.flatnonzero((time < begin) | (time > begin + seconds * 1e6))

    if imu:
        s = s.imu_at(rest(s.imu_time))
    return s.wheel_at(rest(s.wheel_time)) if wheel else s


def backwards_in_time(s: Sensors, _: np.random.Generator) -> Sensors:
    """The same forces, opposite rates, and the robot's rear is its front."""
    ends = s.imu_time[0] + s.imu_time[-1]
    return replace(
        s,
        imu_time=ends - s.imu_time[::-1],
        force=s.force[::-1],
        rate=-s.rate[::-1],
        wheel_time=ends - s.wheel_time[::-1],
        wheels=-s.wheels[::-1, ::-1],
        truth_time=ends - s.truth_time[::-1],
        truth=s.truth[::-1],
    )


def tail_first(s: Sensors, _: np.random.Generator) -> Sensors:
    """All the way: the wheel counts down, and the IMU looks to the rear."""
    return replace(s, wheels=-s.wheels[:, ::-1])


def imu_errors(
    s: Sensors,
    _: np.random.Generator,
    rate: Sequence[float] = (0, 0, 0),
    warming: Sequence[float] = (0, 0, 0),
    force: Sequence[float] = (0, 0, 0),
    force_scale: float = 1.0,
    rate_scale: float = 1.0,
) -> Sensors:
    """Biases of gyro (rad/s) and accelerometer (m/s^2), drift of the gyro's (rad/s in a minute),
    scales."""
    drift = np.outer(s.seconds / 60, warming)
    return replace(s, force=force_scale * s.force + force, rate=rate_scale * s.rate + rate + drift)


def wheel_errors(
    s: Sensors,
    _: np.random.Generator,
    scale: float = 1.0,
    late_s: float = 0.0,
    quantum_m: float = FINEST_M,
    hz: float = 1e3,
) -> Sensors:
    """Scale, delay, a coarse encoder, a slower one."""
    late = round(late_s * 1e6)
    s = replace(s, wheels=scale * s.wheels, wheel_time=s.wheel_time + late)
    return replace(slower_wheel(s, hz), quantum_m=quantum_m)


def same(s: Sensors, _: np.random.Generator) -> Sensors:
    """As recorded."""
    return s


@dataclass(frozen=True)
class Variation:
    """A change, and the shares of the recording's time between which it is run, with the seconds
    after the first. `known`: the IMU's mounting is found after the change, not before. `arm_m`: the
    IMU's place that is configured, along its own axes."""

    change: Change = same
    known: bool = True
    begin: float = 0.0
    end: float = 1.0
    begin_s: float = 0.0
    arm_m: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def cut(self, s: Sensors) -> Sensors:
        """The part that is run."""
        first, last = int(s.imu_time[0]), int(s.imu_time[-1])
        begin = first + round(self.begin * (last - first)) + round(self.begin_s * 1e6)
        end = first + round(self.end * (last - first))

        def of(time: Ints) -> slice:
            return slice(*np.searchsorted(time, [begin, end + 1]).tolist())

        kept = of(s.truth_time)
        s = replace(s, truth_time=s.truth_time[kept], truth=s.truth[kept])
        return s.imu_at(of(s.imu_time)).wheel_at(of(s.wheel_time))


def vary(
    change: Callable[..., Sensors],
    known: bool = True,
    arm_m: tuple[float, float, float] = (0.0, 0.0, 0.0),
    **how: Any,
) -> Variation:
    """A change of which more is said."""
    return Variation(partial(change, **how), known, arm_m=arm_m)


VARIATIONS = {
    "as recorded": Variation(),
    "IMU 60 Hz, mean": vary(slower_imu, hz=60, mean=True),
    "IMU 60 Hz, plain": vary(slower_imu, hz=60, mean=False),
    "IMU 40 Hz, mean": vary(slower_imu, hz=40, mean=True),
    "IMU 40 Hz, plain": vary(slower_imu, hz=40, mean=False),
    "IMU 20 Hz, plain": vary(slower_imu, hz=20, mean=False),
    "IMU shaken twice as much": vary(shaken, times=2),
    "IMU shaken four times": vary(shaken, times=4),
    "IMU with more white noise": Variation(noisy_imu),
    "IMU loses samples, 5 %": vary(lossy_imu, burst_s=0),
    "IMU loses 0.5 s, 5 %": vary(lossy_imu, burst_s=0.5),
    "IMU turned": vary(turned, quaternion=(1, 0.3, -0.5, 0.8)),
    "IMU upside down": vary(turned, quaternion=(0.1, 1, 0.1, -0.1)),
    "gyro bias 0.01 rad/s": vary(imu_errors, rate=(0.01, -0.01, 0.01)),
    "gyro bias -0.02 rad/s": vary(imu_errors, rate=(-0.02, 0.015, -0.02)),
    "gyro warms, 0.002 rad/s a minute": vary(imu_errors, warming=(0.002, 0.002, 0.002)),
    "gyro scale 1.005": vary(imu_errors, rate_scale=1.005),
    "gyro scale 0.995": vary(imu_errors, rate_scale=0.995),
    "accelerometer bias 0.3 m/s^2": vary(imu_errors, force=(0.3, -0.2, 0.1)),
    "accelerometer scale 1.02": vary(imu_errors, force_scale=1.02),
    "accelerometer scale 0.98": vary(imu_errors, force_scale=0.98),
    "wheel 10 Hz": vary(wheel_errors, hz=10),
    "wheel 5 Hz": vary(wheel_errors, hz=5),
    "wheel held 0.25 s": vary(held_wheel, seconds=0.25),
    "wheel 0.1 s late": vary(wheel_errors, late_s=0.1),
    "wheel 0.2 s late": vary(wheel_errors, late_s=0.2),
    "wheel 0.3 s late": vary(wheel_errors, late_s=0.3),
    "wheel stamps +-30 ms": Variation(jittered_wheel),
    "wheel scale 1.1": vary(wheel_errors, scale=1.1),
    "wheel scale 0.9": vary(wheel_errors, scale=0.9),
    "wheel counts 1 cm": vary(wheel_errors, quantum_m=0.01),
    "wheel counts 10 cm": vary(wheel_errors, quantum_m=0.1),
    "wheel loses samples, 5 %": vary(lossy_wheel, burst_s=0),
    "wheel loses 0.5 s, 5 %": vary(lossy_wheel, burst_s=0.5),
    "wheel noise 5 %": vary(noisy_wheel, share=0.05),
    "wheel noise 20 %": vary(noisy_wheel, share=0.2),
    "mirrored": Variation(mirrored),
    "tail first": Variation(tail_first),
    "backwards in time": Variation(backwards_in_time),
    "IMU 10 Hz, plain": vary(slower_imu, hz=10, mean=False),
    "yaw of the IMU 10 degrees off": vary(turned_aside, degrees=10, known=False),
    "yaw of the IMU 30 degrees off": vary(turned_aside, degrees=30, known=False),
    "yaw of the IMU 90 degrees off": vary(turned_aside, degrees=90, known=False),
    "accelerometer's x reversed": Variation(reversed_axis, known=False),
    "accelerometer scale 0.8": vary(imu_errors, force_scale=0.8, known=False),
    "accelerometer scale 1.2": vary(imu_errors, force_scale=1.2, known=False),
    "nothing for 1 s": vary(silent, seconds=1),
    "nothing for 5 s": vary(silent, seconds=5),
    "nothing for 30 s": vary(silent, seconds=30),
    "no IMU for 3 s": vary(silent, seconds=3, wheel=False),
    "no IMU for 10 s": vary(silent, seconds=10, wheel=False),
    "no wheel for 3 s": vary(silent, seconds=3, imu=False),
    "no wheel for 10 s": vary(silent, seconds=10, imu=False),
    "from 20 s": Variation(begin_s=20),
    "from 40 s": Variation(begin_s=40),
    "first half": Variation(end=0.5),
    "second half": Variation(begin=0.5),
}

# Where the IMU sits, its axes being known: not part of those that are run when none is named.
ARMS_M = {
    "0.1 m off along x": (0.1, 0.0, 0.0),
    "0.5 m off along x": (0.5, 0.0, 0.0),
    "0.5 m off along y": (0.0, 0.5, 0.0),
    "0.5 m off along z": (0.0, 0.0, 0.5),
}
LEVER_ARMS = {
    f"IMU {name}{more}": vary(displaced, known=False, arm_m=given, place_m=arm)
    for name, arm in ARMS_M.items()
    for more, given in (("", (0.0, 0.0, 0.0)), (", given", arm))
}
