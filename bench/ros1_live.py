#!/usr/bin/python3
"""The ROS 1 node, live: latency by the measure of ros2_live.py.

The sensors of a log are published as they were recorded to gprodom_node beside a roscore, in a
network namespace of its own, and its poses are taken. Printed as JSON are the time from an IMU
message's being published to its pose's being taken, by rospy, whose own share is in it, and what
the node itself counts from the arrival of an IMU message to its pose being out. For Debian's own
Python, which has rospy; it needs what scripts/check-ros builds.

    bench/ros1_live.py IN.lcmlog [CONFIG.yaml]
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
DISTRIBUTION = "lib/python3/dist-packages"
PATHS = ("scripts", "build/python", f"build-ros/devel/{DISTRIBUTION}", "test/ros")
PERCENTILES = (50, 99, 100)
STREAMS = {"IMU": "/imu/data", "WHEEL": "/wheel_odometry", "GPR_TRACE": "/gpr"}


def start_again_inside() -> None:
    """In a network namespace, with ROS' surroundings."""
    own = {
        "PYTHONPATH": ":".join(str(ROOT / path) for path in PATHS),
        "ROS_PACKAGE_PATH": f"{ROOT / 'ros'}:/usr/share",
        "CMAKE_PREFIX_PATH": str(ROOT / "build-ros" / "devel"),
        "PATH": "/usr/sbin:/usr/bin:/sbin:/bin",
        "ROS_MASTER_URI": "http://127.0.0.1:11311",
        "ROS_IP": "127.0.0.1",
        "GPRODOM_INSIDE": "1",
    }
    rights = "-n" if os.geteuid() == 0 else "-rn"
    inside = ["sh", "-c", 'ip link set lo up && exec "$@"', "sh", "/usr/bin/python3", *sys.argv]
    os.execvpe("unshare", ["unshare", rights, *inside], {**os.environ, **own})


def plan_of(log: str) -> list[tuple[float, str, Any]]:
    """Seconds after the begin, topic and message."""
    import bag
    import rospy

    from gprodom.lcm import EventLog
    from gprodom.lcm.messages import message

    plan: list[tuple[float, str, Any]] = []
    first = 0
    for event in EventLog(log):
        if event.channel not in STREAMS:
            continue
        name, topics = bag.STREAMS[event.channel]
        m = message(name).decode(event.data)
        first = first or m.utime
        topic = STREAMS[event.channel]
        converted = topics[topic](m)
        converted.header.stamp = rospy.Time(m.utime // 1_000_000, m.utime % 1_000_000 * 1000)
        plan.append(((m.utime - first) * 1e-6, topic, converted))
    return plan


def measure(log: str, config: str) -> dict[str, float]:
    """The figures by name."""
    import numpy as np
    import rosgraph
    import rospy
    from diagnostic_msgs.msg import DiagnosticArray
    from follow import MAIN, launch, wait_for
    from nav_msgs.msg import Odometry

    plan = plan_of(log)
    sent: dict[int, float] = {}
    taken: dict[int, float] = {}
    own: dict[str, float] = {}

    def take(m: Odometry) -> None:
        taken[m.header.stamp.to_nsec()] = time.monotonic()

    def hear(m: DiagnosticArray) -> None:
        for status in m.status:
            if status.name == "gprodom: odometry":
                own.update({v.key: float(v.value) for v in status.values})

    started = [subprocess.Popen(["roscore"], stdout=subprocess.DEVNULL)]
    try:
        wait_for("roscore", rosgraph.is_master_online)
        started.append(launch(MAIN, config, "0"))
        wait_for("use_sim_time", lambda: rospy.has_param("/use_sim_time"))
        rospy.set_param("/use_sim_time", False)
        rospy.init_node("ros1_live", disable_signals=True)
        poses = rospy.Subscriber("/odometry", Odometry, take, queue_size=None, tcp_nodelay=True)
        rospy.Subscriber("/diagnostics", DiagnosticArray, hear)
        kinds = {topic: type(m) for _, topic, m in plan}
        links = {each: rospy.Publisher(each, kinds[each], queue_size=1000) for each in kinds}
        wait_for("the node", lambda: poses.get_num_connections() > 0)
        wait_for("links", lambda: all(p.get_num_connections() for p in links.values()))
        begun = time.monotonic()
        for second, topic, m in plan:
            time.sleep(max(0.0, begun + second - time.monotonic()))
            if topic == STREAMS["IMU"]:
                sent[m.header.stamp.to_nsec()] = time.monotonic()
            links[topic].publish(m)
        time.sleep(2.0)
    finally:
        for process in reversed(started):
            process.terminate()
            process.wait()
    late = np.array([1e3 * (taken[stamp] - sent[stamp]) for stamp in taken])
    return {
        "seconds": round(plan[-1][0], 1),
        "poses": len(taken),
        "poses_missing": sum(stamp >= min(taken) and stamp not in taken for stamp in sent),
        **{f"latency_p{p}_ms": round(float(np.percentile(late, p)), 3) for p in PERCENTILES},
        **{name: value for name, value in own.items() if name.startswith("latency.imu")},
    }


def main() -> None:
    """Runs the command line."""
    if len(sys.argv) not in (2, 3) or sys.argv[1] in ("-h", "--help"):
        sys.exit(__doc__)
    if "GPRODOM_INSIDE" not in os.environ:
        start_again_inside()
    config = sys.argv[2] if len(sys.argv) > 2 else str(ROOT / "config" / "gprodom.yaml")
    print(json.dumps(measure(sys.argv[1], config), indent=2))


if __name__ == "__main__":
    main()
