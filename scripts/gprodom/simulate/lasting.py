"""Slip that lasts: for seconds to minutes a wheel turns further than the robot moves.

Over a drive, slip is (distance by the wheel) / (distance on the ground) - 1. It is not bound to one
shape, since no method may count on one:

    ramps   sets in and ends over 2 to 8 s, lasts 4 to 30 s, on half of the way; 5 to 35 %, and a
            quarter of them the other way round at half the size (the wheel skids)
    steps   jumps to another level every 10 to 60 s, and stays there
    turns   follows the work of the wheel: it grows with curvature and with acceleration
    gravel, ice
            drawn anew every 2 s from recordings of a Warthog (`gprodom.simulate.surface`)
"""

from collections.abc import Callable

import numpy as np

from gprodom.arrays import Floats
from gprodom.random_streams import Random
from gprodom.simulate.drive import Motion
from gprodom.simulate.surface import PIECE_S, SURFACES, draw_grip

_SIZE = (0.05, 0.35)  # of ramps and steps
_JUMP_S = 0.3  # in which a step reaches its level
_PER_CURVATURE = (0.05, 0.3)  # m: slip in a bend of 1 m radius
_PER_ACCELERATION = (0.02, 0.2)  # slip at 1 m/s^2
_SLOWEST_MPS = 0.05  # below, curvature is not told by speed and turn rate


def _ramps(t: Floats, motion: Motion, random: Random) -> Floats:
    knots, levels = [0.0], [0.0]
    while knots[-1] < t[-1]:
        size = random.uniform(*_SIZE)
        if random.uniform() < 0.25:
            size = -0.5 * size
        gap, up, held, down = (random.uniform(*s) for s in ((5, 50), (2, 8), (4, 30), (2, 8)))
        knots += np.cumsum([knots[-1] + gap, up, held, down]).tolist()
        levels += [0.0, size, size, 0.0]
    return np.interp(t, knots, levels)


def _steps(t: Floats, motion: Motion, random: Random) -> Floats:
    knots, levels = [0.0], [0.0]
    while knots[-1] < t[-1]:
        level = 0.0 if random.uniform() < 0.5 else random.uniform(*_SIZE)
        jump = knots[-1] + random.uniform(10, 60)
        knots += [jump, jump + _JUMP_S]
        levels += [levels[-1], level]
    return np.interp(t, knots, levels)


def _turns(t: Floats, motion: Motion, random: Random) -> Floats:
    curvature = np.abs(motion.yaw_rate) / np.maximum(np.abs(motion.v), _SLOWEST_MPS)
    speeding_up = np.maximum(motion.acceleration[:, 0] * np.sign(motion.v), 0.0)
    return np.asarray(
        random.uniform(*_PER_CURVATURE) * np.minimum(curvature, 1.0)
        + random.uniform(*_PER_ACCELERATION) * speeding_up
    )


def _of_surface(name: str) -> Callable[[Floats, Motion, Random], Floats]:
    def draw(t: Floats, motion: Motion, random: Random) -> Floats:
        grip = draw_grip(SURFACES[name], float(t[-1]), random)
        return np.asarray(1 / np.interp(t, np.arange(len(grip)) * PIECE_S, grip) - 1)

    return draw


_KINDS = {
    "ramps": _ramps,
    "steps": _steps,
    "turns": _turns,
    "gravel": _of_surface("gravel"),
    "ice": _of_surface("ice"),
}
KINDS = tuple(_KINDS)


def draw_slip(kind: str, t: Floats, motion: Motion, random: Random) -> Floats:
    """Slip (n,) of `kind` (of `KINDS`; empty: none) at the times `t` (s, ascending) of `motion`."""
    return _KINDS[kind](t, motion, random) if kind else np.zeros(len(t))
