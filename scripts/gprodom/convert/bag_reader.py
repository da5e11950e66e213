"""Reads a ROS bag with the rosbags library: which topic belongs to which sensor, and its messages.

The library raises whatever damage happens to hit: struct.error, errors of sqlite3 and zstd,
assertions, pages of message definitions. All of that becomes one line here.
"""

from collections.abc import Collection, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from gprodom.errors import Error, need_module
from gprodom.fixes.ros import KINDS as FIX_KINDS

ODOMETRY = "nav_msgs/msg/Odometry"
JOINTS = "sensor_msgs/msg/JointState"
KINDS = {
    "imu": ("sensor_msgs/msg/Imu",),
    "wheel": (ODOMETRY, "geometry_msgs/msg/TwistStamped", JOINTS),
    "truth": (
        "sensor_msgs/msg/NavSatFix",
        "geometry_msgs/msg/PointStamped",
        "geometry_msgs/msg/PoseStamped",
        "geometry_msgs/msg/PoseWithCovarianceStamped",
    ),
}
NEEDED = ("imu", "wheel")
NONE = "none"  # asked for in place of a topic: it is left out
TRACE_FIELDS = ("samples", "data")  # one of them holds a trace
_NOT_SAMPLES = {"int8", "uint8", "byte", "char", "bool", "string", "wstring"}  # bytes, pictures
_LONGEST = 200  # characters of the library's words that are passed on


@dataclass(frozen=True)
class Message:
    """A message of a bag. logged: ns, when it was recorded."""

    topic: str
    kind: str  # its type, such as sensor_msgs/msg/Imu
    logged: int
    content: Any


class Bag:
    """An open bag; `topics` gives the type of each topic."""

    def __init__(self, path: Path, reader: Any) -> None:
        self._path, self._reader = path, reader
        self.topics: dict[str, str] = {c.topic: c.msgtype for c in reader.connections}

    def count(self, topics: Collection[str]) -> int:
        """Number of messages on these topics, according to the bag."""
        return sum(c.msgcount for c in self._reader.connections if c.topic in topics)

    def messages(self, topics: Collection[str]) -> Iterator[Message]:
        """In the order of recording. Raises `Error` where the bag is damaged."""
        wanted = [
            c
            for c in self._reader.connections
            if c.topic in topics and c.msgtype == self.topics[c.topic]
        ]
        with _damage_told(self._path):
            for connection, logged, raw in self._reader.messages(wanted):
                content = self._reader.deserialize(raw, connection.msgtype)
                yield Message(connection.topic, connection.msgtype, logged, content)

    def traces(self) -> list[str]:
        """The topics whose messages hold an array of numbers wider than a byte, as traces do."""
        return sorted(topic for topic, kind in self.topics.items() if self._holds_samples(kind))

    def _holds_samples(self, kind: str) -> bool:
        _, fields = self._reader.typestore.fielddefs.get(kind, ((), ()))
        for name, (node, of) in fields:
            if name in TRACE_FIELDS and node.name in ("ARRAY", "SEQUENCE"):
                (inner, base), _ = of
                return inner.name == "BASE" and base[0] not in _NOT_SAMPLES
        return False


@contextmanager
def open_bag(path: Path) -> Iterator[Bag]:
    """A ROS 1 bag, a ROS 2 folder, .db3 or .mcap file."""
    need_module("rosbags", "bag")
    from rosbags.highlevel import AnyReader
    from rosbags.typesys import Stores, get_typestore

    if not path.exists():
        raise Error(f"{path}: no such bag")
    with _damage_told(path):
        # Bags of ROS 2 before Iron in sqlite3 do not say what their types are.
        reader = AnyReader([path], default_typestore=get_typestore(Stores.ROS2_HUMBLE))
        reader.open()
    try:
        yield Bag(path, reader)
    finally:
        reader.close()


@contextmanager
def _damage_told(path: Path) -> Iterator[None]:
    try:
        yield
    except Error:
        raise
    except Exception as error:
        said = " ".join(f"{type(error).__name__}: {error}".split())
        said = said if len(said) <= _LONGEST else said[:_LONGEST] + "..."
        raise Error(f"{path}: not a ROS bag, or a damaged one: {said}") from None


def choose_topics(path: Path, bag: Bag, asked: dict[str, str | None]) -> dict[str, str]:
    """The topics of imu, wheel, truth and gpr: as given, or the only one of a fitting type. Raises
    an error that tells all that are in question."""
    chosen: dict[str, str] = {}
    open_questions: list[str] = []
    for what in (*KINDS, "gpr"):
        topic = asked[what]
        if topic == NONE and what not in NEEDED:
            continue
        fitting = bag.traces() if what == "gpr" else _fitting(bag, KINDS[what])
        if topic is not None:
            _check(path, bag, what, topic)
            chosen[what] = topic
        elif len(fitting) == 1:
            chosen[what] = fitting[0]
        elif fitting or what in NEEDED:
            having = ", ".join(fitting) or f"none of {', '.join(KINDS[what])}"
            several = "; several --gpr: an antenna each" if what == "gpr" else ""
            without = "" if what in NEEDED else f" (--{what} {NONE} leaves it out)"
            open_questions.append(f"which topic is --{what}? It has {having}{without}{several}")
    if open_questions:
        raise Error(f"{path}: {'; '.join(open_questions)}")
    return chosen


def check_radars(path: Path, bag: Bag, topics: Sequence[str]) -> None:
    """Raises an error if one of several topics of --gpr is not there."""
    for topic in topics:
        _check(path, bag, "gpr", topic)


def check_fixes(path: Path, bag: Bag, topics: Sequence[str]) -> None:
    """Raises an error if one of the topics of --fix is not there, or of another type."""
    for topic in topics:
        if topic not in bag.topics:
            raise Error(f"{path}: no topic {topic}; it has {', '.join(sorted(bag.topics))}")
        if bag.topics[topic] not in FIX_KINDS:
            raise Error(
                f"{path}: {topic} is {bag.topics[topic]}; expected {' or '.join(FIX_KINDS)}"
            )


def _fitting(bag: Bag, kinds: tuple[str, ...]) -> list[str]:
    return sorted(topic for topic, kind in bag.topics.items() if kind in kinds)


def _check(path: Path, bag: Bag, what: str, topic: str) -> None:
    if topic not in bag.topics:
        raise Error(f"{path}: no topic {topic}; it has {', '.join(sorted(bag.topics))}")
    if what == "gpr":
        return
    # A pose of any kind will do for truth: the odometry of another system, too.
    kinds = (*KINDS[what], *((ODOMETRY,) if what == "truth" else ()))
    if bag.topics[topic] not in kinds:
        expected = " or ".join(KINDS[what])
        raise Error(f"{path}: {topic} is {bag.topics[topic]}; expected {expected}")
