"""All checks of a recording."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Any

import numpy as np

from gprodom.arrays import Ints
from gprodom.convert.plausible import examine as plausible
from gprodom.doctor import motion, radar, stamps
from gprodom.doctor.finding import Finding, Log
from gprodom.drive.imu_mounting import ImuMounting
from gprodom.lcm.antennas import apart
from gprodom.lcm.logs import select
from gprodom.odometry.dead_reckoning import has_wheel

UNITS = "`gprodom convert`'s options for units, or the driver"
# Findings of `convert.plausible` by a word of theirs.
_CODES = {
    "gravity": "acceleration",
    "rad/s": "rate of turn",
    "does not change": "stuck",
    "in common": "clock",
    "days between": "clock",
    "never turns": "wheel",
    "no messages": "gap",
    "m/s": "tick size",
}


def examine(
    log: Log,
    mounting: ImuMounting,
    band: tuple[float, float],
    places: Mapping[int, object] = MappingProxyType({}),
) -> list[Finding]:
    """What is wrong with a log read by roles, one finding of a kind; of several antennas, one of
    each. mounting: as configured; band: of the radar, Hz; places: gpr.antennas."""
    antennas = apart(log["gpr_trace"]) if "gpr_trace" in log else {}
    if len(antennas) < 2:
        return [*_first(_all(log, mounting, band)), *radar.check_antennas(antennas, places)]
    found: list[Finding] = []
    for antenna, traces in antennas.items():
        for each in _first(_all({**log, "gpr_trace": traces}, mounting, band)):
            whose = each.what.replace("radar", f"radar, antenna {antenna}", 1)
            if whose != each.what:
                found.append(replace(each, what=whose))
            elif antenna == next(iter(antennas)):  # of IMU and wheel: told once
                found.append(each)
    return [*found, *radar.check_antennas(antennas, places)]


def _first(found: Iterable[Finding]) -> list[Finding]:
    """Those that are the first of their kind."""
    first: dict[str, Finding] = {}
    for each in found:
        first.setdefault(each.code, each)
    return list(first.values())


def _all(log: Log, mounting: ImuMounting, band: tuple[float, float]) -> Iterator[Finding]:
    if "imu" not in log:
        yield Finding("imu missing", "there is no IMU", "channels.imu (-c, --set), or the driver")
    if not has_wheel(log):
        yield Finding(
            "wheel missing", "there is no wheel", "channels.wheel (-c, --set), or the driver"
        )
    paused = radar.by_distance(log)
    timing = [*stamps.check_stamps(log, paused)]
    yield from timing
    yield from radar.check_trigger(log)
    if "gpr_trace" in log and len(log["gpr_trace"]["utime"]) > 10:
        yield from radar.check_traces(log, band)
    if "imu" not in log or not has_wheel(log):
        return
    units = [*_units(log)]
    yield from units
    log = {role: _in_order(content) for role, content in log.items()}
    yield from motion.check_scale(log)
    yield from motion.check_stuck(log)
    counters = [*motion.check_counters(log)]
    yield from counters
    if units or counters:  # IMU and wheel cannot be compared
        return
    yield from motion.check_sides(log)
    mount = motion.mount_of(log, mounting.arm)
    mounted = mounting if mount is None else ImuMounting(mount.rpy, mounting.arm)
    log["imu"] = mounted.at_origin(log["imu"])
    yield from motion.check_axes(log, mounting.rpy, mount)
    yield from stamps.check_offsets(log)


def _units(log: Log) -> Iterator[Finding]:
    kinds = {"imu": "imu_t", "wheel": "wheel_t", "wheels": "wheel_t", "gpr_trace": "gpr_trace_t"}
    times: dict[str, Ints] = {kinds[role]: content["utime"] for role, content in log.items()}
    content: dict[str, dict[str, Any]] = {"imu_t": log["imu"]}
    pair = log.get("wheels")
    content["wheel_t"] = (
        log["wheel"]
        if pair is None
        else pair | {"ticks": 0.5 * np.add(pair["left_ticks"], pair["right_ticks"])}
    )
    found = plausible(times, content)
    for text in (*found.wrong, *found.doubtful):
        hint = ": is " in text
        code = next((code for word, code in _CODES.items() if word in text), "unit")
        yield Finding(code, text, UNITS if hint else "the driver, or cut the recording")


def _in_order(content: dict[str, Any]) -> dict[str, Any]:
    """By stamp, each stamp once."""
    _, order = np.unique(content["utime"], return_index=True)
    return select(content, order)
