"""Drives to choose from: lines with reversals or stops, laps of a loop or an eight, a wander."""

import math
from math import inf

from gprodom.errors import UsageError
from gprodom.random_streams import Random
from gprodom.simulate.drive import Bend, DriveSpec, Move, Stop, Track

ROUTES = ("line", "loop", "eight", "stops", "random")

_PAUSE = 2.0  # s, where the robot turns back or rests
_EIGHT = 0.272345879  # of a bend of 270 degrees in three: its chord over its length
_MARGIN = 1.0  # m


def line(distance: float, speed: float, standstill: float, longest: float = inf) -> DriveSpec:
    """Back and forth on a gently weaving line: every piece of ground is seen again."""
    length = min(max(distance / 3.5, 1.0), longest)
    steps: list[Move | Stop] = [Stop(standstill)]
    left, at_start = distance, True
    while left > 0.5:
        piece = min(length, left)
        steps += [Move(piece if at_start else -piece, speed), Stop(_PAUSE)]
        left, at_start = left - piece, not at_start
    return DriveSpec(Track((Bend(length),), weave=0.04), tuple(steps))


def loop(distance: float, speed: float, standstill: float, lap: float | None = None) -> DriveSpec:
    """Laps of a stadium, somewhat more than two where `lap` (m) is not given; a tenth of the
    distance backwards on the way."""
    back = 0.1 * distance
    lap = lap or max((distance - 2 * back) / 2.2, 6.0)
    straight, turn = 0.15 * lap, 0.35 * lap
    bends = (Bend(straight), Bend(turn, math.pi)) * 2
    track = Track(bends, closed=True, weave=0.02, weave_length=lap / 8)
    return DriveSpec(track, _there_and_back(distance, back, speed, standstill))


def eight(distance: float, speed: float, standstill: float, lap: float | None = None) -> DriveSpec:
    """Laps of a figure of eight, a tenth of the distance backwards on the way."""
    back = 0.1 * distance
    lap = lap or max((distance - 2 * back) / 2.2, 8.0)
    # Two bends of 270 degrees in three parts each, joined by lines that cross at right angles. A
    # bend of length b ends `_EIGHT` b behind its start; lines sqrt(2) times that close the eight.
    bend = 0.5 * lap / (1 + math.sqrt(2) * _EIGHT)
    straight = Bend(math.sqrt(2) * _EIGHT * bend)
    third = bend / 3
    left, right = ((Bend(third, sign * math.pi / 2),) * 3 for sign in (1, -1))
    track = Track((straight, *left, straight, *right), closed=True)
    return DriveSpec(track, _there_and_back(distance, back, speed, standstill))


def _there_and_back(
    distance: float, back: float, speed: float, standstill: float
) -> tuple[Move | Stop, ...]:
    return (
        Stop(standstill),
        Move(0.6 * distance, speed),
        Stop(_PAUSE),
        Move(-back, speed),
        Stop(_PAUSE),
        Move(0.4 * distance - back, speed),
        Stop(_PAUSE),
    )


def stops(
    distance: float, speed: float, standstill: float, random: Random, longest: float = inf
) -> DriveSpec:
    """Back and forth on a line in pieces of 0.5 to 3 m at changing speeds, resting between them."""
    length = min(max(distance / 3.5, 1.0), longest)
    steps: list[Move | Stop] = [Stop(standstill)]
    left, place, ahead = distance, 0.0, True
    while left > 0.3:
        room = length - place if ahead else place
        piece = min(random.uniform(0.5, 3.0), room, left)
        pace = speed * random.uniform(0.3, 1.0)
        steps += [Move(piece if ahead else -piece, pace), Stop(random.uniform(0.5, 5.0))]
        left, place = left - piece, place + (piece if ahead else -piece)
        if room - piece < 0.3:
            ahead = not ahead
    return DriveSpec(Track((Bend(length),), weave=0.04), tuple(steps))


def wander(distance: float, speed: float, standstill: float, random: Random) -> DriveSpec:
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
    name: str,
    distance: float,
    speed: float,
    standstill: float,
    random: Random,
    ground: float | None = None,
) -> DriveSpec:
    """The route `name` of `ROUTES` over `distance` (m), after `standstill` (s).

    `ground` (m): the ground repeats along the track after this length. Laps get this length, lines
    are shorter by `_MARGIN`, so that no two places have the same ground.
    """
    longest = inf if ground is None else ground - _MARGIN
    if name == "line":
        return line(distance, speed, standstill, longest)
    if name == "loop":
        return loop(distance, speed, standstill, ground)
    if name == "eight":
        return eight(distance, speed, standstill, ground)
    if name == "stops":
        return stops(distance, speed, standstill, random, longest)
    if name == "random":
        if distance > longest:
            raise UsageError(
                f"--route random over {distance:g} m: this ground repeats after {ground:g} m; "
                "take --ground rays or another route"
            )
        return wander(distance, speed, standstill, random)
    raise ValueError(f"no route {name!r}: expected one of {', '.join(ROUTES)}")
