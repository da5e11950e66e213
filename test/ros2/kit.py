"""What the tests of the ROS 2 node share: messages by rosbags, plans for the peer, programs."""

from __future__ import annotations

import math
import os
import struct
import subprocess
import time
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from gprodom.lcm import EventLog
from gprodom.lcm.messages import message

CHECKOUT = Path(__file__).resolve().parents[2]
BIN = Path(os.environ.get("GPRODOM_ROS2_BUILD", CHECKOUT / "build-ros2")) / "bin"
NO_PEER = BIN.parent / "no-peer"  # why there is none, where Fast DDS is of another kind
PACKAGE = CHECKOUT / "ros2" / "gprodom_msgs"
IS_SANITIZED = bool(os.environ.get("GPRODOM_SANITIZE"))  # slower, and larger
PATIENCE_S = 240.0 if IS_SANITIZED else 60.0

IMU, ODOMETRY, TF = "sensor_msgs/msg/Imu", "nav_msgs/msg/Odometry", "tf2_msgs/msg/TFMessage"
TWIST, JOINTS = "geometry_msgs/msg/TwistStamped", "sensor_msgs/msg/JointState"
DIAGNOSTICS, LOG = "diagnostic_msgs/msg/DiagnosticArray", "rcl_interfaces/msg/Log"
PLACE = "geometry_msgs/msg/PoseWithCovarianceStamped"
TRACE, COMMAND = "gprodom_msgs/msg/GprTrace", "gprodom_msgs/msg/Command"


@cache
def store() -> Any:
    """ROS 2 types and ours, from the package as a user gets it."""
    known = get_typestore(Stores.ROS2_HUMBLE)
    for path in sorted((PACKAGE / "msg").glob("*.msg")):
        name = f"gprodom_msgs/msg/{path.stem}"
        known.register(get_types_from_msg(path.read_text(), name))
    return known


def on_the_wire(kind: str) -> str:
    """sensor_msgs/msg/Imu -> sensor_msgs::msg::dds_::Imu_."""
    package, folder, name = kind.split("/")
    return f"{package}::{folder}::dds_::{name}_"


def from_the_wire(name: str) -> str:
    """sensor_msgs::msg::dds_::Imu_ -> sensor_msgs/msg/Imu."""
    return name.replace("::dds_::", "/").replace("::", "/").removesuffix("_")


def make(kind: str, **fields: Any) -> Any:
    return store().types[kind](**fields)


def to_cdr(kind: str, value: Any) -> bytes:
    return bytes(store().serialize_cdr(value, kind))


def from_cdr(kind: str, data: bytes) -> Any:
    return store().deserialize_cdr(data, kind)


def header(utime: int, frame: str = "") -> Any:
    sec, micro = divmod(utime, 1_000_000)
    stamp = make("builtin_interfaces/msg/Time", sec=sec, nanosec=micro * 1000)
    return make("std_msgs/msg/Header", stamp=stamp, frame_id=frame)


def utime_of(stamp: Any) -> int:
    return int(stamp.sec) * 1_000_000 + int(stamp.nanosec) // 1000


def vector(x: float = 0.0, y: float = 0.0, z: float = 0.0, kind: str = "Vector3") -> Any:
    return make(f"geometry_msgs/msg/{kind}", x=float(x), y=float(y), z=float(z))


def level(w: float = 1.0) -> Any:
    return make("geometry_msgs/msg/Quaternion", x=0.0, y=0.0, z=0.0, w=w)


def imu(utime: int, acceleration: Any, rate: Any) -> Any:
    none = np.zeros(9)
    return make(
        IMU,
        header=header(utime, "imu"),
        orientation=level(),
        orientation_covariance=none,
        angular_velocity=vector(*rate),
        angular_velocity_covariance=none,
        linear_acceleration=vector(*acceleration),
        linear_acceleration_covariance=none,
    )


def twist(linear_x: float = 0.0, yaw_rate: float = 0.0) -> Any:
    return make("geometry_msgs/msg/Twist", linear=vector(linear_x), angular=vector(z=yaw_rate))


def wheel_odometry(utime: int, distance_m: float, yaw_rate: float = 0.0) -> Any:
    pose = make(
        "geometry_msgs/msg/Pose", position=vector(distance_m, kind="Point"), orientation=level()
    )
    some = np.zeros(36)
    return make(
        ODOMETRY,
        header=header(utime, "odom"),
        child_frame_id="base_link",
        pose=make("geometry_msgs/msg/PoseWithCovariance", pose=pose, covariance=some),
        twist=make(
            "geometry_msgs/msg/TwistWithCovariance", twist=twist(0, yaw_rate), covariance=some
        ),
    )


def joints(utime: int, names: list[str], angles: list[float]) -> Any:
    none = np.zeros(0)
    position = np.array(angles, float)
    return make(
        JOINTS, header=header(utime), name=names, position=position, velocity=none, effort=none
    )


def trace(m: Any) -> Any:
    """`m`: gpr_trace_t."""
    return make(
        TRACE,
        header=header(m.utime, "gpr_antenna"),
        trace=m.seq,
        antenna_id=m.antenna_id,
        sample_interval=m.sample_interval,
        time_zero=m.time_zero,
        volts_per_count=m.volts_per_count,
        samples=np.array(m.samples, np.int32),
    )


@dataclass
class Record:
    """Of a plan, or of what a peer has written down; `raw`: sent as it is; there: received."""

    at_ns: int
    topic: str  # without rt
    kind: str  # as ROS 2 names it
    cdr: bytes
    raw: bool = False

    def value(self) -> Any:
        return from_cdr(self.kind, self.cdr)


def write_plan(path: Path, records: list[Record]) -> None:
    with path.open("wb") as file:
        for r in sorted(records, key=lambda record: record.at_ns):
            file.write(struct.pack("<bq", r.raw, r.at_ns))
            for text in (f"rt{r.topic}".encode(), on_the_wire(r.kind).encode(), r.cdr):
                file.write(struct.pack("<I", len(text)) + text)


def read_out(path: Path) -> list[Record]:
    """The whole records in a file that may still grow."""
    data = path.read_bytes()
    records: list[Record] = []
    at = 0
    while len(data) >= at + 9:
        received, at_ns = struct.unpack_from("<bq", data, at)
        at += 9
        texts = []
        for _ in range(3):
            if len(data) < at + 4:
                return records
            (size,) = struct.unpack_from("<I", data, at)
            texts.append(data[at + 4 : at + 4 + size])
            at += 4 + size
        if len(data) < at:
            return records
        topic, kind = (text.decode() for text in texts[:2])
        topic, kind = topic.removeprefix("rt"), from_the_wire(kind)
        records.append(Record(at_ns, topic, kind, texts[2], bool(received)))
    return records


def plan_of(
    log: Path, speed: float, wheel: str = "odometry", until_s: float = math.inf
) -> list[Record]:
    """The sensors of an LCM log as ROS 2 messages, at `speed` times real time."""
    records = []
    first = last_utime = 0
    last_m = speed_m_s = 0.0
    for event in EventLog(str(log)):
        names = {"IMU": "imu_t", "WHEEL": "wheel_t", "GPR_TRACE": "gpr_trace_t"}
        if event.channel not in names:
            continue
        m = message(names[event.channel]).decode(event.data)
        first = first or m.utime
        if (m.utime - first) * 1e-6 > until_s:
            break
        if event.channel == "IMU":
            sent = ("/imu/data", IMU, imu(m.utime, m.linear_acceleration, m.angular_velocity))
        elif event.channel == "GPR_TRACE":
            sent = ("/gpr", TRACE, trace(m))
        else:
            distance_m = m.ticks * m.metres_per_tick
            if wheel == "odometry":
                sent = ("/wheel", ODOMETRY, wheel_odometry(m.utime, distance_m))
            elif wheel == "joints":
                names_ = ["arm", "left", "right"]
                value = joints(m.utime, names_, [1.0, distance_m / 0.1, distance_m / 0.1])
                sent = ("/wheel", JOINTS, value)
            else:
                # The speeds whose integral by the trapezoidal rule is the distance.
                if last_utime:
                    mean_m_s = (distance_m - last_m) / ((m.utime - last_utime) * 1e-6)
                    speed_m_s = 2 * mean_m_s - speed_m_s
                last_m, last_utime = distance_m, m.utime
                value = make(TWIST, header=header(m.utime), twist=twist(speed_m_s))
                sent = ("/wheel", TWIST, value)
        topic, kind, value = sent
        at_ns = int((m.utime - first) * 1000 / speed)
        records.append(Record(at_ns, topic, kind, to_cdr(kind, value)))
    return records


# ---- programs ----


def wait_for(what: str, happened: Any, patience_s: float = PATIENCE_S) -> None:
    deadline = time.monotonic() + patience_s
    while not happened():
        assert time.monotonic() < deadline, f"in vain: {what}"
        time.sleep(0.05)


class Node:
    """gprodom_ros2 while it runs; its log is folder/NAME.log, to which each start adds."""

    def __init__(self, folder: Path, *arguments: str, name: str = "node") -> None:
        self._log = folder / f"{name}.log"
        command = [str(BIN / "gprodom_ros2"), "-p", "wheel:=wheel", *arguments]
        starts = self.said().count(" runs: ")
        with self._log.open("ab") as said:
            self.process = subprocess.Popen(command, stderr=said)
        wait_for(f"the node starts: {command}", lambda: self.said().count(" runs: ") > starts)

    def __enter__(self) -> Node:
        return self

    def __exit__(self, *_: object) -> None:
        self.end()

    def said(self) -> str:
        return self._log.read_text() if self._log.exists() else ""

    def end(self) -> None:
        """Ends it, unless it has ended; it must not have ended by itself with an error."""
        self.process.terminate()
        assert self.process.wait(PATIENCE_S) == 0, self.said()


class Peer:
    """The program on Fast DDS while it runs."""

    def __init__(
        self,
        folder: Path,
        name: str,
        plan: list[Record],
        topics: dict[str, tuple[str, str]],
        *options: str,
    ) -> None:
        if NO_PEER.is_file():
            pytest.skip(NO_PEER.read_text())
        self.out = folder / f"{name}.out"
        write_plan(folder / f"{name}.plan", plan)
        command = [str(BIN / "peer"), str(folder / f"{name}.plan"), str(self.out), *options]
        for topic, (kind, quality) in topics.items():
            command += ["--subscribe", f"rt{topic}", on_the_wire(kind), quality]
        self._diagnostics = "/diagnostics" in topics
        self._topics = {r.topic for r in plan}
        self.process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE)

    def _await(self, line: bytes) -> Peer:
        assert self.process.stdout is not None
        assert self.process.stdout.readline() == line
        return self

    def matched(self, beside: int = 0) -> Peer:
        """Once it is linked to the node, and where it hears diagnostics the node to it.

        `beside`: topics that other peers publish. From here on it sends.
        """
        self._await(b"matched\n")
        if self._topics and self._diagnostics:
            wait_for(
                "the node has matched", lambda: self._publishers() >= len(self._topics) + beside
            )
        assert self.process.stdin is not None
        self.process.stdin.write(b"\n")
        self.process.stdin.flush()
        return self

    def _publishers(self) -> float:
        values = values_of(received(self.so_far(), "/diagnostics"), "gprodom: ROS 2")
        return sum(v for name, v in values.items() if name.endswith(": publishers"))

    def sent(self) -> Peer:
        """Once its plan is sent."""
        return self._await(b"sent\n")

    def end(self, patience_s: float = 300.0) -> list[Record]:
        """What it has sent and received, once it has ended by itself."""
        assert self.process.wait(patience_s) == 0
        return read_out(self.out)

    def so_far(self) -> list[Record]:
        return read_out(self.out)

    def stop(self) -> list[Record]:
        self.process.terminate()
        assert self.process.wait(PATIENCE_S) == 0
        return read_out(self.out)


def received(records: list[Record], topic: str) -> list[Any]:
    return [r.value() for r in records if r.raw and r.topic == topic]


def values_of(diagnostics: list[Any], name: str) -> dict[str, float]:
    """The last values of the status of that name."""
    found = [status for m in diagnostics for status in m.status if status.name == name]
    return {v.key: float(v.value) for v in found[-1].values} if found else {}
