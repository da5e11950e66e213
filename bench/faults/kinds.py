"""The faults: each changes a robot's messages, in order of arrival, to those with a fault.

A message is (arrival, channel, data): microseconds, name, encoded message. Sensor data alone are
changed; truth stays.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from gprodom.lcm.messages import message
from log_events import Message

Random = np.random.Generator
Change = Callable[[bytes], bytes]

IMU, WHEEL, GPR = SENSORS = ("IMU", "WHEEL", "GPR_TRACE")
SECOND = 1_000_000  # us
HOUR = 3600 * SECOND
FOR_GOOD = math.inf

_UTIME, _ACCELERATION, _RATE, _TICKS, _SAMPLES = 8, 16, 40, 16, 56  # bytes into a message
_ACCELERATION_RANGE, _RATE_RANGE = 0.2, 0.02  # m/s^2 (x, y), rad/s: as of a sensor set too fine


@dataclass(frozen=True)
class Fault:
    """`apply` is given the messages, a source of chance and when the fault begins (us).

    seconds: how long it lasts; None: here and there over the whole run.
    told: STATUS can know of it. A constant offset of a clock, say, shows nowhere.
    jump: of all clocks, or of the IMU's, us; the poses may bear the times after it, or go on.
    """

    name: str
    apply: Callable[[list[Message], Random, int], list[Message]]
    seconds: float | None = None
    told: bool = True
    jump: float = 0.0


def get(data: bytes, at: int, form: str) -> tuple[float, ...]:
    """Values of a message, big-endian, by their place and the form of struct."""
    return struct.unpack_from(">" + form, data, at)


def put(data: bytes, at: int, form: str, *values: float) -> bytes:
    """The message with other values there."""
    changed = bytearray(data)
    struct.pack_into(">" + form, changed, at, *values)
    return bytes(changed)


def shifted(data: bytes, by_us: float) -> bytes:
    """The message with another stamp."""
    return put(data, _UTIME, "q", get(data, _UTIME, "q")[0] + round(by_us))


def sensors_of(channel: str) -> tuple[str, ...]:
    """The channels that a name stands for."""
    return SENSORS if channel == "all" else (channel,)


def during(channel: str, seconds: float, change: Change, name: str, **traits: Any) -> Fault:
    """Every message of a sensor is changed for a while."""

    def apply(messages: list[Message], _: Random, begin: int) -> list[Message]:
        end = begin + seconds * SECOND
        return [
            (t, c, change(d)) if c in sensors_of(channel) and begin <= t < end else (t, c, d)
            for t, c, d in messages
        ]

    return Fault(name, apply, seconds, **traits)


def gone(channel: str, seconds: float) -> Fault:
    """A sensor is silent."""

    def apply(messages: list[Message], _: Random, begin: int) -> list[Message]:
        end = begin + seconds * SECOND
        return [m for m in messages if m[1] not in sensors_of(channel) or not begin <= m[0] < end]

    length = "for good" if seconds == FOR_GOOD else f"{seconds:g} s"
    return Fault(f"{channel} gone {length}", apply, seconds)


def scattered(
    channel: str, share: float, change: Callable[[Message, Random], Iterable[Message]], name: str
) -> Fault:
    """A share of the messages is replaced, each by none, one or more; arrival decides the order."""

    def apply(messages: list[Message], rng: Random, _: int) -> list[Message]:
        hit = rng.random(len(messages)) < share
        changed: list[Message] = []
        for m, chosen in zip(messages, hit.tolist(), strict=True):
            use = chosen and m[1] in sensors_of(channel)
            changed += change(m, rng) if use else (m,)
        return sorted(changed, key=lambda m: m[0])

    return Fault(name, apply)


def delayed(m: Message, by_us: float) -> Message:
    """The message arriving later."""
    return (m[0] + round(by_us), m[1], m[2])


def bursts(seconds: float, every: float) -> Fault:
    """All sensors are lost for a moment, again and again."""

    def apply(messages: list[Message], _: Random, begin: int) -> list[Message]:
        def lost(t: int) -> bool:
            return t >= begin and (t - begin) % round(every * SECOND) < seconds * SECOND

        return [m for m in messages if m[1] not in SENSORS or not lost(m[0])]

    return Fault(f"all lost for {seconds:g} s every {every:g} s", apply)


def bit_flipped(m: Message, rng: Random) -> Iterable[Message]:
    """The message with one bit of all turned."""
    data = bytearray(m[2])
    data[rng.integers(0, len(data))] ^= 1 << int(rng.integers(0, 8))
    return [(m[0], m[1], bytes(data))]


def imu_values(data: bytes, value: float) -> bytes:
    """The first angular rate replaced."""
    return put(data, _RATE, "d", value)


def wheel_value(data: bytes, value: float) -> bytes:
    """The metres per tick replaced."""
    return put(data, _TICKS + 8, "d", value)


def saturated(data: bytes) -> bytes:
    """Horizontal acceleration and rates cut off at the range."""
    x, y, z = get(data, _ACCELERATION, "3d")
    limit, turn = _ACCELERATION_RANGE, _RATE_RANGE
    data = put(data, _ACCELERATION, "3d", *np.clip([x, y], -limit, limit), z)
    return put(data, _RATE, "3d", *np.clip(get(data, _RATE, "3d"), -turn, turn))


def biased(data: bytes, rate: float, acceleration: float) -> bytes:
    """Rate about z and acceleration along x with something added."""
    x, y, z = get(data, _ACCELERATION, "3d")
    p, q, r = get(data, _RATE, "3d")
    data = put(data, _ACCELERATION, "3d", x + acceleration, y, z)
    return put(data, _RATE, "3d", p, q, r + rate)


def drifting_clock(channel: str, ppm: float) -> Fault:
    """Stamps of a sensor whose clock is too fast."""

    def apply(messages: list[Message], _: Random, __: int) -> list[Message]:
        first = messages[0][0]
        return [
            (t, c, shifted(d, (t - first) * ppm * 1e-6)) if c == channel else (t, c, d)
            for t, c, d in messages
        ]

    return Fault(f"{channel} clock {ppm:g} ppm off", apply)


def by_the_first(
    channel: str, change: Callable[[bytes, bytes], bytes], name: str, seconds: float = FOR_GOOD
) -> Fault:
    """`change` is given a message and the sensor's first one after the fault began."""

    def apply(messages: list[Message], _: Random, begin: int) -> list[Message]:
        end = begin + seconds * SECOND
        first = next(d for t, c, d in messages if c == channel and t >= begin)
        return [
            (t, c, change(d, first)) if c == channel and begin <= t < end else (t, c, d)
            for t, c, d in messages
        ]

    return Fault(name, apply, seconds)


def with_stamp(data: bytes, first: bytes) -> bytes:
    """The stamp stays."""
    return put(data, _UTIME, "q", *get(first, _UTIME, "q"))


def with_values(data: bytes, first: bytes) -> bytes:
    """The values stay; the stamp goes on."""
    return put(first, _UTIME, "q", *get(data, _UTIME, "q"))


def wheel_from_zero(data: bytes, first: bytes) -> bytes:
    """The count begins again at zero."""
    return put(data, _TICKS, "q", get(data, _TICKS, "q")[0] - get(first, _TICKS, "q")[0])


def wheel_backwards(data: bytes, first: bytes) -> bytes:
    """From the first message on the count runs the other way."""
    return put(data, _TICKS, "q", 2 * get(first, _TICKS, "q")[0] - get(data, _TICKS, "q")[0])


def dead(data: bytes) -> bytes:
    """A trace of zeros."""
    return data[:_SAMPLES] + bytes(len(data) - _SAMPLES)


def shorter(data: bytes) -> bytes:
    """A trace of twenty samples less."""
    trace = message("gpr_trace_t").decode(data)
    trace.num_samples -= 20
    trace.samples = trace.samples[: trace.num_samples]
    return bytes(trace.encode())


def lost(share: float) -> Fault:
    """A share of all messages does not arrive."""
    return scattered("all", share, lambda m, _: (), f"{share:.0%} lost")


def duplicated(share: float) -> Fault:
    """A share of all messages arrives twice, at once or 40 ms later."""

    def twice(m: Message, rng: Random) -> Iterable[Message]:
        return m, delayed(m, rng.choice([0, 40_000]))

    return scattered("all", share, twice, f"{share:.0%} duplicated")


def reordered(share: float) -> Fault:
    """A share of all messages arrives up to 200 ms late."""

    def a_little(m: Message, rng: Random) -> Iterable[Message]:
        return (delayed(m, rng.uniform(0, 200_000)),)

    return scattered("all", share, a_little, f"{share:.0%} up to 200 ms late")


def late(share: float) -> Fault:
    """A share of all messages arrives later than any window."""

    def too_late(m: Message, rng: Random) -> Iterable[Message]:
        return (delayed(m, rng.uniform(0.5, 2) * SECOND),)

    return scattered("all", share, too_late, f"{share:.0%} 0.5 to 2 s late")


def stamps(channel: str) -> list[Fault]:
    """Stamps of one sensor, or of all, that jump: here and there, or for good."""
    jumps = {"+1 s": SECOND, "-1 s": -SECOND, "+1 h": HOUR, "-1 h": -HOUR}
    faults = []
    for name, jump in jumps.items():
        jumped = partial(shifted, by_us=jump)
        if channel != "all":
            faults.append(now_and_then(channel, jumped, f"{channel} 1% of stamps {name}"))
        for_good = f"{channel} stamps {name} for good"
        of_outputs = jump if channel in ("all", IMU) else 0.0
        faults.append(during(channel, FOR_GOOD, jumped, for_good, jump=of_outputs))
    return faults


def now_and_then(channel: str, change: Change, name: str) -> Fault:
    """One message of a hundred is changed."""
    return scattered(channel, 0.01, lambda m, _: ((m[0], m[1], change(m[2])),), name)


def all_faults() -> list[Fault]:
    """Every single fault."""
    shares = (0.01, 0.05, 0.2)
    faults = [make(share) for make in (lost, duplicated, reordered, late) for share in shares]
    faults.append(reordered(1.0))
    faults.append(bursts(0.5, 20))
    faults += [gone(channel, s) for channel in SENSORS for s in (1, 10, 60, FOR_GOOD)]
    faults.append(gone("all", 10))
    for channel in (*SENSORS, "all"):
        faults += stamps(channel)
    for channel in SENSORS:
        faults.append(by_the_first(channel, with_stamp, f"{channel} stamps stuck 5 s", 5))
        faults.append(by_the_first(channel, with_values, f"{channel} values stuck 5 s", 5))
        faults.append(scattered(channel, 0.01, bit_flipped, f"{channel} 1% a bit flipped"))
        faults.append(drifting_clock(channel, 100))
        late_clock, name = partial(shifted, by_us=50_000), f"{channel} stamps +50 ms"
        faults.append(during(channel, FOR_GOOD, late_clock, name, told=False))
    for name, value in (("NaN", math.nan), ("infinite", math.inf)):
        for channel, replaced in ((IMU, imu_values), (WHEEL, wheel_value)):
            bad = partial(replaced, value=value)
            faults.append(during(channel, 5, bad, f"{channel} {name} 5 s"))
            faults.append(during(channel, FOR_GOOD, bad, f"{channel} {name} for good"))
    # Of a robot that drives, 5 mg ahead are a slope of 5 mrad.
    slope, name = partial(biased, rate=0, acceleration=0.05), f"{IMU} accelerometer bias step"
    faults += [
        during(IMU, 5, saturated, f"{IMU} saturated 5 s"),
        during(IMU, FOR_GOOD, lambda d: biased(d, 0.005, 0), f"{IMU} gyro bias step"),
        during(IMU, FOR_GOOD, slope, name, told=False),
        during(IMU, FOR_GOOD, lambda d: biased(d, 0.005, 0.05), f"{IMU} bias step of both"),
        by_the_first(WHEEL, wheel_from_zero, f"{WHEEL} reset to zero"),
        by_the_first(WHEEL, wheel_backwards, f"{WHEEL} sign flipped"),
        during(GPR, FOR_GOOD, dead, f"{GPR} dead"),
        during(GPR, FOR_GOOD, shorter, f"{GPR} shorter"),
        now_and_then(GPR, shorter, f"{GPR} 1% shorter"),
    ]
    return faults


def combination(seed: int) -> Fault:
    """Three faults at once, drawn from those that leave an estimate to speak of."""
    rng = np.random.default_rng([seed, 20261121])
    pool = [
        fault
        for fault in all_faults()
        if fault.jump == 0.0 and not (fault.name.startswith(IMU) and fault.seconds == FOR_GOOD)
    ]
    drawn = [pool[i] for i in rng.choice(len(pool), 3, replace=False)]

    def apply(messages: list[Message], source: Random, begin: int) -> list[Message]:
        for fault in drawn:
            messages = fault.apply(messages, source, begin)
        return messages

    return Fault(" + ".join(f.name for f in drawn), apply, told=any(f.told for f in drawn))


def faults_of(combinations: int) -> dict[str, Fault]:
    """All there are, by name."""
    combined = [combination(seed) for seed in range(combinations)]
    return {fault.name: fault for fault in (*all_faults(), *combined)}
