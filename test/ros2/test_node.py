"""The node on Cyclone DDS and a program on Fast DDS: what goes in, and what comes out."""

from __future__ import annotations

import json
import math
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gprodom.lcm import logs
from kit import (
    CHECKOUT,
    COMMAND,
    DIAGNOSTICS,
    IS_SANITIZED,
    LOG,
    NO_PEER,
    ODOMETRY,
    PLACE,
    TF,
    Node,
    Peer,
    Record,
    header,
    level,
    make,
    plan_of,
    received,
    to_cdr,
    utime_of,
    values_of,
    vector,
    wait_for,
)

SPEED = 4.0  # times real time
# The node counts one of these where data or a result came too late for poses as in replay.
LATE = (
    "later than time.reorder_window",
    "not answered within",
    "not ready after",
    "joined with later input",
)
LATE_BOUND_M = 1.0 if IS_SANITIZED else 0.1  # of poses, where something was late
# DDS keeps the order of messages within a topic only. An IMU sample that overtakes a wheel message
# gives a pose without it; that is not late. The pose lacks what the wheel corrects of the IMU's
# prediction since the last message. The share of such poses, and what they are off at most.
OVERTAKEN_SHARE, OVERTAKEN_BOUND_M = 0.01, 0.005
OUTPUTS = {
    "/odometry": (ODOMETRY, "r"),
    "/odometry_map": (ODOMETRY, "r"),
    "/tf": (TF, "r"),
    "/tf_static": (TF, "t"),
    "/diagnostics": (DIAGNOSTICS, "r"),
    "/rosout": (LOG, "t"),
}
RELIABLE = ["-p", "sensors_reliable:=true"]
WHEELS = {
    "odometry": [],
    "twist": ["-p", "wheel_message:=twist"],
    "joints": ["-p", "wheel_message:=joint", "-p", "wheel_joint:=left", "-p", "wheel_radius:=0.1"],
}


def config(drive: Path) -> list[str]:
    return ["-c", str(drive / "config.yaml")]


def replayed(drive: Path, channel: str) -> dict[int, Any]:
    """Positions of the replay by time (us)."""
    odometry = logs.read(drive / "out.lcmlog", [channel])[channel]
    return dict(zip(odometry["utime"].tolist(), odometry["position"].tolist(), strict=True))


def position(m: Any) -> tuple[float, float, float]:
    p = m.pose.pose.position
    return p.x, p.y, p.z


def check_poses(records: list[Record], drive: Path, bound_m: float = 0.0) -> None:
    """All poses of the replay, once and in order, and the same; the default: to the last bit, but
    for those at which a wheel message was overtaken.

    Where data or a result of the radar, the window or the map was late, as on a busy machine, it
    took effect at another time than in replay, and the poses are only about the same. So may those
    be that came after the last status.
    """
    diagnostics = received(records, "/diagnostics")
    told = values_of(diagnostics, "gprodom: odometry")
    late = [name for name in told if any(text in name for text in LATE)]
    told_until = max(
        utime_of(m.header.stamp)
        for m in diagnostics
        if any(status.name == "gprodom: odometry" for status in m.status)
    )
    for topic, channel in (("/odometry", "ODOMETRY"), ("/odometry_map", "ODOMETRY_MAP")):
        expected = replayed(drive, channel)
        poses = received(records, topic)
        assert [utime_of(m.header.stamp) for m in poses] == list(expected)
        apart_m = {
            (t := utime_of(m.header.stamp)): math.dist(position(m), expected[t]) for m in poses
        }
        assert max(apart_m.values()) <= LATE_BOUND_M, late
        off_m = {t: m for t, m in apart_m.items() if m > bound_m and t <= told_until}
        few = len(off_m) <= OVERTAKEN_SHARE * len(poses)
        is_overtaken = few and max(off_m.values(), default=0.0) <= OVERTAKEN_BOUND_M
        assert late or is_overtaken, (topic, off_m, told_until, told)


def play(folder: Path, drive: Path, wheel: str, *options: str) -> list[Record]:
    """What the peer has sent and received of a whole drive, after which the node ends."""
    with Node(folder, *config(drive), *RELIABLE, *WHEELS[wheel]):
        plan = plan_of(drive / "in.lcmlog", SPEED, wheel)
        peer = Peer(folder, "robot", plan, OUTPUTS, "--quiet-s", "4", *options).matched().sent()
        time.sleep(1.0)  # for what is on its way; what the node still has it publishes as it ends
    return peer.end()


@pytest.mark.parametrize("wheel", WHEELS)
def test_poses_are_those_of_replay(drive: Path, tmp_path: Path, wheel: str) -> None:
    """To the last bit; angles and speeds give the distance back but for its rounding."""
    records = play(tmp_path, drive, wheel)
    check_poses(records, drive, 0.0 if wheel == "odometry" else 1e-6)


def test_frames_fit_together(drive: Path, tmp_path: Path) -> None:
    """Types with their TypeObject, too."""
    records = play(tmp_path, drive, "odometry", "--type-objects")
    odometry, in_map = received(records, "/odometry"), received(records, "/odometry_map")
    assert (odometry[-1].header.frame_id, odometry[-1].child_frame_id) == ("odom", "base_link")
    assert in_map[-1].header.frame_id == "map"
    assert odometry[-1].pose.covariance[0] > 0
    transforms = received(records, "/tf")
    assert len(transforms) == len(odometry) == len(in_map)
    up, body = transforms[-1].transforms
    assert (up.header.frame_id, up.child_frame_id) == ("map", "odom")
    assert (body.header.frame_id, body.child_frame_id) == ("odom", "base_link")
    assert body.header.stamp == odometry[-1].header.stamp
    yaw = 2 * math.atan2(up.transform.rotation.z, up.transform.rotation.w)
    p, t = odometry[-1].pose.pose.position, up.transform.translation
    x = t.x + math.cos(yaw) * p.x - math.sin(yaw) * p.y
    y = t.y + math.sin(yaw) * p.x + math.cos(yaw) * p.y
    assert math.dist((x, y), position(in_map[-1])[:2]) < 0.02
    [antenna] = received(records, "/tf_static")
    [mounted] = antenna.transforms
    assert (mounted.header.frame_id, mounted.child_frame_id) == ("base_link", "gpr_antenna")
    offset = mounted.transform.translation
    assert (offset.x, offset.y, offset.z) == (0.1, 0.2, -0.3)
    said = received(records, "/diagnostics")
    levels = {s.level for m in said for s in m.status if s.name == "gprodom: odometry"}
    assert 0 in levels, "never ok"
    counted = values_of(said, "gprodom: ROS 2")
    assert counted["imu/data: refused"] == counted["imu/data: lost"] == 0
    assert counted["imu/data: publishers"] == 1


def test_best_effort_counts_what_it_loses(drive: Path, tmp_path: Path) -> None:
    """The node is held up for so long that the kernel throws away what comes: messages that have
    come and those that are known to be lost are all that were sent."""
    with Node(tmp_path, *config(drive)) as node:
        plan = plan_of(drive / "in.lcmlog", SPEED)
        peer = Peer(tmp_path, "robot", plan, OUTPUTS, "--quiet-s", "4").matched()
        time.sleep(0.5)
        node.process.send_signal(signal.SIGSTOP)
        time.sleep(2.0)
        node.process.send_signal(signal.SIGCONT)
        peer.sent()
        time.sleep(2.5)
    records = peer.end()
    counted = values_of(received(records, "/diagnostics"), "gprodom: ROS 2")
    for topic, wire in (("imu/data", "/imu/data"), ("gpr", "/gpr"), ("wheel", "/wheel")):
        sent = sum(r.topic == wire for r in plan)
        assert counted[f"{topic}: received"] + counted[f"{topic}: lost"] == sent
    assert counted["imu/data: lost"] > 0


def test_late_subscribers_get_the_static_frames(drive: Path, tmp_path: Path) -> None:
    with Node(tmp_path, *config(drive)):
        time.sleep(1.0)
        for name in ("first", "second"):
            peer = Peer(tmp_path, name, [], {"/tf_static": (TF, "t")}, "--quiet-s", "1")
            assert len(received(peer.matched().end(), "/tf_static")) == 1


def test_each_antenna_has_a_frame(drive: Path, tmp_path: Path) -> None:
    """The first of gpr.antennas as the only one has; further ones by their id."""
    more = tmp_path / "pair.yaml"
    more.write_text("gpr: {antennas: {2: [0.3, 0, 0], 5: [-0.3, 0.1, 0.05]}}\n")
    with Node(tmp_path, *config(drive), "-c", str(more)):
        peer = Peer(tmp_path, "frames", [], {"/tf_static": (TF, "t")}, "--quiet-s", "1")
        [antennas] = received(peer.matched().end(), "/tf_static")
    assert {
        t.child_frame_id: (t.transform.translation.x, t.transform.translation.y)
        for t in antennas.transforms
    } == {"gpr_antenna": (0.3, 0.0), "gpr_antenna_5": (-0.3, 0.1)}
    assert {t.header.frame_id for t in antennas.transforms} == {"base_link"}


def test_either_side_can_start_again(drive: Path, tmp_path: Path) -> None:
    """The publisher ends in the middle and another goes on; then the node is killed."""
    plan = plan_of(drive / "in.lcmlog", SPEED)
    middle_ns = plan[len(plan) // 2].at_ns
    first = [r for r in plan if r.at_ns < middle_ns]
    second = [replace(r, at_ns=r.at_ns - middle_ns) for r in plan if r.at_ns >= middle_ns]
    node = Node(tmp_path, *config(drive), *RELIABLE)
    before = Peer(tmp_path, "before", first, OUTPUTS, "--quiet-s", "0").matched().end()
    after = Peer(tmp_path, "after", second, OUTPUTS, "--quiet-s", "3").matched().sent()
    time.sleep(1.0)
    node.end()
    stamps = [
        utime_of(m.header.stamp)
        for records in (before, after.end())
        for m in received(records, "/odometry")
    ]
    assert stamps == sorted(set(stamps)), "a pose twice, or back in time"
    expected = list(replayed(drive, "ODOMETRY"))
    assert stamps[-1] == expected[-1]
    # Those between the end of one subscriber and the start of the next went to nobody.
    assert len(stamps) > 0.8 * len(expected)

    node = Node(tmp_path, *config(drive), *RELIABLE)
    peer = Peer(tmp_path, "stays", [], OUTPUTS, "--quiet-s", "60").matched()
    wait_for("frames", lambda: len(received(peer.so_far(), "/tf_static")) == 1)
    node.process.kill()
    node.process.wait()
    with Node(tmp_path, *config(drive), *RELIABLE):
        wait_for("frames again", lambda: len(received(peer.so_far(), "/tf_static")) == 2)
        again = Peer(tmp_path, "again", plan, {"/diagnostics": (DIAGNOSTICS, "r")})
        again.matched().sent()
    wait_for("all poses", lambda: len(received(peer.so_far(), "/odometry")) == len(expected))
    peer.stop()
    again.end()


def place_told(utime: int, frame: str, sigma_m: float) -> bytes:
    """As RViz's 2D Pose Estimate."""
    covariance = np.zeros(36)
    covariance[[0, 7]] = sigma_m**2
    pose = make("geometry_msgs/msg/Pose", position=vector(1, 2, kind="Point"), orientation=level())
    about = make("geometry_msgs/msg/PoseWithCovariance", pose=pose, covariance=covariance)
    return to_cdr(PLACE, make(PLACE, header=header(utime, frame), pose=about))


def test_commands_come_as_a_topic(drive: Path, tmp_path: Path) -> None:
    """As `ros2 topic pub --once` and RViz send them."""
    (tmp_path / "state").mkdir()
    state = ["--set", f"state.directory={tmp_path / 'state'}"]
    plan = plan_of(drive / "in.lcmlog", SPEED)
    last = plan[-1]
    commands = [("save_map", "yard"), ("reset", ""), ("dance", ""), ("load_map", "yard")]
    for i, (name, argument) in enumerate([*commands, ("load_map", "garden")], 1):
        cdr = to_cdr(COMMAND, make(COMMAND, name=name, argument=argument))
        plan.append(Record(last.at_ns + i, "/gprodom/command", COMMAND, cdr))
    utime = utime_of(last.value().header.stamp)
    for i, (frame, sigma_m) in enumerate([("odom", 0.5), ("map", 10.0)], 10):
        cdr = place_told(utime, frame, sigma_m)
        plan.append(Record(last.at_ns + i, "/initialpose", PLACE, cdr))
    with Node(tmp_path, *config(drive), *RELIABLE, *state) as node:
        peer = Peer(tmp_path, "robot", plan, OUTPUTS, "--quiet-s", "5").matched().sent()
        wait_for("a map", lambda: "yard.map: saved" in node.said())
        wait_for("a reset", lambda: "reset by command" in node.said())
        wait_for("the map again", lambda: "map yard loaded" in node.said())
    assert (tmp_path / "state" / "yard.map").stat().st_size > 0
    told = [m.msg for m in received(peer.end(), "/rosout")]
    for what in (
        "yard.map: saved",
        "reset by command",
        "unknown command",
        "map yard loaded",
        "garden.map: no such file",
        "not in the frame of the map",
        "expected a sigma above 0",
    ):
        assert any(what in text for text in told), (what, told)


def test_topics_take_the_namespace(drive: Path, tmp_path: Path) -> None:
    plan = plan_of(drive / "in.lcmlog", SPEED, until_s=8.0)
    for r in plan:
        r.topic = f"/husky{r.topic}"
    topics = {
        "/husky/odometry": (ODOMETRY, "r"),
        "/tf": (TF, "r"),
        "/diagnostics": (DIAGNOSTICS, "r"),
    }
    settings = ["-p", "namespace:=/husky", "-p", "domain:=7", "-p", "base_frame:=husky/base"]
    with Node(tmp_path, *config(drive), *RELIABLE, *settings):
        peer = Peer(tmp_path, "robot", plan, topics, "--domain", "7").matched().sent()
        time.sleep(1.0)
    records = peer.end()
    odometry = received(records, "/husky/odometry")
    assert odometry[-1].child_frame_id == "husky/base"
    assert len(received(records, "/tf")) == len(odometry)


def sent_packets(interface: str) -> int:
    command = ["ip", "-s", "-j", "link", "show", interface]
    said = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    return int(json.loads(said)[0]["stats64"]["tx"]["packets"])


def test_nothing_leaves_the_machine_unless_told(drive: Path, tmp_path: Path) -> None:
    """A second interface, which multicast would take: silent by default, and not when named."""

    def ip(*arguments: str) -> None:
        subprocess.run(["ip", *arguments], check=True)

    made = subprocess.run(["ip", "link", "add", "out0", "type", "veth", "peer", "name", "out1"])
    if made.returncode != 0:
        pytest.skip("this kernel makes no second interface")
    try:
        for name in ("out0", "out1"):
            Path(f"/proc/sys/net/ipv6/conf/{name}/disable_ipv6").write_text("1")
            ip("link", "set", name, "up")
        ip("addr", "add", "10.77.0.1/24", "dev", "out0")
        ip("route", "add", "default", "dev", "out0")
        for settings, silent in (([], True), (["-p", "interface:=out0"], False)):
            before = sent_packets("out0")
            with Node(tmp_path, *config(drive), *settings):
                time.sleep(3.0)
            assert (sent_packets("out0") == before) == silent, settings
    finally:
        ip("link", "del", "out0")


def test_ticks_are_of_the_simulated_time(drive: Path, tmp_path: Path) -> None:
    """They have no stamp: those of /clock are taken, so that poses go on from them."""
    clock, ticks = "rosgraph_msgs/msg/Clock", "std_msgs/msg/Int64"
    plan = []
    for r in plan_of(drive / "in.lcmlog", SPEED):
        if r.topic == "/wheel":
            m = r.value()
            time_ = make(clock, clock=m.header.stamp)
            plan.append(Record(r.at_ns, "/clock", clock, to_cdr(clock, time_)))
            count = make(ticks, data=round(m.pose.pose.position.x / 1e-4))
            plan.append(Record(r.at_ns + 5_000_000, "/wheel", ticks, to_cdr(ticks, count)))
        else:
            plan.append(r)
    settings = ["-p", "wheel_message:=ticks", "-p", "metres_per_tick:=0.0001"]
    settings += ["-p", "use_sim_time:=true"]
    with Node(tmp_path, *config(drive), *RELIABLE, *settings):
        peer = Peer(tmp_path, "robot", plan, OUTPUTS, "--quiet-s", "4").matched().sent()
        time.sleep(1.0)
    poses = {utime_of(m.header.stamp): position(m) for m in received(peer.end(), "/odometry")}
    expected = replayed(drive, "ODOMETRY")
    errors = [math.dist(poses[utime], p) for utime, p in expected.items()]
    assert float(np.sqrt(np.mean(np.square(errors)))) < 0.1


def test_the_bench_of_latencies_runs(drive: Path) -> None:
    """The short form of bench/ros2_live.py."""
    if NO_PEER.is_file():
        pytest.skip(NO_PEER.read_text())
    bench = [sys.executable, str(CHECKOUT / "bench" / "ros2_live.py"), str(drive / "in.lcmlog")]
    said = subprocess.run([*bench, "--speed", "4", "--json"], capture_output=True, text=True)
    assert said.returncode == 0, said.stderr
    figures = json.loads(said.stdout)
    assert figures["poses"] == len(replayed(drive, "ODOMETRY"))
    assert 0 < figures["latency_p50_ms"] <= figures["latency_p99_ms"]
