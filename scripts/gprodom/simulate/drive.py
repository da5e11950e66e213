"""The motion of the robot: a track in the plane, driven by a smooth time law, with side slip.

Everything is smooth to the second derivative of velocity, so that sampled accelerations and rates
integrate back to the motion. The ground is flat: roll, pitch and height are zero.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from gprodom.arrays import Floats
from gprodom.random_streams import Random

_PEAK = 2.1875  # of the smooth step's slope
_GRID = 0.001  # s; of the integration of position
_SLIP_LENGTH = 0.05  # m; below it side slip is smooth, above it white
_WANDER_LENGTHS = (5.3, 8.7)  # m
_CENTRE_STEP = 0.01  # m, along the track's middle
_CENTRE_LENGTHS = (3.7, 7.9)  # m
_GRAVITY = 9.8  # m/s^2
_SIDE_STEP = 5e-4  # s; of the numeric derivative of sideways speed


def _step(x: Floats) -> Floats:
    """Smooth step from 0 to 1 on [0, 1], three times differentiable."""
    return np.asarray(x**4 * (35 - 84 * x + 70 * x**2 - 20 * x**3))


def _step_slope(x: Floats) -> Floats:
    return np.asarray(140 * (x * (1 - x)) ** 3)


def _step_integral(x: Floats) -> Floats:
    return np.asarray(x**5 * (7 - 14 * x + 10 * x**2 - 2.5 * x**3))


@dataclass(frozen=True)
class Bend:
    """A piece of track that turns by `angle` (rad, positive to the left) over `length` (m)."""

    length: float
    angle: float = 0.0


@dataclass(frozen=True)
class Track:
    """Bends in a row; a closed track repeats, an open one goes on straight at both ends.

    The weave swings the heading by `weave` (rad) with `weave_length` (m). A closed track stays
    closed with it where half a lap holds a whole number of swings.
    """

    bends: tuple[Bend, ...]
    closed: bool = False
    weave: float = 0.0
    weave_length: float = 4.0

    @property
    def length(self) -> float:
        """Length of all bends, m."""
        return sum(bend.length for bend in self.bends)

    def heading(self, s: Floats) -> tuple[Floats, Floats]:
        """Heading (rad) and curvature (rad/m) at the distances `s` (m) along the track."""
        starts = np.cumsum([0.0, *(bend.length for bend in self.bends)])
        angles = np.array([bend.angle for bend in self.bends])
        before = np.concatenate([[0.0], np.cumsum(angles)])
        laps = np.floor(s / self.length) if self.closed else np.zeros_like(s)
        local = s - laps * self.length if self.closed else np.clip(s, 0.0, self.length)
        index = np.clip(np.searchsorted(starts, local, side="right") - 1, 0, len(angles) - 1)
        lengths = np.diff(starts)[index]
        x = np.clip((local - starts[index]) / lengths, 0.0, 1.0)
        heading = laps * before[-1] + before[index] + angles[index] * _step(x)
        curvature = angles[index] / lengths * _step_slope(x)
        number = 2 * np.pi / self.weave_length
        heading = heading + self.weave * np.sin(number * s)
        return heading, curvature + self.weave * number * np.cos(number * s)


@dataclass(frozen=True)
class Move:
    """Along the track by `distance` (m, backwards negative) at up to `speed` (m/s, positive)."""

    distance: float
    speed: float


@dataclass(frozen=True)
class Stop:
    """Standing for `duration` (s)."""

    duration: float


@dataclass(frozen=True)
class DriveSpec:
    """A drive. `lateral_noise` (m/sqrt(m)) is side slip, a random walk over the distance driven.

    `wander` (m) is how far the robot steers to either side of its track and back, differently on
    each pass: heading swings of two lengths and random phases over the distance driven.
    """

    track: Track
    steps: tuple[Move | Stop, ...]
    acceleration: float = 0.5  # m/s^2, at most
    lateral_noise: float = 0.003
    wander: float = 0.0
    # The point that does not move sideways as the robot turns lies this far (m) forwards of the
    # body's origin, and wanders by `centre_wander` (m, RMS) over the distance driven.
    centre_offset: float = 0.0
    centre_wander: float = 0.0
    # Lateral over vertical force of the tyres, by slip angle (1/rad); 0: they do not creep.
    cornering_stiffness: float = 0.0
    yaw: float = 0.0  # rad, of the track at its start


@dataclass(frozen=True)
class Motion:
    """True motion at some times: arrays (n,). Position and yaw in the world, the rest in body."""

    s: Floats  # m along the track, signed
    travelled: Floats  # m, unsigned
    x: Floats  # m
    y: Floats  # m
    yaw: Floats  # rad, continuous
    v: Floats  # m/s, forwards
    lateral: Floats  # m/s, to the left
    yaw_rate: Floats  # rad/s
    acceleration: Floats  # (n, 2), m/s^2, inertial, in body axes


@dataclass(frozen=True)
class _Phase:
    """A piece of the time law: velocity from `v0` to `v1` by a smooth step."""

    start: float
    duration: float
    s0: float
    travelled0: float
    v0: float
    v1: float

    @property
    def distance(self) -> float:
        return 0.5 * (self.v0 + self.v1) * self.duration


class Drive:
    """The drive of `spec`, with side slip drawn from `random`."""

    def __init__(self, spec: DriveSpec, random: Random) -> None:
        self._spec = spec
        self._phases = _time_law(spec.steps, spec.acceleration)
        last = self._phases[-1]
        self.duration = last.start + last.duration
        travelled = last.travelled0 + abs(last.distance)
        knots = int(np.ceil(travelled / _SLIP_LENGTH)) + 4
        # White noise of this density over the distance, cubic splines of unit area between knots.
        self._slip = random.standard_normal(knots) * (spec.lateral_noise / np.sqrt(_SLIP_LENGTH))
        self._phase = random.uniform(0, 2 * np.pi, len(_WANDER_LENGTHS))
        self._centre_phase = random.uniform(0, 2 * np.pi, len(_CENTRE_LENGTHS))
        self._grid_x, self._grid_y = self._integrate()

    def at(self, t: Floats) -> Motion:
        """The motion at `t` (s from the start, ascending or not, 0 to `duration`)."""
        motion, dx, dy = self._local(t)
        index = np.clip((t / _GRID).astype(np.int64), 0, len(self._grid_x) - 1)
        rest = t - index * _GRID
        _, x0, y0 = self._local(index * _GRID)
        # Trapezoid with slopes at both ends: the rest is a fraction of a millisecond.
        x = self._grid_x[index] + 0.5 * rest * (x0 + dx)
        y = self._grid_y[index] + 0.5 * rest * (y0 + dy)
        return Motion(x=x, y=y, **motion)

    def standstills(self) -> list[tuple[float, float, float]]:
        """Of each: when the robot begins to brake, stands, and moves again (s)."""
        found = []
        for before, phase in zip((None, *self._phases), self._phases, strict=False):
            if phase.v0 == phase.v1 == 0.0:
                braking = before is not None and before.v1 == 0.0 != before.v0
                began = before.start if before is not None and braking else phase.start
                found.append((began, phase.start, phase.start + phase.duration))
        return found

    def beside_track(self, s: Floats, x: Floats, y: Floats) -> tuple[Floats, Floats]:
        """Where (x, y) (n,), m, lie along the middle of the track and to the left of it, m.

        `s` (n,) says roughly where along it: a track may come by a place more than once.
        """
        centre = self._centre
        along = np.asarray(s, np.float64)
        for _ in range(4):
            cx, cy, heading, curvature = centre(along)
            ahead = (x - cx) * np.cos(heading) + (y - cy) * np.sin(heading)
            left = (y - cy) * np.cos(heading) - (x - cx) * np.sin(heading)
            along = along + ahead / np.clip(1 - curvature * left, 0.5, 2.0)
        return along, left

    @cached_property
    def _centre(self) -> Callable[[Floats], tuple[Floats, Floats, Floats, Floats]]:
        """x, y, heading and curvature of the track's middle, without wander and side slip."""
        track, yaw = self._spec.track, self._spec.yaw
        ends = [s for phase in self._phases for s in (phase.s0, phase.s0 + phase.distance)]
        low, high = (0.0, track.length) if track.closed else (min(ends) - 2, max(ends) + 2)
        steps = int(np.ceil((high - low) / _CENTRE_STEP))
        fine = np.linspace(low, high, 2 * steps + 1)
        heading = yaw + track.heading(fine)[0]
        grid, width = fine[::2], fine[2] - fine[0]
        moved = [_integral(slope, width) for slope in (np.cos(heading), np.sin(heading))]
        places = [place - np.interp(0.0, grid, place) for place in moved]

        def centre(s: Floats) -> tuple[Floats, Floats, Floats, Floats]:
            local = np.mod(s, track.length) if track.closed else s
            turn, curvature = track.heading(s)
            x, y = (np.interp(local, grid, place) for place in places)
            return x, y, yaw + turn, curvature

        return centre

    def _integrate(self) -> tuple[Floats, Floats]:
        """Position on the grid."""
        steps = int(np.ceil(self.duration / _GRID))
        _, dx, dy = self._local(np.arange(2 * steps + 1) * (_GRID / 2))
        return _integral(dx, _GRID), _integral(dy, _GRID)

    def _local(self, t: Floats) -> tuple[dict[str, Floats], Floats, Floats]:
        """Values that need no integration, and the velocity in the world."""
        s, travelled, v, a = self._law(t)
        heading, curvature = self._spec.track.heading(s)
        swing, swing_rate = self._swing(travelled)
        yaw = self._spec.yaw + heading + swing
        slope, slope_rate = self._side_slip(travelled)
        yaw_rate = curvature * v + swing_rate * np.abs(v)
        aside, aside_rate = self._aside(t)
        lateral = v * slope + aside
        lateral_rate = a * slope + v * np.abs(v) * slope_rate + aside_rate
        acceleration = np.stack([a - yaw_rate * lateral, lateral_rate + yaw_rate * v], axis=1)
        motion = {
            "s": s,
            "travelled": travelled,
            "yaw": yaw,
            "v": v,
            "lateral": lateral,
            "yaw_rate": yaw_rate,
            "acceleration": acceleration,
        }
        cos, sin = np.cos(yaw), np.sin(yaw)
        return motion, v * cos - lateral * sin, v * sin + lateral * cos

    def _aside(self, t: Floats) -> tuple[Floats, Floats]:
        """Sideways speed (m/s) of a body that rotates about another point than its origin, plus the
        creep of its tyres, and the derivative (m/s^2).
        """
        spec = self._spec
        if not (spec.centre_offset or spec.centre_wander or spec.cornering_stiffness):
            return np.zeros_like(t), np.zeros_like(t)

        def speed(time: Floats) -> Floats:
            s, travelled, v, _ = self._law(time)
            _, curvature = spec.track.heading(s)
            yaw_rate = curvature * v + self._swing(travelled)[1] * np.abs(v)
            numbers = 2 * np.pi / np.array(_CENTRE_LENGTHS)
            waves = np.sin(travelled[:, None] * numbers + self._centre_phase)
            offset = spec.centre_offset + spec.centre_wander * waves.sum(axis=1)
            if spec.cornering_stiffness:
                offset = offset + v**2 / (spec.cornering_stiffness * _GRAVITY)
            return np.asarray(-offset * yaw_rate)

        rate = (speed(t + _SIDE_STEP) - speed(t - _SIDE_STEP)) / (2 * _SIDE_STEP)
        return speed(t), np.asarray(rate)

    def _law(self, t: Floats) -> tuple[Floats, Floats, Floats, Floats]:
        """Distance along the track, distance travelled, speed and its rate."""
        phases = self._phases
        index = np.searchsorted([phase.start for phase in phases], t, side="right") - 1
        index = np.clip(index, 0, len(phases) - 1)

        def of(name: str) -> Floats:
            return np.array([getattr(phase, name) for phase in phases], np.float64)[index]

        duration, v0, change = of("duration"), of("v0"), of("v1") - of("v0")
        x = np.clip((t - of("start")) / duration, 0.0, 1.0)
        moved = duration * (v0 * x + change * _step_integral(x))
        v = v0 + change * _step(x)
        return (
            of("s0") + moved,
            of("travelled0") + np.abs(moved),
            v,
            change / duration * _step_slope(x),
        )

    def _swing(self, travelled: Floats) -> tuple[Floats, Floats]:
        """Heading off the track's (rad) by wandering, and its derivative (rad/m)."""
        swing, rate = np.zeros_like(travelled), np.zeros_like(travelled)
        for length, phase in zip(_WANDER_LENGTHS, self._phase, strict=True):
            number = 2 * np.pi / length
            angle = number * travelled + phase
            size = self._spec.wander * number / len(_WANDER_LENGTHS)
            swing = swing + size * np.sin(angle)
            rate = rate + size * number * np.cos(angle)
        return swing, rate

    def _side_slip(self, travelled: Floats) -> tuple[Floats, Floats]:
        """Slope of the side slip over the distance driven, and its derivative (1/m)."""
        position = travelled / _SLIP_LENGTH
        index = np.minimum(position.astype(np.int64), len(self._slip) - 4)
        f = position - index
        weights = ((1 - f) ** 3, 3 * f**3 - 6 * f**2 + 4, -3 * f**3 + 3 * f**2 + 3 * f + 1, f**3)
        slopes = (-((1 - f) ** 2), 3 * f**2 - 4 * f, -3 * f**2 + 2 * f + 1, f**2)
        value = sum(w * self._slip[index + k] for k, w in enumerate(weights)) / 6
        rate = sum(w * self._slip[index + k] for k, w in enumerate(slopes)) / 2
        return np.asarray(value), np.asarray(rate) / _SLIP_LENGTH


def _integral(slope: Floats, width: float) -> Floats:
    """(n + 1,), by Simpson's rule, from slopes (2 n + 1,) half of `width` apart."""
    pieces = (slope[0:-2:2] + 4 * slope[1:-1:2] + slope[2::2]) * (width / 6)
    return np.concatenate([[0.0], np.cumsum(pieces)])


def _time_law(steps: Sequence[Move | Stop], acceleration: float) -> list[_Phase]:
    phases: list[_Phase] = []
    start = s = travelled = 0.0

    def add(duration: float, v0: float, v1: float) -> None:
        nonlocal start, s, travelled
        if duration > 0:
            phase = _Phase(start, duration, s, travelled, v0, v1)
            phases.append(phase)
            start, s = start + duration, s + phase.distance
            travelled += abs(phase.distance)

    for step in steps:
        if isinstance(step, Stop):
            add(step.duration, 0.0, 0.0)
            continue
        distance = abs(step.distance)
        speed = min(step.speed, np.sqrt(distance * acceleration / _PEAK))
        if speed <= 0:
            continue
        ramp = _PEAK * speed / acceleration
        velocity = float(np.copysign(speed, step.distance))
        add(ramp, 0.0, velocity)
        add((distance - speed * ramp) / speed, velocity, velocity)
        add(ramp, velocity, 0.0)
    if not phases:
        raise ValueError("a drive needs at least one step that takes time")
    return phases
