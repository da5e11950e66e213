"""Wheels of bags and tables: poses, speeds and joints to distances, of one wheel or two sides."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from gprodom import rotation
from gprodom.arrays import Floats, Ints, integral, sums
from gprodom.config import STANDARD, Channels
from gprodom.console import warn
from gprodom.convert.any_table import read_named
from gprodom.convert.layout import Layout, Source
from gprodom.convert.table import Table
from gprodom.errors import Error, UsageError
from gprodom.lcm.log_writer import Stream, encoded

QUANTUM = 1e-5  # m per tick of a wheel that reports metres
BEYOND_USUAL = 3.0  # times as fast as a wheel usually turns at most; no robot does it in one step
_SOURCES = ("wheel_speed", "wheel_distance", "wheel_counts")  # of tables
OVERFLOWS = (1 << 16, 1 << 32)  # counts after which a counter begins anew

Row = tuple[str, float, float, float, float]  # what it is of, and its numbers


@dataclass(frozen=True)
class WheelSpec:
    """Which fields of a bag's messages are the wheel, or the two sides."""

    radius: float = 0.0  # m, of a joint's wheel
    joint: str | None = None  # its name; None: the message's first
    left: tuple[str, ...] = ()  # joints of the left side; with `right`, these are the wheels
    right: tuple[str, ...] = ()
    # m, between the sides of which a driver made an odometry or a twist. Above 0, left and right
    # are made of its speed and yaw rate again.
    track: float = 0.0


def read_wheel(message: Any, kind: str, spec: WheelSpec) -> Row | None:
    """What `wheel_streams` needs of a message of type `kind`; None where its joints are missing."""
    if kind.endswith("Odometry"):
        pose, rate = message.pose.pose, message.twist.twist.angular.z
        q = pose.orientation
        yaw = rotation.yaw_of(np.array([q.w, q.x, q.y, q.z]))
        return "pose", pose.position.x, pose.position.y, float(yaw), rate
    if kind.endswith("TwistStamped"):
        return "speed", message.twist.linear.x, message.twist.angular.z, 0.0, 0.0
    angles = dict(zip(message.name, message.position, strict=False))
    if spec.left:
        if not angles.keys() >= {*spec.left, *spec.right}:
            return None
        left, right = (
            float(np.mean([angles[name] for name in side])) * spec.radius
            for side in (spec.left, spec.right)
        )
        return "sides", left, right, 0.0, 0.0
    joint = spec.joint if spec.joint is not None else next(iter(angles), None)
    if joint not in angles:
        return None
    return "joint", angles[joint] * spec.radius, 0.0, 0.0, 0.0


def wheel_streams(
    time: Ints, rows: list[Row], spec: WheelSpec, channels: Channels = STANDARD
) -> list[Stream]:
    """The messages of `read_wheel`'s rows, all of one kind."""
    kind, table = rows[0][0], np.array([row[1:] for row in rows], np.float64)
    if kind == "sides":
        return [pair_stream(channels.wheels, time, table[:, 0], table[:, 1])]
    if kind == "pose":
        distance, rate = along_poses(table[:, :3]), table[:, 3]
    elif kind == "speed":
        distance, rate = added_up(time, table[:, 0]), table[:, 1]
    else:
        distance, rate = table[:, 0] - table[0, 0], None
    if spec.track > 0 and rate is not None:
        half = 0.5 * spec.track * added_up(time, rate)
        return [pair_stream(channels.wheels, time, distance - half, distance + half)]
    return [wheel_stream(channels.wheel, time, distance)]


def along_poses(poses: Floats) -> Floats:
    """Signed cumulative distance (n,), m, of poses x, y, yaw (n, 3).

    Each step is projected on the heading in its middle.
    """
    yaw = np.unwrap(poses[:, 2])
    middle = 0.5 * (yaw[1:] + yaw[:-1])
    dx, dy = np.diff(poses[:, 0]), np.diff(poses[:, 1])
    return sums(dx * np.cos(middle) + dy * np.sin(middle))


@dataclass(frozen=True)
class Counter:
    """values (n,) of a counter that goes on where the encoder's began again; how often it had
    restarted at zero and overflowed; when first, s after its first value."""

    values: Floats
    restarts: int
    wraps: int
    first_s: float


def continued(time: Ints, values: Floats) -> Counter:
    """A counter (n,) at `time` (n,), us, without the jumps of a restart at zero and of an overflow
    of 16 or 32 bits.

    Both are `BEYOND_USUAL` times as fast as the wheel turns in all but a two-hundredth of the time.
    A restart lands on zero, an overflow on the value before less its size, within what the wheel
    usually turns from one value to the next.
    """
    steps = np.diff(values)
    rate = np.abs(steps) / np.maximum(np.diff(time), 1)
    moving = rate > 0
    usual = float(np.quantile(rate[moving], 0.995)) if moving.any() else 0.0
    jump = rate > BEYOND_USUAL * usual if usual > 0 else np.zeros(len(steps), bool)
    normal = np.abs(steps[~jump])
    reach = BEYOND_USUAL * (float(np.quantile(normal, 0.995)) if normal.size else 0.0)
    wrapped = np.zeros(len(steps))
    for size in OVERFLOWS if np.all(values == np.rint(values)) else ():
        near = jump & (np.abs(np.abs(steps) - size) <= reach)
        wrapped[near] = -np.sign(steps[near]) * size
    restarted = jump & (wrapped == 0) & (np.abs(values[1:]) <= reach)
    restarted &= np.abs(values[:-1]) > reach
    steps = np.where(restarted, values[1:], steps + wrapped)
    begins = np.flatnonzero(restarted | (wrapped != 0))
    return Counter(
        values[0] + sums(steps),
        int(restarted.sum()),
        int(np.count_nonzero(wrapped)),
        float(time[begins[0] + 1] - time[0]) * 1e-6 if len(begins) else 0.0,
    )


def added_up(time: Ints, rate: Floats) -> Floats:
    """The integral of a rate (n, ...) per second over `time` (n,), us, by means of neighbours."""
    return integral(rate, (time - time[:1]) * 1e-6)


def wheel_stream(channel: str, time: Ints, distance: Floats) -> Stream:
    """Wheel messages of a cumulative distance (n,), m."""
    return encoded(channel, "wheel_t", time, ticks=_ticks(distance), metres_per_tick=QUANTUM)


def pair_stream(channel: str, time: Ints, left: Floats, right: Floats) -> Stream:
    """Messages of the two sides' cumulative distances (n,), m."""
    ticks = {"left_ticks": _ticks(left), "right_ticks": _ticks(right)}
    return encoded(channel, "wheels_t", time, **ticks, metres_per_tick=QUANTUM)


def _ticks(distance: Floats) -> Ints:
    return np.rint(distance / QUANTUM).astype(np.int64)


def wheels_of_tables(
    layout: Layout, channels: Channels, left: Sequence[int], right: Sequence[int], strict: bool
) -> Stream:
    """Of the one source of a wheel, or of several; of two sides where both are told."""
    given = [name for name in _SOURCES if name in layout.sources]
    if len(given) != 1:
        options = ", ".join("--" + name.replace("_", "-") for name in _SOURCES)
        raise UsageError(f"one of {options} is wanted, got {len(given)}")
    (name,) = given
    source = layout.sources[name]
    table = read_named(layout, name, range(2, 20), strict)
    travelled = table.values
    if name != "wheel_speed":
        travelled = _continued(source, table)
    if name == "wheel_speed":
        _check_speed(source, table)
        travelled = added_up(table.utime, travelled * layout.factor("speed_unit"))
    elif name == "wheel_counts":
        if "counts_per_metre" not in layout.settings:
            raise UsageError("--wheel-counts: how many make a metre? Give --counts-per-metre N")
        travelled = travelled / float(layout.settings["counts_per_metre"])
    travelled = travelled - travelled[0]
    if not left and not right:
        stream = wheel_stream(channels.wheel, table.utime, travelled.mean(axis=1))
        return replace(stream, out_of_order=table.out_of_order)
    wheels = travelled.shape[1]
    if not left or not right or max(*left, *right) > wheels:
        raise UsageError(f"--left and --right: expected wheels 1 to {wheels} for both sides")
    sides = (travelled[:, [wheel - 1 for wheel in side]].mean(axis=1) for side in (left, right))
    stream = pair_stream(channels.wheels, table.utime, *sides)
    return replace(stream, out_of_order=table.out_of_order)


def _continued(source: Source, table: Table) -> Floats:
    """The values (n, wheels) of counters that went on where they began again; that is told."""
    columns = [continued(table.utime, column) for column in table.values.T]
    for wheel, column in enumerate(columns, start=1):
        for count, how in ((column.restarts, "starts again at zero"), (column.wraps, "overflows")):
            if count:
                warn(
                    f"{source.file}: the counter of wheel {wheel} {how} {count} times, first "
                    f"{column.first_s:.1f} s after its first row: it is carried on there"
                )
    return np.column_stack([column.values for column in columns])


def _check_speed(source: Source, table: Table) -> None:
    """Detects a column of speed that is a distance or a count: it never falls."""
    lasts = float(table.utime[-1] - table.utime[0]) * 1e-6
    for column in table.values.T:
        steps = np.diff(column)
        if lasts > 10 and np.all(steps >= 0) and np.count_nonzero(steps) > 0.2 * len(steps):
            raise Error(
                f"{source.file}: the wheel's speed grows for {lasts:.0f} s and never falls: is it "
                "a distance or a count (--wheel-distance, --wheel-counts with --counts-per-metre)?"
            )
