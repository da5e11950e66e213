"""Plays a bag to gprodom_node and checks what it says, for Debian's own Python:

    follow.py IN.bag OUT.tum CONFIG [SPEED]

Starts roscore and the launch file, plays IN.bag on a simulated clock at SPEED times real time (4),
and writes odometry_map as a TUM file. Fails where tf, diagnostics or the service are not as told.
Runs in a network namespace of its own, with its loopback up.
"""

from __future__ import annotations

import math
import os
import subprocess
import sys
import time
from collections.abc import Callable
from typing import Any

import rosgraph
import rospy
from diagnostic_msgs.msg import DiagnosticArray
from nav_msgs.msg import Odometry
from std_srvs.srv import Trigger
from tf2_msgs.msg import TFMessage

PATIENCE_S = 60.0
FED = ("/imu/data", "/wheel_odometry", "/gpr")


def wait_for(what: str, happened: Callable[[], bool]) -> None:
    """Until it `happened`."""
    deadline = time.monotonic() + PATIENCE_S
    while not happened():
        if time.monotonic() > deadline:
            raise SystemExit(f"in vain: {what}")
        time.sleep(0.05)


class Heard:
    """What the node publishes."""

    def __init__(self) -> None:
        self.odometry: list[Odometry] = []
        self.odometry_map: list[Odometry] = []
        self.transforms: dict[tuple[str, str], Any] = {}
        self.levels: list[int] = []
        self._subscribers = [
            rospy.Subscriber("/odometry", Odometry, self.odometry.append, queue_size=None),
            rospy.Subscriber("/odometry_map", Odometry, self.odometry_map.append, queue_size=None),
            rospy.Subscriber("/tf", TFMessage, self._take_transforms, queue_size=None),
            rospy.Subscriber("/diagnostics", DiagnosticArray, self._take_diagnostics),
        ]

    def connected(self) -> bool:
        """Whether the node is linked to every subscriber here."""
        return all(s.get_num_connections() > 0 for s in self._subscribers)

    def _take_transforms(self, m: TFMessage) -> None:
        for t in m.transforms:
            self.transforms[t.header.frame_id, t.child_frame_id] = t

    def _take_diagnostics(self, m: DiagnosticArray) -> None:
        self.levels += [s.level for s in m.status if s.name == "gprodom: odometry"]


def check(heard: Heard) -> None:
    """What was heard fits together."""
    assert len(heard.odometry) == len(heard.odometry_map)
    last = heard.odometry[-1]
    assert (last.header.frame_id, last.child_frame_id) == ("odom", "base_link")
    assert heard.odometry_map[-1].header.frame_id == "map"
    assert last.pose.covariance[0] > 0
    body = heard.transforms["odom", "base_link"]
    assert body.header.stamp == last.header.stamp
    assert body.transform.translation.x == last.pose.pose.position.x
    # map -> odom -> base_link is the pose in map.
    up = heard.transforms["map", "odom"].transform
    yaw = 2 * math.atan2(up.rotation.z, up.rotation.w)
    p = last.pose.pose.position
    in_map = heard.odometry_map[-1].pose.pose.position
    x = up.translation.x + math.cos(yaw) * p.x - math.sin(yaw) * p.y
    y = up.translation.y + math.sin(yaw) * p.x + math.cos(yaw) * p.y
    assert math.hypot(x - in_map.x, y - in_map.y) < 0.02, "map -> odom"
    assert 0 in heard.levels, "no diagnostics with level OK"


def write_tum(path: str, poses: list[Odometry]) -> None:
    """Stamps in full, as the scorer matches them to replay's."""
    with open(path, "w") as file:
        for m in poses:
            p, q = m.pose.pose.position, m.pose.pose.orientation
            stamp = f"{m.header.stamp.secs}.{m.header.stamp.nsecs:09d}"
            file.write(f"{stamp} {p.x} {p.y} {p.z} {q.x} {q.y} {q.z} {q.w}\n")


def main(bag: str, tum: str, config: str, speed: str = "4") -> None:
    """The whole run."""
    os.environ.update(ROS_MASTER_URI="http://127.0.0.1:11311", ROS_IP="127.0.0.1")
    started = [subprocess.Popen(["roscore"], stdout=subprocess.DEVNULL)]
    try:
        wait_for("roscore", rosgraph.is_master_online)
        launch = ["roslaunch", "gprodom_ros", "gprodom.launch"]
        launch += [f"config:={config}", "use_sim_time:=true"]
        started.append(subprocess.Popen(launch, stdout=subprocess.DEVNULL))
        wait_for("use_sim_time", lambda: rospy.has_param("/use_sim_time"))
        rospy.init_node("follow", disable_signals=True)
        heard = Heard()
        wait_for("the node", heard.connected)
        play = [
            "rosbag",
            "play",
            "--quiet",
            "--clock",
            "--rate",
            speed,
            "--queue",
            "10000",
        ]
        play += ["--wait-for-subscribers", bag, "--topics", *FED]
        subprocess.run(play, check=True)
        count = -1
        while count != len(heard.odometry_map):  # what is under way arrives
            count = len(heard.odometry_map)
            time.sleep(1.0)
        check(heard)
        write_tum(tum, heard.odometry_map)
        assert rospy.ServiceProxy("/gprodom/reset", Trigger)().success
        print(f"{count} poses, diagnostics {sorted(set(heard.levels))}")
    finally:
        for process in reversed(started):
            process.terminate()
            process.wait()


if __name__ == "__main__":
    main(*sys.argv[1:])
