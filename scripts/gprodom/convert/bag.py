"""ROS 1 (and 2) bags as channels: IMU, wheel odometry, positions, radar traces. Needs no ROS."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from gprodom.arrays import Floats, Ints
from gprodom.config import STANDARD, Channels
from gprodom.console import Progress
from gprodom.convert.bag_reader import (
    JOINTS,
    NEEDED,
    TRACE_FIELDS,
    Bag,
    check_fixes,
    check_radars,
    choose_topics,
    open_bag,
)
from gprodom.convert.cmu import VOLTS_PER_COUNT
from gprodom.convert.streams import gpr_stream, imu_stream, truth_stream
from gprodom.convert.wheels import WheelSpec, read_wheel, wheel_streams
from gprodom.errors import Error
from gprodom.fixes.record import Quality, one_stream
from gprodom.fixes.ros import fixes_of, read_fix
from gprodom.geodesy import local_positions
from gprodom.lcm.log_writer import Stream

_RADAR_FACTS = ("sample_interval", "time_zero", "volts_per_count")


@dataclass(frozen=True)
class Topics:
    """Which topic is what; None, of radars (): the bag's only one of a fitting type. See
    `choose_topics`."""

    imu: str | None = None
    wheel: str | None = None
    radars: tuple[str, ...] = ()  # of an antenna each; ("none",): no radar
    truth: str | None = None
    wheels: WheelSpec = field(default_factory=WheelSpec)
    fixes: tuple[str, ...] = ()  # positions for the estimator; their antenna_id: 0, 1, ...
    fix_quality: Quality | None = None  # of all of them; None: what their messages say
    sample_interval: float | None = None  # s, of the radar; None: what its messages say
    channels: Channels = STANDARD  # of the log to be written


@dataclass
class _Rows:
    time: list[int] = field(default_factory=list)  # us
    values: list[Any] = field(default_factory=list)

    def add(self, time: int, value: Any) -> None:
        """A message; None: there is nothing in it."""
        if value is not None:
            self.time.append(time)
            self.values.append(value)


def read_streams(path: Path, topics: Topics) -> list[Stream]:
    """The bag's messages as those of our logs, in order of stamps within each channel."""
    with open_bag(path) as bag:
        asked = {what: getattr(topics, what) for what in ("imu", "wheel", "truth")}
        found = choose_topics(path, bag, {**asked, "gpr": next(iter(topics.radars), None)})
        radars = (found.pop("gpr"), *topics.radars[1:]) if "gpr" in found else ()
        check_radars(path, bag, radars)
        if bag.topics[found["wheel"]] == JOINTS and not topics.wheels.radius > 0:
            raise Error(
                f"{path}: {found['wheel']} tells the angle of a joint: give the wheel's radius in "
                "metres, --wheel-radius M"
            )
        check_fixes(path, bag, topics.fixes)
        rows, radar, fixes = _read_rows(bag, found, radars, topics)
        kinds = {topic: bag.topics[topic] for topic in topics.fixes}
    for what in NEEDED:
        if not rows[what].time:
            raise Error(f"{path}: topic {found[what]} holds no messages that can be used")
    made = []
    for what, each in rows.items():
        if each.time:
            time, values, late = _ordered(each)
            made += [
                replace(one, out_of_order=late) for one in _streams(what, time, values, topics)
            ]
    return made + _radar_streams(path, radar, topics) + _fix_streams(fixes, kinds, topics)


def _read_rows(
    bag: Bag, found: dict[str, str], radars: tuple[str, ...], topics: Topics
) -> tuple[dict[str, _Rows], dict[str, _Rows], dict[str, _Rows]]:
    """What is kept of each message, by sensor, and of radars and fixes by topic. A topic may be
    both a sensor's and of fixes."""
    rows: dict[str, _Rows] = {what: _Rows() for what in found}
    fixes: dict[str, _Rows] = {topic: _Rows() for topic in topics.fixes}
    by_topic = {topic: what for what, topic in found.items()}
    radar: dict[str, _Rows] = {topic: _Rows() for topic in radars}
    wanted = {*by_topic, *radar, *fixes}
    with Progress("reading", bag.count(wanted)) as progress:
        for message in bag.messages(wanted):
            stamp = _stamp(message.content, message.logged)
            if message.topic in by_topic:
                what = by_topic[message.topic]
                rows[what].add(stamp, _VALUES[what](message.content, message.kind, topics))
            if message.topic in radar:
                radar[message.topic].add(stamp, _trace(message.content))
            if message.topic in fixes:
                fixes[message.topic].add(stamp, read_fix(message.content, message.kind))
            progress.advance()
    return rows, radar, fixes


def _fix_streams(fixes: dict[str, _Rows], kinds: dict[str, str], topics: Topics) -> list[Stream]:
    made = []
    late = 0
    for antenna, (topic, rows) in enumerate(fixes.items()):
        if rows.time:
            time, values, after = _ordered(rows)
            late += after
            made.append(fixes_of(topic, kinds[topic], time, values, antenna, topics.fix_quality))
    if not made:
        return []
    return [replace(one_stream(topics.channels.position_fix, made), out_of_order=late)]


def _stamp(message: Any, logged: int) -> int:
    """Microseconds: the header's stamp if it has one, otherwise the time of recording."""
    header = getattr(message, "header", None)
    if header is None or not header.stamp.sec:
        return logged // 1000
    return int(header.stamp.sec) * 1_000_000 + int(header.stamp.nanosec) // 1000


def _ordered(rows: _Rows) -> tuple[Ints, list[Any], int]:
    """In order of time, and how many messages stood after a later one."""
    time = np.array(rows.time, np.int64)
    order = np.argsort(time, kind="stable")
    late = int(np.count_nonzero(time < np.maximum.accumulate(time)))
    return time[order], [rows.values[i] for i in order.tolist()], late


def _xyz(vector: Any) -> tuple[float, float, float]:
    return vector.x, vector.y, vector.z


def _imu(message: Any, _kind: str, _topics: Topics) -> Any:
    q = message.orientation
    # ROS says with a covariance of -1 that there is no orientation; some say it with zeros.
    unit = abs(float(np.linalg.norm([q.w, q.x, q.y, q.z])) - 1) < 0.01
    known = unit and message.orientation_covariance[0] >= 0
    return (
        *_xyz(message.linear_acceleration),
        *_xyz(message.angular_velocity),
        float(known),
        q.w,
        q.x,
        q.y,
        q.z,
    )


def _truth(message: Any, kind: str, _topics: Topics) -> Any:
    if kind.endswith("NavSatFix"):
        if message.status.status < 0:
            return None
        return ("fix", message.latitude, message.longitude, message.altitude)
    point = message.point if kind.endswith("PointStamped") else message.pose
    while not hasattr(point, "x"):
        point = point.pose if hasattr(point, "pose") else point.position
    return ("point", *_xyz(point))


def _trace(message: Any) -> tuple[int, Floats, list[float]]:
    """Antenna, samples, and the fields of our GprTrace.msg that the message has; NaN: not in the
    message."""
    facts = [float(getattr(message, name, np.nan)) for name in _RADAR_FACTS]
    antenna = int(getattr(message, "antenna_id", 0))
    for name in TRACE_FIELDS:
        if hasattr(message, name):
            return antenna, np.asarray(getattr(message, name), np.float64), facts
    raise Error(f"--gpr: expected messages with an array {' or '.join(TRACE_FIELDS)}")


_VALUES: dict[str, Callable[[Any, str, Topics], Any]] = {
    "imu": _imu,
    "wheel": lambda message, kind, topics: read_wheel(message, kind, topics.wheels),
    "truth": _truth,
}


def _streams(what: str, time: Ints, values: list[Any], topics: Topics) -> list[Stream]:
    if what == "imu":
        table = np.array(values, np.float64)
        known = table[:, 6] > 0
        imu = topics.channels.imu
        return [imu_stream(imu, time, table[:, :3], table[:, 3:6], known, table[:, 7:])]
    if what == "wheel":
        return wheel_streams(time, values, topics.wheels, topics.channels)
    table = np.array([value[1:] for value in values], np.float64)
    positions = local_positions(table) if values[0][0] == "fix" else table
    return [truth_stream(time, positions)]


def _radar_streams(path: Path, radar: dict[str, _Rows], topics: Topics) -> list[Stream]:
    """Of each antenna. Topics have the antenna_id of their messages, where no two share one;
    otherwise their numbers, in order: messages often say 0, whose antenna they may be."""
    ids = {topic: {antenna for antenna, *_ in rows.values} for topic, rows in radar.items()}
    told = sum(map(len, ids.values())) == len(set().union(*ids.values()))
    antennas: dict[int, tuple[str, _Rows]] = {}
    for number, (topic, rows) in enumerate(radar.items()):
        if not told and len(ids[topic]) > 1:
            antennas_of = ", ".join(map(str, sorted(ids[topic])))
            raise Error(
                f"{path}: {topic} holds traces of the antennas {antennas_of}, "
                "of which another topic has one, too: give one of them to --gpr"
            )
        for stamp, (antenna, *value) in zip(rows.time, rows.values, strict=True):
            into = antennas.setdefault(antenna if told else number, (topic, _Rows()))
            into[1].add(stamp, value)
    made = []
    for id_, (topic, rows) in sorted(antennas.items()):
        time, values, late = _ordered(rows)
        made.append(replace(_gpr_stream(topic, id_, time, values, topics), out_of_order=late))
    return made


def _gpr_stream(topic: str, antenna: int, time: Ints, values: list[Any], topics: Topics) -> Stream:
    lengths = {len(samples) for samples, _ in values}
    if len(lengths) > 1:
        raise Error(f"{topic}: traces of {len(lengths)} different lengths")
    told, zero, volts = np.array([facts for _, facts in values], np.float64).T
    if topics.sample_interval is None and not np.all(told > 0):
        raise Error(
            f"{topic}: its messages do not tell the time between samples: give "
            "--sample-interval S (s), or --gpr none to leave it out"
        )
    return gpr_stream(
        topics.channels.gpr_trace,
        time,
        np.stack([samples for samples, _ in values]),
        topics.sample_interval or told,
        np.where(np.isnan(zero), 0.0, zero),
        np.where(np.isnan(volts), VOLTS_PER_COUNT, volts),
        antenna,
    )
