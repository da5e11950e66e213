"""A wheel encoder: scale, error that grows with distance, slip and skid, steps of the encoder.

Defaults equal those of ``wheel`` in the estimator's configuration.
"""

from dataclasses import dataclass

import numpy as np

from gprodom.arrays import Floats, Ints
from gprodom.random_streams import Random
from gprodom.simulate.drive import Motion
from gprodom.simulate.lasting import draw_slip


@dataclass(frozen=True)
class Slip:
    """From `start` (s) for `duration` (s) the wheel reports `factor` times the distance.

    Beside it the wheel spins at `spin` (m/s, reported), also where the robot stands.
    """

    start: float
    duration: float
    factor: float = 1.0
    spin: float = 0.0


@dataclass(frozen=True)
class Stuck:
    """From `start` (s) for `duration` (s) the robot is immobilised: its wheel turns at `speed` (m/s
    of its rim, backwards negative) at least, whatever the robot does. It takes `rise` (s) to come
    to that speed and to stop."""

    start: float
    duration: float
    speed: float
    rise: float = 0.3

    def wheel_speed(self, t: Floats) -> Floats:
        """Signed, m/s, at the times `t` (s)."""
        end = self.start + self.duration
        return self.speed * np.clip(np.minimum(t - self.start, end - t) / self.rise, 0.0, 1.0)


@dataclass(frozen=True)
class WheelSpec:
    """The scale, reported over true distance, is drawn from `scale_sigma` around `scale`."""

    rate: float = 50.0  # Hz
    scale: float = 1.0
    scale_sigma: float = 0.02
    scale_walk: float = 1.0e-6  # 1/sqrt(s)
    noise: float = 0.005  # m/sqrt(m)
    quantum: float = 0.0005  # m, of the encoder
    lever_arm: tuple[float, float] = (0.0, 0.0)  # m; the wheel's contact point in body
    slips: tuple[Slip, ...] = ()
    lasting: str = ""  # slip that lasts: of `lasting.KINDS`
    stuck: tuple[Stuck, ...] = ()


@dataclass(frozen=True)
class WheelData:
    """What the encoder counted (n,) and the scale it had (n,)."""

    ticks: Ints
    scale: Floats


def measure(t: Floats, motion: Motion, spec: WheelSpec, random: Random) -> WheelData:
    """Encoder counts at the times `t` (s) of `motion`."""
    # A contact point beside the axis rolls further on the outside of a bend.
    true = np.diff(motion.s - spec.lever_arm[1] * motion.yaw)
    steps = np.diff(t)
    start = spec.scale + spec.scale_sigma * random.standard_normal()
    walk = random.standard_normal(len(steps)) * (spec.scale_walk * np.sqrt(steps))
    scale = start + np.concatenate([[0.0], np.cumsum(walk)])
    error = random.standard_normal(len(steps)) * (spec.noise * np.sqrt(np.abs(true)))
    reported = scale[1:] * (true + error)
    middle = 0.5 * (t[1:] + t[:-1])
    if spec.lasting:
        lasting = draw_slip(spec.lasting, t, motion, random)
        reported = reported * (1 + 0.5 * (lasting[1:] + lasting[:-1]))
    for stuck in spec.stuck:
        turned = scale[1:] * stuck.wheel_speed(middle) * steps
        reported = np.where(np.abs(turned) > np.abs(reported), turned, reported)
    for slip in spec.slips:
        during = (middle >= slip.start) & (middle < slip.start + slip.duration)
        reported = np.where(during, reported * slip.factor + slip.spin * steps, reported)
    distance = np.concatenate([[0.0], np.cumsum(reported)])
    return WheelData(np.rint(distance / spec.quantum).astype(np.int64), scale)


def trigger(t: Floats, counted: Floats, spacing: float) -> Floats:
    """When a wheel that has counted `counted` (n,), m, at `t` (n,), s, makes a trace: at the first
    time, and each time that it is `spacing` (m) from where it made the last one, either way."""
    times = [float(t[0])]
    last = float(counted[0])
    for begin, end, a, b in zip(t[:-1], t[1:], counted[:-1], counted[1:], strict=True):
        while abs(b - last) >= spacing:
            last += spacing if b > last else -spacing
            times.append(float(begin + (end - begin) * (last - a) / (b - a)))
    return np.array(times)


def draw_slips(count: int, t: Floats, speed: Floats, random: Random) -> tuple[Slip, ...]:
    """Slip (factor above 1) and skid (below 1) episodes while the robot moves."""
    moving = t[np.abs(speed) > 0.1]
    slips = []
    for _ in range(count if len(moving) else 0):
        factor = random.uniform(1.3, 2.0) if random.uniform() < 0.5 else random.uniform(0.2, 0.7)
        start = float(moving[random.randint(len(moving))])
        slips.append(Slip(round(start, 3), round(random.uniform(0.6, 2.5), 3), factor))
    return tuple(sorted(slips, key=lambda slip: slip.start))
