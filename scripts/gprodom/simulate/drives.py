"""Simulated drives that tests and benches share, drawn from a seed."""

import math
from dataclasses import replace
from typing import Any

import numpy as np

from gprodom.random_streams import Random, stream
from gprodom.simulate.antennas import draw_antennas
from gprodom.simulate.drive import Bend, Drive, DriveSpec, Move, Stop, Track
from gprodom.simulate.ground import GroundSpec
from gprodom.simulate.lasting import KINDS as KINDS_OF_SLIP
from gprodom.simulate.pair import PairSpec
from gprodom.simulate.robot import KINDS, of_kind, robot
from gprodom.simulate.routes import make_route
from gprodom.simulate.sequence import Simulated, Spec, SurveySpec, simulate
from gprodom.simulate.wheel import Stuck

PLAIN_M = 12.0  # a drive without ground
ROBOT_M = 60.0  # of a robot with two sides of wheels
KNOWN_M = 45.0  # a drive over ground seen again
AGAIN_M = 14.0  # of a lap, about the ground that a drive of KNOWN_M covers
STANDSTILL_S = 4.0  # at first
GUIDED_M = 10.0  # straight, of the drive of a commissioning
SLOWLY = 0.2  # m/s, in its circles
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


def guided_drive(speed: float, seed: int) -> DriveSpec:
    """The drive that `gprodom commission` asks for: a standstill of 30 s, 10 m straight, starts and
    stops, two circles to each side, and the straight way back. Its first move has a length of 10 m
    but for some centimetres, as a person stops at a mark."""
    draw = stream(seed, "guided")
    stretch = GUIDED_M + draw.uniform(-0.05, 0.05)
    circle = 4 * math.pi * draw.uniform(1.3, 2.0)
    bends = (Bend(GUIDED_M + 5), Bend(circle, 4 * math.pi), Bend(2), Bend(circle, -4 * math.pi))
    steps: list[Move | Stop] = [Stop(30.0), Move(stretch, speed), Stop(3.0)]
    for _ in range(5):
        steps += [Move(2.0, speed), Stop(2.0), Move(-2.0, speed), Stop(2.0)]
    ahead = GUIDED_M + 7 + 2 * circle - stretch
    steps += [Move(ahead, min(speed, SLOWLY)), Stop(3.0), Move(-GUIDED_M, speed), Stop(3.0)]
    return DriveSpec(Track((*bends, Bend(2))), tuple(steps), yaw=draw.uniform(-math.pi, math.pi))


def _shaken(spec: Spec, draw: Random) -> Spec:
    """With the IMU, the vibration and the tilt of another robot, or as it is."""
    kind = draw.choice(["", "cart", "rover"])
    return replace(spec, imu=KINDS[kind].imu) if kind else spec


def immobilised_drive(seed: int, ground: GroundSpec | SurveySpec, speed: float) -> Simulated:
    """A line to and fro, on which the robot is immobilised at two of five stops, its wheel turning
    at `speed` (m/s) for 4 to 10 s and 0.4 m at least: at one it digs itself in while it drives, at
    the other it stands and does not get going. At the others it rests."""
    draw = stream(seed, "immobilised")
    steps: list[Move | Stop] = [Stop(STANDSTILL_S)]
    longest = max(4.0, 0.4 / speed)
    place = 0.0
    for turn in range(5):
        way = draw.uniform(2.0, 4.0) if turn % 2 == 0 else -draw.uniform(1.0, place - 0.5)
        place += way
        steps += [Move(way, draw.uniform(0.3, 0.7))]
        steps += [Stop(draw.uniform(4.0, 10.0) + longest)]
    route = DriveSpec(Track((Bend(5.0),), weave=0.04), tuple(steps))
    spec = _shaken(robot(route, ground), draw)
    rests = Drive(spec.drive, stream(seed, "drive")).standstills()[1:]
    digs_in, gets_off = draw.choice(len(rests), 2, replace=False)
    stuck = []
    for rest, from_rest in ((digs_in, False), (gets_off, True)):
        braking, stands, moves = rests[rest]
        sign = 1.0 if rest % 2 == 0 else -1.0  # on as it drove; from rest, back
        begin = stands + draw.uniform(1.0, 2.0) if from_rest else braking
        end = min(begin + longest + draw.uniform(0.0, 6.0), moves - 0.5)
        stuck.append(Stuck(begin, end - begin, -sign * speed if from_rest else sign * speed))
    stuck.sort(key=lambda s: s.start)
    return simulate(replace(spec, wheel=replace(spec.wheel, stuck=tuple(stuck))), seed)


def creeping_drive(seed: int, distance_m: float) -> Simulated:
    """To and fro on a line: 3 to 12 m at driving speed, then 0.3 to 1.5 m creeping, then a rest or
    not; slip of any kind. The ground is as uneven as seldom, or hardly, or not at all, and shows
    many, few or no scatterers."""
    draw = stream(seed, "creeping")
    steps: list[Move | Stop] = [Stop(STANDSTILL_S)]
    length, left, place, ahead = 15.0, distance_m, 0.0, True
    while left > 0:
        for way, speed in (
            (draw.uniform(3.0, 12.0), draw.uniform(0.3, 0.8)),
            (draw.uniform(0.3, 1.5), math.exp(draw.uniform(math.log(0.02), math.log(0.2)))),
        ):
            way = min(way, length - place if ahead else place)
            if way < 0.1:
                ahead = not ahead
                continue
            steps.append(Move(way if ahead else -way, speed))
            place, left = place + (way if ahead else -way), left - way
        if draw.uniform() < 0.5:
            steps.append(Stop(draw.uniform(1.0, 4.0)))
    ground = GroundSpec(
        scatterers=draw.choice([8.0, 1.0, 0.1, 0.0]), waviness=draw.choice([1.0, 0.1, 0.01, 0.0])
    )
    route = DriveSpec(Track((Bend(length),), weave=0.04), tuple(steps))
    lasting = draw.choice(["", *KINDS_OF_SLIP])
    return simulate(_shaken(robot(route, ground, lasting=lasting), draw), seed)


def drive_on_known_ground(seed: int) -> Simulated:
    """A line to and fro (even seeds) or laps, over scatterers and layers, with slips."""
    name = ("line", "loop")[seed % 2]
    route = make_route(name, KNOWN_M, 0.7, STANDSTILL_S, stream(seed, "route"))
    return simulate(Spec(route, station=None, slips=2), seed)


def laps_drive(seed: int, laps: int, wander_m: float, abreast_m: float = 0.0) -> Simulated:
    """Laps of `AGAIN_M`, always forwards and without slip, over scatterers and layers. The robot
    steers `wander_m` to either side of its track and back, differently in each lap. abreast_m: of
    two antennas, 0 to the left and 1 to the right."""
    distance = laps * AGAIN_M
    route = make_route("loop", distance, 0.7, STANDSTILL_S, stream(seed, "route"), AGAIN_M)
    steps = (route.steps[0], Move(distance, 0.7), route.steps[-1])
    spec = Spec(replace(route, steps=steps, wander=wander_m), station=None)
    if abreast_m > 0:
        told = [(0.0, abreast_m / 2), (0.0, -abreast_m / 2)]
        spec = replace(spec, antennas=draw_antennas(told, spec.radar, stream(seed, "antennas")))
    return simulate(spec, seed)


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
