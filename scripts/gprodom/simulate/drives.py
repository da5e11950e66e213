"""Simulated drives that tests and benches share, drawn from a seed."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np

from gprodom.random_streams import stream
from gprodom.simulate.pair import PairSpec
from gprodom.simulate.robot import KINDS, of_kind, robot
from gprodom.simulate.routes import make_route
from gprodom.simulate.sequence import Simulated, Spec, simulate

PLAIN_M = 12.0  # a drive without ground
ROBOT_M = 60.0  # of a robot with two sides of wheels
KNOWN_M = 45.0  # a drive over ground seen again
AGAIN_M = 14.0  # of ground that longer drives stay on, about what one of 45 m drives over
STANDSTILL_S = 4.0  # at first
WRONG_EVERY_M = 20.0  # between wrong revisits


def plain_drive(seed: int) -> Simulated:
    """Some 40 s without radar and slip, all errors as the configuration states them."""
    route = make_route("random", PLAIN_M, 0.6, STANDSTILL_S, stream(seed, "route"))
    return simulate(Spec(route, ground=None, station=None), seed)


def robot_drive(
    seed: int, kind: str, surface: str = "floor", slips: int = 0, pair: PairSpec | None = None
) -> Simulated:
    """One of `KINDS` on random bends, without radar. pair: in place of its own."""
    route = make_route("random", ROBOT_M, KINDS[kind].speed, 6.0, stream(seed, "route"))
    spec = of_kind(kind, surface, robot(route, None, slips=slips))
    return simulate(replace(spec, pair=pair) if pair else spec, seed)


def drive_on_known_ground(seed: int, distance_m: float = KNOWN_M) -> Simulated:
    """A line to and fro (even seeds) or laps, over scatterers and layers, with slips."""
    name = ("line", "loop")[seed % 2]
    ground_m = AGAIN_M if distance_m > KNOWN_M else None
    route = make_route(name, distance_m, 0.7, STANDSTILL_S, stream(seed, "route"), ground_m)
    return simulate(Spec(route, station=None, slips=round(2 * distance_m / KNOWN_M)), seed)


def wrong_revisits(run: Simulated) -> list[dict[str, Any]]:
    """Revisits that did not take place, as arguments of `gprodom.Odometry.add_displacement`.

    Every 20 m one that is wrong by 0.3 to 3 m, and three, a metre apart, that agree with each other
    and are wrong by a pitch of 0.5 m.
    """
    random = stream(run.seed, "wrong")
    travelled, time = run.truth.travelled, run.truth_utime * 1000
    told = []

    def tell(metres: float, back: float, offset: float) -> None:
        to, since = (int(np.interp(at, travelled, time)) for at in (metres, metres - back))
        turn = np.interp([since, to], time, run.truth.yaw)
        speed = np.interp([since, to], time, run.truth.v)
        mirrored = (math.cos(turn[1] - turn[0]) < 0) != (speed.prod() < 0)  # driven, not faced
        told.append({
            "time": to, "time_from": since, "time_to": to, "distance": offset, "sigma": 0.02,
            "revisit": True, "mirrored": mirrored,
        })  # fmt: skip

    for metres in np.arange(WRONG_EVERY_M, travelled[-1], WRONG_EVERY_M):
        here = np.searchsorted(travelled, metres)
        # A place passed before, as close as there is.
        before = np.flatnonzero(travelled < metres - 5.0)
        apart = np.hypot(
            run.truth.x[before] - run.truth.x[here], run.truth.y[before] - run.truth.y[here]
        )
        back = metres - travelled[before[np.argmin(apart)]]
        tell(metres, back, random.choice([-1, 1]) * random.uniform(0.3, 3.0))
        for k in range(3):
            tell(metres + 1.0 + k, back, 0.5)
    return told
