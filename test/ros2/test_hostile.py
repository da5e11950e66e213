"""Participants that mean no good, beside a robot's real ones."""

from __future__ import annotations

import math
import signal
import struct
from pathlib import Path
from typing import Any

import numpy as np

from kit import (
    COMMAND,
    DIAGNOSTICS,
    IMU,
    IS_SANITIZED,
    ODOMETRY,
    TRACE,
    Node,
    Peer,
    Record,
    imu,
    on_the_wire,
    plan_of,
    received,
    to_cdr,
    values_of,
    wait_for,
)
from test_node import OUTPUTS, RELIABLE, SPEED, check_poses, config

PACKETS = 100_000
KINDS = {"/imu/data": IMU, "/gpr": TRACE, "/wheel": ODOMETRY, "/gprodom/command": COMMAND}
BAD_VALUES = [math.nan, math.inf, -math.inf, 1e300, -1e18]


def malformed(cdr: bytes, rng: np.random.Generator) -> bytes:
    """Bytes that make no message of the type."""
    kind = rng.integers(0, 4)
    if kind == 0:  # cut short, at least by what could be filling
        return cdr[: rng.integers(1, len(cdr) - 8)]
    if kind == 1:  # a count, of the frame's text, that is a lie
        counts = [0, 2**31 - 1, 2**32 - 1, 2**30, 70_000]
        return cdr[:12] + struct.pack("<I", int(rng.choice(counts))) + cdr[16:]
    if kind == 2:
        return cdr + rng.bytes(int(rng.integers(4, 3000)))
    return bytes([0, int(rng.choice([2, 3, 6, 7, 8, 11]))]) + cdr[2:]


def hostile(plan: list[Record], rng: np.random.Generator, count: int) -> list[Record]:
    """Malformed packets between those of a plan: of sensors, whose bytes begin with a header."""
    good = {topic: next(r for r in plan if r.topic == topic).cdr for topic in list(KINDS)[:3]}
    end_ns = plan[-1].at_ns
    variants = [
        Record(0, topic, KINDS[topic], malformed(good[topic], rng), raw=True)
        for topic in rng.choice(list(good), 2000)
    ]
    return [
        Record(i * end_ns // count, v.topic, v.kind, v.cdr, raw=True)
        for i in range(count)
        for v in [variants[i % len(variants)]]
    ]


def counted(records: list[Record]) -> tuple[dict[str, float], dict[str, float]]:
    said = received(records, "/diagnostics")
    return values_of(said, "gprodom: odometry"), values_of(said, "gprodom: ROS 2")


def test_malformed_packets_are_refused_and_counted(drive: Path, tmp_path: Path) -> None:
    """100,000 of them, from a participant of their own: the poses are those of the drive alone."""
    plan = plan_of(drive / "in.lcmlog", SPEED)
    bad = hostile(plan, np.random.default_rng(3), PACKETS)
    room = ["-p", f"sensor_depth:={2 * PACKETS}"]  # none is overwritten before it is counted
    with Node(tmp_path, *config(drive), *RELIABLE, *room) as node:
        robot = Peer(tmp_path, "robot", plan, OUTPUTS, "--quiet-s", "15")
        foe = Peer(tmp_path, "foe", bad, {"/diagnostics": (DIAGNOSTICS, "r")}, "--quiet-s", "5")
        foe.matched()
        robot.matched(beside=3).sent()
        foe.sent()
        wait_for("all of them", lambda: came(foe.so_far()) == PACKETS)
        memory_mb = resident_mb(node.process.pid)
    records = robot.end()
    foe.end()
    check_poses(records, drive)
    assert sum(refused(counted(records)[1]).values()) == PACKETS
    # Each is refused once, for its own topic, and the estimator's status knows.
    known, _ = counted(records)
    for topic in ("imu/data", "gpr", "wheel"):
        told = sum(v for name, v in known.items() if name.startswith(f"{topic}: message "))
        assert told == sum(r.topic == f"/{topic}" for r in bad), known
    assert memory_mb < (2000 if IS_SANITIZED else 200)


def came(records: list[Record]) -> float:
    """Messages that the node has refused or knows that it has lost."""
    values = counted(records)[1]
    return sum(v for name, v in values.items() if name.endswith((": refused", ": lost")))


def refused(values: dict[str, float]) -> dict[str, float]:
    return {name: v for name, v in values.items() if name.endswith(": refused")}


def resident_mb(pid: int) -> float:
    for line in Path(f"/proc/{pid}/status").read_text().splitlines():
        if line.startswith("VmRSS:"):
            return int(line.split()[1]) * 1024e-6
    raise AssertionError("the node has ended")


def test_other_types_under_our_names_are_told(drive: Path, tmp_path: Path) -> None:
    """As std_msgs/String, whose bytes would never be read."""
    other = [
        Record(i * 1_000_000, topic, "std_msgs/msg/String", b"\0\1\0\0\2\0\0\0x\0", raw=True)
        for i in range(20)
        for topic in ("/imu/data", "/gpr", "/wheel", "/gprodom/command")
    ]
    plan = plan_of(drive / "in.lcmlog", SPEED)
    with Node(tmp_path, *config(drive), *RELIABLE) as node:
        foe = Peer(tmp_path, "foe", other, {}, "--quiet-s", "20").matched().sent()
        wait_for("a warning", lambda: "imu/data: publisher of another type" in node.said())
        robot = Peer(tmp_path, "robot", plan, OUTPUTS, "--quiet-s", "4").matched().sent()
        wait_for("the last", lambda: len(received(robot.so_far(), "/odometry")) > 5000)
    records = robot.end()
    foe.stop()
    check_poses(records, drive)
    _, values = counted(records)
    for topic in ("imu/data", "gpr", "wheel", "gprodom/command"):
        assert values[f"{topic}: publishers of another type"] == 1
    assert on_the_wire(IMU) in node.said()


def test_values_that_cannot_be_are_refused(drive: Path, tmp_path: Path) -> None:
    """Well-formed messages with values that are not finite or too large, or of another age."""
    plan = plan_of(drive / "in.lcmlog", SPEED)
    rng = np.random.default_rng(4)
    bad: list[Record] = []
    for r in plan[::20]:
        m: Any = r.value()
        value = float(rng.choice(BAD_VALUES))
        if r.kind == IMU:
            m.linear_acceleration.x = value
        elif r.kind == ODOMETRY:
            m.pose.pose.position.x = value if not math.isfinite(value) else math.nan
        else:
            m.sample_interval = value
        bad.append(Record(r.at_ns + 1, r.topic, r.kind, to_cdr(r.kind, m)))
    middle = plan[len(plan) // 2].at_ns
    for sec in (-(2**31), 0, 2**31 - 1):
        m = imu(0, (0, 0, 9.8), (0, 0, 0))
        m.header.stamp.sec = sec
        bad.append(Record(middle, "/imu/data", IMU, to_cdr(IMU, m)))
    with Node(tmp_path, *config(drive), *RELIABLE):
        robot = Peer(tmp_path, "robot", plan + bad, OUTPUTS, "--quiet-s", "4").matched().sent()
        wait_for("the last", lambda: len(received(robot.so_far(), "/odometry")) > 5000)
    records = robot.end()
    check_poses(records, drive)
    known, link = counted(records)
    assert sum(refused(link).values()) == 0, "well-formed"
    reasons = {
        name: v for name, v in known.items() if name.split(": ")[0] in ("imu/data", "gpr", "wheel")
    }
    assert sum(reasons.values()) >= len(bad), reasons


def test_a_subscriber_that_hangs_holds_up_nobody(drive: Path, tmp_path: Path) -> None:
    """It is stopped, not ended, with 5,354 poses and more to take: nobody else misses one."""
    plan = plan_of(drive / "in.lcmlog", SPEED)
    with Node(tmp_path, *config(drive), *RELIABLE):
        stuck = Peer(tmp_path, "stuck", [], {"/odometry": (ODOMETRY, "r")}, "--quiet-s", "60")
        stuck.matched().process.send_signal(signal.SIGSTOP)
        robot = Peer(tmp_path, "robot", plan, OUTPUTS, "--quiet-s", "4").matched().sent()
        wait_for("the last", lambda: len(received(robot.so_far(), "/odometry")) > 5000)
    stuck.process.kill()
    stuck.process.wait()
    check_poses(robot.end(), drive)
