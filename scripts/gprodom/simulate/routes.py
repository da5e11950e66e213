"""Drives to choose from: a line with reversals, laps of a loop, a random wander."""

from __future__ import annotations

import math

import numpy as np

from gprodom.simulate.drive import Bend, DriveSpec, Move, Stop, Track

ROUTES = ("line", "loop", "random")

_PAUSE = 2.0  # s, where the robot turns back or rests


def line(distance: float, speed: float, standstill: float) -> DriveSpec:
    """Back and forth on a gently weaving line: every piece of ground is seen again."""
    length = max(distance / 3.5, 1.0)
    steps: list[Move | Stop] = [Stop(standstill)]
    left, at_start = distance, True
    while left > 0.5:
        piece = min(length, left)
        steps += [Move(piece if at_start else -piece, speed), Stop(_PAUSE)]
        left, at_start = left - piece, not at_start
    return DriveSpec(Track((Bend(length),), weave=0.04), tuple(steps))


def loop(distance: float, speed: float, standstill: float) -> DriveSpec:
    """Somewhat more than two laps of a stadium, a tenth of it backwards on the way."""
    back = 0.1 * distance
    lap = max((distance - 2 * back) / 2.2, 6.0)
    straight, turn = 0.15 * lap, 0.35 * lap
    bends = (Bend(straight), Bend(turn, math.pi)) * 2
    track = Track(bends, closed=True, weave=0.02, weave_length=lap / 8)
    steps = (
        Stop(standstill),
        Move(0.6 * distance, speed),
        Stop(_PAUSE),
        Move(-back, speed),
        Stop(_PAUSE),
        Move(0.4 * distance - back, speed),
        Stop(_PAUSE),
    )
    return DriveSpec(track, steps)


def wander(
    distance: float, speed: float, standstill: float, random: np.random.RandomState
) -> DriveSpec:
    """Random bends, with a stop, a reversal and a changing speed."""
    bends: list[Bend] = []
    while sum(bend.length for bend in bends) < distance:
        bends.append(Bend(random.uniform(1.0, 3.0), random.uniform(-1.2, 1.2)))
    first, back = distance * random.uniform(0.3, 0.5), distance * random.uniform(0.1, 0.2)
    rest = distance - first - back
    steps = (
        Stop(standstill),
        Move(first, speed * random.uniform(0.6, 1.0)),
        Stop(_PAUSE),
        Move(-back, speed * random.uniform(0.5, 0.8)),
        Stop(0.2),
        Move(rest, speed * random.uniform(0.6, 1.0)),
    )
    return DriveSpec(Track(tuple(bends)), steps, yaw=random.uniform(-math.pi, math.pi))


def make_route(
    name: str, distance: float, speed: float, standstill: float, random: np.random.RandomState
) -> DriveSpec:
    """The route `name` of `ROUTES` over `distance` (m), after `standstill` (s)."""
    if name == "line":
        return line(distance, speed, standstill)
    if name == "loop":
        return loop(distance, speed, standstill)
    if name == "random":
        return wander(distance, speed, standstill, random)
    raise ValueError(f"no route {name!r}: expected one of {', '.join(ROUTES)}")
