#!/usr/bin/env python3
"""Does `gprodom doctor` name what is wrong with a recording, and nothing in good ones?

Good recordings are simulated: number i from seed i alone, grounds, routes, slips and robots (with
one wheel, or left and right ones) taking turns. Each kind of damage is done to as many of them as
--damaged says, of those whose route and robot can show it: bends for signs of turning, stops for
clocks. Prints for each kind how many were named, and what was found in good ones.

    bench/doctor.py [--recordings N] [--damaged N] [--first SEED] [--json]
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from gprodom.config import STANDARD
from gprodom.doctor.examine import examine
from gprodom.doctor.finding import Log
from gprodom.drive.imu_mounting import ImuMounting
from gprodom.ground.survey import find_survey, shipped
from gprodom.lcm import wire
from gprodom.lcm.messages import by_fingerprint
from gprodom.odometry.dead_reckoning import wheel_distance
from gprodom.random_streams import stream
from gprodom.simulate.recording import log_streams
from gprodom.simulate.robot import of_kind, robot
from gprodom.simulate.routes import make_route
from gprodom.simulate.sequence import SurveySpec, simulate
from program import exit_with, one_by_one, parser_of, print_figures, table_of

ROUTES = ("eight", "stops", "loop")
ROBOTS = ("", "cart", "rover")  # one wheel, then pairs
BAND = (1.5e8, 9e8)  # Hz, the configuration's
Change = Callable[..., None]  # of a log, by chance, and by what it is told
Values = Callable[[np.ndarray, np.random.RandomState], np.ndarray]


def route_of(seed: int) -> str:
    """Of a recording."""
    return ROUTES[seed % len(ROUTES)]


def robot_of(seed: int) -> str:
    """Of a recording."""
    return ROBOTS[seed // len(ROUTES) % len(ROBOTS)]


def recording(seed: int, imu_m: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> Log:
    """A good one, of 40 to 60 m. imu_m: the IMU's place in body."""
    random = stream(seed, "doctor")
    ground = shipped()[seed % len(shipped())]
    distance, speed = random.uniform(40, 60), random.uniform(0.35, 0.8)
    length = find_survey(ground).length
    drive = make_route(route_of(seed), distance, speed, 6.0, stream(seed, "route"), length)
    spec = robot(drive, SurveySpec(ground), route_of(seed), int(random.randint(0, 5)))
    if robot_of(seed):
        spec = of_kind(robot_of(seed), "gravel", spec)
    spec = replace(spec, imu=replace(spec.imu, lever_arm=imu_m))
    roles = {name: role for role, name in STANDARD.of("imu", "wheel", "gpr_trace").items()}
    log: Log = {}
    for each in log_streams(simulate(spec, seed)):
        if each.channel in roles:
            kind = by_fingerprint()[each.payloads[0][:8]]
            decoded = wire.decode(kind, each.payloads, each.channel)
            # The native byte order, and arrays of their own.
            log[roles[each.channel]] = {
                name: values.astype(values.dtype.newbyteorder("="))
                if isinstance(values, np.ndarray) and values.dtype != object
                else values
                for name, values in decoded.items()
            }
    return log


# ---- damage: each changes the log in place ----


def _of(log: Log, role: str) -> dict[str, Any]:
    """The messages of a role; of the wheel, those of a pair where it has one."""
    return log["wheels"] if role == "wheel" and "wheels" in log else log[role]


def _scaled(log: Log, _: np.random.RandomState, role: str, field: str, factor: float) -> None:
    _of(log, role)[field] = _of(log, role)[field] * factor


def _turned(log: Log, _: np.random.RandomState, *rows: list[float]) -> None:
    """The IMU's axes: its x, y, z in those of before."""
    for field in ("linear_acceleration", "angular_velocity"):
        log["imu"][field] = log["imu"][field] @ np.array(rows).T


def _without_gravity(log: Log, _random: np.random.RandomState) -> None:
    force = log["imu"]["linear_acceleration"]
    log["imu"]["linear_acceleration"] = force - force.mean(axis=0)


def _ticks(log: Log, random: np.random.RandomState, change: Values) -> None:
    wheel = _of(log, "wheel")
    seed = int(random.randint(1 << 30))
    for field in ("ticks", "left_ticks", "right_ticks"):
        if field in wheel:
            wheel[field] = change(wheel[field], np.random.RandomState(seed))


def _anew(ticks: np.ndarray, random: np.random.RandomState) -> np.ndarray:
    """The counter begins at zero, in mid-drive."""
    at = int(random.uniform(0.5, 0.8) * len(ticks))
    return np.concatenate([ticks[:at], ticks[at:] - ticks[at]])


def _overflows(ticks: np.ndarray, _random: np.random.RandomState) -> np.ndarray:
    """16 bits."""
    return (ticks + 32768) % 65536 - 32768


def _swapped(log: Log, _random: np.random.RandomState) -> None:
    wheels = log["wheels"]
    wheels["left_ticks"], wheels["right_ticks"] = wheels["right_ticks"], wheels["left_ticks"]


def _kept(content: dict[str, Any], which: np.ndarray) -> None:
    """Only these messages (indices)."""
    for name, values in content.items():
        if isinstance(values, np.ndarray):
            content[name] = values[which]
        elif isinstance(values, list):
            content[name] = [values[i] for i in which]


def _gap(log: Log, random: np.random.RandomState, role: str, seconds: float) -> None:
    content = _of(log, role)
    utime = content["utime"]
    begin = utime[0] + random.uniform(0.3, 0.7) * (utime[-1] - utime[0])
    _kept(content, np.flatnonzero((utime < begin) | (utime > begin + seconds * 1e6)))


def _rarely(log: Log, _: np.random.RandomState, role: str, every: int) -> None:
    content = _of(log, role)
    _kept(content, np.arange(0, len(content["utime"]), every))


def _late(log: Log, _: np.random.RandomState, role: str, seconds: float) -> None:
    log[role]["utime"] = log[role]["utime"] + round(seconds * 1e6)


def _disordered(log: Log, random: np.random.RandomState) -> None:
    """Stamps of arrival, after a network: one in a hundred by up to 50 ms late."""
    utime = log["imu"]["utime"].copy()
    late = random.uniform(size=len(utime)) < 0.01
    utime[late] += random.randint(20_000, 50_000, int(late.sum()))
    log["imu"]["utime"] = utime


def _stuck(log: Log, random: np.random.RandomState) -> None:
    """The IMU repeats a sample for 15 s."""
    utime = log["imu"]["utime"]
    begin = int(random.uniform(0.3, 0.6) * len(utime))
    end = int(np.searchsorted(utime, utime[begin] + 15_000_000))
    for field in ("linear_acceleration", "angular_velocity"):
        log["imu"][field][begin:end] = log["imu"][field][begin]


def _traces(log: Log, random: np.random.RandomState, change: Values) -> None:
    log["gpr_trace"]["samples"] = change(np.array(log["gpr_trace"]["samples"]), random)


def _saturated(traces: np.ndarray, _random: np.random.RandomState) -> np.ndarray:
    """At a fifth of what they reach."""
    end = int(0.2 * np.quantile(np.abs(traces).max(axis=1), 0.9))
    return np.clip(traces, -end, end)


def _empty(traces: np.ndarray, random: np.random.RandomState) -> np.ndarray:
    """A tenth of them."""
    traces = traces.copy()
    traces[random.uniform(size=len(traces)) < 0.1] = 0
    return traces


def _frozen(traces: np.ndarray, random: np.random.RandomState) -> np.ndarray:
    """The driver sends the same one for a tenth of the drive."""
    traces = traces.copy()
    begin = int(random.uniform(0.2, 0.8) * len(traces))
    traces[begin : begin + len(traces) // 10] = traces[begin]
    return traces


def _by_distance(log: Log, _random: np.random.RandomState) -> None:
    """One each 5 cm by the wheel."""
    time, distance = wheel_distance(log)
    way = np.interp(
        log["gpr_trace"]["utime"], time, np.cumsum(np.abs(np.diff(distance, prepend=0)))
    )
    _kept(log["gpr_trace"], np.flatnonzero(np.diff(np.floor(way / 0.05), prepend=0) > 0))


@dataclass(frozen=True)
class Damage:
    """told: to the change. codes: of the doctor, any of which names it. shown: on which recordings
    it can be."""

    change: Change
    told: tuple[Any, ...]
    codes: tuple[str, ...]
    shown: Callable[[int], bool] = lambda seed: True


def _bends(seed: int) -> bool:
    return route_of(seed) != "stops"


def _stops(seed: int) -> bool:
    return route_of(seed) == "stops"


def _pair(seed: int) -> bool:
    return bool(robot_of(seed)) and _bends(seed)


DAMAGE: dict[str, Damage] = {
    "acceleration in g": Damage(
        _scaled, ("imu", "linear_acceleration", 1 / 9.80665), ("acceleration",)
    ),
    "gravity taken off": Damage(_without_gravity, (), ("acceleration",)),
    "gyro in degrees": Damage(
        _scaled, ("imu", "angular_velocity", 180 / np.pi), ("rate of turn",), _bends
    ),
    "gyro's sign": Damage(_scaled, ("imu", "angular_velocity", -1), ("gyro sign", "sides"), _bends),
    "IMU with z down": Damage(_turned, ([1, 0, 0], [0, -1, 0], [0, 0, -1]), ("axes",)),
    "IMU on its side": Damage(_turned, ([1, 0, 0], [0, 0, 1], [0, -1, 0]), ("axes",)),
    "IMU turned by 90 degrees": Damage(_turned, ([0, -1, 0], [1, 0, 0], [0, 0, 1]), ("axes",)),
    "wheel backwards": Damage(_ticks, (lambda ticks, _: -ticks,), ("axes", "sides")),
    "wheels swapped": Damage(_swapped, (), ("sides",), _pair),
    "tick ten times too long": Damage(_scaled, ("wheel", "metres_per_tick", 10.0), ("tick size",)),
    "tick ten times too short": Damage(_scaled, ("wheel", "metres_per_tick", 0.1), ("tick size",)),
    "counter anew": Damage(_ticks, (_anew,), ("counter",)),
    "counter of 16 bits": Damage(_ticks, (_overflows,), ("counter",)),
    "IMU lost for 2 s": Damage(_gap, ("imu", 2.0), ("gap",)),
    "wheel lost for 3 s": Damage(_gap, ("wheel", 3.0), ("gap",)),
    "radar lost for 3 s": Damage(_gap, ("gpr_trace", 3.0), ("gap",)),
    "wheel once a second": Damage(_rarely, ("wheel", 29), ("rate",)),
    "IMU late by 0.3 s": Damage(_late, ("imu", 0.3), ("clock",), _stops),
    "IMU of another clock": Damage(_late, ("imu", 1e6), ("clock",)),
    "stamps of arrival": Damage(_disordered, (), ("order",)),
    "IMU stuck": Damage(_stuck, (), ("stuck",)),
    "traces saturated": Damage(_traces, (_saturated,), ("saturated",)),
    "traces empty": Damage(_traces, (_empty,), ("empty",)),
    "traces repeated": Damage(_traces, (_frozen,), ("frozen",)),
    "traces by distance": Damage(_by_distance, (), ("trigger",)),
    "sample interval in tenths": Damage(
        _scaled, ("gpr_trace", "sample_interval", 0.1), ("sample interval",)
    ),
}


def codes_of(log: Log) -> list[str]:
    """What the doctor finds."""
    return [each.code for each in examine(log, ImuMounting(), BAND)]


def damaged(log: Log, name: str, seed: int) -> Log:
    """A copy with that damage."""
    copy = {role: dict(content) for role, content in log.items()}
    for content in copy.values():
        content.update({k: v.copy() for k, v in content.items() if isinstance(v, np.ndarray)})
    DAMAGE[name].change(copy, stream(seed, name), *DAMAGE[name].told)
    return copy


def main() -> None:
    """Measures and prints."""
    parser = parser_of(__doc__)
    parser.add_argument("--recordings", type=int, default=200, metavar="N")
    parser.add_argument("--damaged", type=int, default=20, metavar="N", help="of each kind")
    parser.add_argument("--first", type=int, default=0, metavar="SEED")
    args = parser.parse_args()
    found: dict[str, list[str]] = {}
    tried, named = dict.fromkeys(DAMAGE, 0), dict.fromkeys(DAMAGE, 0)
    missed: list[str] = []
    for seed in one_by_one("recordings", range(args.first, args.first + args.recordings)):
        log = recording(seed)
        codes = codes_of(log)
        if codes:
            found[str(seed)] = codes
        for name, damage in DAMAGE.items():
            if tried[name] < args.damaged and damage.shown(seed):
                tried[name] += 1
                seen = codes_of(damaged(log, name, seed))
                told = bool(set(seen) & set(damage.codes))
                named[name] += told
                if not told:
                    missed.append(f"{name}, {seed}: {seen}")
    rows = [{"damage": name, "tried": tried[name], "named": named[name]} for name in DAMAGE]
    figures = {
        "recordings": args.recordings,
        "found_in_good": len(found),
        "named": sum(named.values()) / max(sum(tried.values()), 1),
        "kinds": rows,
        "missed": missed,
        "good": found,
    }
    lines = [table_of(rows), *missed, *(f"good {seed}: {codes}" for seed, codes in found.items())]
    print_figures(args, figures, "\n".join(lines))


if __name__ == "__main__":
    exit_with(main)
