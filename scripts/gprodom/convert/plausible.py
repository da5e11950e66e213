"""Checks a conversion's result against what the sensors of a ground robot can measure.

A table in milliseconds, an accelerometer in g, or counts taken for a speed give a log that looks
like any other, and a wrong estimate. A clear mistake ends the conversion with advice; a doubtful
value gives a warning. The bounds are far from what robots do, so that no robot is refused: they
only detect wrong units, which differ by a factor of ten or more.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from gprodom.arrays import Floats, Ints
from gprodom.console import warn
from gprodom.errors import Error
from gprodom.lcm import wire
from gprodom.lcm.log_writer import Stream
from gprodom.lcm.messages import by_fingerprint

GRAVITY = 9.81  # m/s^2
STEADY_S = 2.0  # over which vibration and most of a robot's manoeuvres average out
GRAVITY_TOLERANCE = 1.5  # m/s^2; a standing MEMS triad is well within, a turning gyro never

SLOWEST_HZ = {"imu_t": 5.0, "wheel_t": 0.5}  # milliseconds taken for seconds make 0.1 Hz of 100 Hz
FASTEST_HZ = 50_000.0  # seconds taken for milliseconds make 100 kHz of 100 Hz
LONG_GAP_S = 2.0  # of IMU or wheel, which is told
GAP_RATIO = 10.0  # times the median interval, from which an interval is a gap
LONGEST_GAP_S = 86_400.0  # between two messages of a recording
TURN_RAD_S = 2 * np.pi  # a turn a second, as a mean over half a second; deg/s are 57 times as much
SPEED_M_S = 60.0  # as a mean over half a second
WHEEL_OVER_IMU = (
    10.0  # wheel's over body's change of speed; 0.3 to 1.3 on robots that slip and cars
)
SPINNING_M_S = 0.3  # a wheel that changes its speed by less says nothing of its unit
LEAST_COMMON = 0.5  # of the longer of IMU and wheel
LEAST_S = 2.0  # of a sensor's recording, for its span to say anything
MOST_CONSTANT = 0.1  # of the recording, in which a sensor's values do not change at all
_NAMES = {"imu_t": "IMU", "wheel_t": "wheel", "gpr_trace_t": "radar"}


@dataclass
class Findings:
    """What is clearly wrong, and what may be."""

    wrong: list[str] = field(default_factory=list)
    doubtful: list[str] = field(default_factory=list)


def check_streams(streams: Sequence[Stream]) -> None:
    """Raises `Error` if the streams are clearly wrong, and warns if they are doubtful."""
    times: dict[str, Ints] = {}
    content = {}
    for stream in streams:
        name = by_fingerprint()[stream.payloads[0][:8]] if len(stream.payloads) else ""
        kind = "wheel_t" if name == "wheels_t" else name
        if kind in _NAMES:
            further = f" {stream.antenna_id}" if kind in times else ""
            times[kind + further] = stream.utime
        if kind in ("imu_t", "wheel_t"):
            content[kind] = wire.decode(name, stream.payloads, stream.channel)
        if name == "wheels_t":  # their mean is the wheel
            sides = np.add(content[kind]["left_ticks"], content[kind]["right_ticks"])
            content[kind]["ticks"] = 0.5 * sides
    found = examine(times, content)
    for text in found.doubtful:
        warn(text)
    if found.wrong:
        raise Error("; ".join(found.wrong))


def examine(times: Mapping[str, Ints], content: Mapping[str, Mapping[str, Any]]) -> Findings:
    """times: stamps (n,), microseconds, by type (imu_t, wheel_t, gpr_trace_t, with a space and its
    antenna_id that of a further antenna); content: fields of
    imu_t and wheel_t, a pair of wheels as their mean."""
    found = Findings()
    for kind, utime in times.items():
        _check_stamps(kind, utime, found)
    if not found.wrong:  # else spans and rates of change mean nothing
        _check_spans(times, found)
    if not found.wrong and {"imu_t", "wheel_t"} <= content.keys():
        imu, wheel = content["imu_t"], content["wheel_t"]
        _check_imu(imu["utime"], imu["linear_acceleration"], imu["angular_velocity"], found)
        distance: Floats = np.multiply(wheel["ticks"], wheel["metres_per_tick"])
        _check_wheel(wheel["utime"], distance, imu["utime"], imu["linear_acceleration"], found)
    return found


def _check_stamps(kind: str, utime: Ints, found: Findings) -> None:
    if len(utime) < 10:
        return
    name, steps = _name(kind), np.diff(utime) * 1e-6
    median = float(np.median(steps))
    rate = 1 / median if median > 0 else np.inf
    longest = int(np.argmax(steps))
    if steps[longest] > LONGEST_GAP_S:
        found.wrong.append(
            f"{name}: {steps[longest] / 86400:.3g} days between messages {longest + 1} and "
            f"{longest + 2}: is one of them no data (a line of column numbers), or of another "
            "clock?"
        )
    elif kind in SLOWEST_HZ and steps[longest] > max(LONG_GAP_S, GAP_RATIO * median):
        found.doubtful.append(
            f"{name}: no messages for {steps[longest]:.1f} s, from {steps[:longest].sum():.1f} s "
            "after its first on"
        )
    if rate < SLOWEST_HZ.get(kind, 0.0):
        found.wrong.append(
            f"{name}: {rate:.3g} messages a second: are its stamps in milliseconds or smaller, "
            "taken for seconds (tables: --time-unit)?"
        )
    if rate > FASTEST_HZ:
        found.wrong.append(
            f"{name}: {rate:.3g} messages a second: are its stamps in seconds or milliseconds, "
            "taken for something smaller (tables: --time-unit), or the same in many rows?"
        )


def _name(kind: str) -> str:
    kind, _, antenna = kind.partition(" ")
    return f"{_NAMES[kind]} {antenna}".rstrip()


def _check_spans(times: Mapping[str, Ints], found: Findings) -> None:
    """IMU and wheel must overlap in time; a radar may be switched on later."""
    spans = {kind: (int(t[0]) * 1e-6, int(t[-1]) * 1e-6) for kind, t in times.items() if len(t)}
    if not {"imu_t", "wheel_t"} <= spans.keys():
        return
    lengths = {kind: end - start for kind, (start, end) in spans.items()}
    longest = max(lengths["imu_t"], lengths["wheel_t"])
    if longest < LEAST_S:
        return
    for kind in spans:
        if kind == "imu_t":
            continue
        start, end = (
            max(spans["imu_t"][0], spans[kind][0]),
            min(spans["imu_t"][1], spans[kind][1]),
        )
        common = max(end - start, 0.0)
        share = common / longest
        text = f"IMU and {_name(kind)} have {common:.1f} s in common, of {longest:.1f} s"
        apart = share == 0 or (kind == "wheel_t" and share < LEAST_COMMON)
        if apart and min(lengths["imu_t"], lengths[kind]) >= LEAST_S:
            found.wrong.append(
                f"{text}: are the stamps of one clock and in one unit, is one of them cut short? "
                "Cut the recording to where it has both"
            )
        elif share < 0.95:
            found.doubtful.append(text)


def _check_imu(utime: Ints, acceleration: Floats, rate: Floats, found: Findings) -> None:
    # Of means: shaking, and turns to either side, make the force of single samples too large.
    norm = float(np.median(np.linalg.norm(_means(utime, acceleration, STEADY_S), axis=1)))
    if abs(norm - GRAVITY) > GRAVITY_TOLERANCE:
        found.wrong.append(
            f"IMU: the acceleration has a median of {norm:.3g} m/s^2, expected gravity, {GRAVITY}: "
            "is it in g (tables: --acceleration-unit g), or has gravity been taken off?"
        )
    turn = float(np.abs(_means(utime, rate, 0.5)).max(initial=0.0))
    if turn > TURN_RAD_S / 2:
        text = (
            f"IMU: turns at up to {turn:.3g} rad/s: are its rates in degrees (tables: --rate-unit "
            "deg/s)?"
        )
        (found.wrong if turn > TURN_RAD_S else found.doubtful).append(text)
    for name, values in (("acceleration", acceleration), ("angular rate", rate)):
        constant = longest_constant(utime, values)
        if constant > max(5.0, MOST_CONSTANT * (int(utime[-1]) - int(utime[0])) * 1e-6):
            found.doubtful.append(f"IMU: the {name} does not change at all for {constant:.1f} s")


def _check_wheel(
    utime: Ints, distance: Floats, imu_utime: Ints, acceleration: Floats, found: Findings
) -> None:
    if len(utime) < 3:
        return
    if not np.ptp(distance):
        found.doubtful.append("wheel: it never turns")
        return
    grid = np.arange(max(utime[0], imu_utime[0]), min(utime[-1], imu_utime[-1]), 100_000)
    if len(grid) < 30:
        return
    speed = np.diff(np.interp(grid, utime, distance)[::5]) / 0.5
    fastest = float(np.abs(speed).max())
    if fastest > SPEED_M_S:
        found.wrong.append(
            f"wheel: {fastest:.3g} m/s: is it in counts, millimetres or km/h (tables: "
            "--wheel-counts, --counts-per-metre, --speed-unit)?"
        )
        return
    changes = _spread(np.diff(speed[::2])[:, None])
    force = _means(imu_utime, acceleration, 1.0)
    felt = _spread(force - np.median(force, axis=0)) if len(force) else 0.0
    if changes > SPINNING_M_S and changes > WHEEL_OVER_IMU / 3 * max(felt, 1e-3):
        text = (
            f"wheel: its speed changes by {changes:.2g} m/s a second where the accelerometer feels "
            f"{felt:.2g} m/s^2: is it in counts (tables: --wheel-counts, --counts-per-metre)?"
        )
        far = changes > WHEEL_OVER_IMU * max(felt, 1e-3)
        (found.wrong if far else found.doubtful).append(text)


def _means(utime: Ints, values: Floats, seconds: float) -> Floats:
    """(m, 3): means of values (n, 3) over stretches of `seconds` that have samples."""
    stretch = ((utime - utime[0]) * 1e-6 / seconds).astype(np.int64)
    _, first = np.unique(stretch, return_index=True)
    counts = np.diff(np.append(first, len(stretch)))
    return np.asarray(np.add.reduceat(values, first, axis=0) / counts[:, None])


def _spread(values: Floats) -> float:
    """Root mean square of the norms of values (n, d)."""
    return float(np.sqrt(np.mean(np.sum(values**2, axis=1)))) if len(values) else 0.0


def longest_constant(utime: Ints, values: Floats) -> float:
    """Seconds of the longest stretch in which values (n, 3) stay the same to the last bit; time
    without a message is none of it."""
    steps = np.diff(utime)
    steps = np.where(steps > GAP_RATIO * np.median(steps), 0, steps)
    changed = np.flatnonzero(np.any(np.diff(values, axis=0) != 0, axis=1)) + 1
    lasted = np.concatenate([[0], np.cumsum(steps)])
    edges = lasted[np.concatenate([[0], changed, [len(utime) - 1]])]
    return float(np.diff(edges).max(initial=0)) * 1e-6
