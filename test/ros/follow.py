"""Plays a bag to four nodes and checks what they say, for Debian's own Python:

    follow.py IN.bag OUT CONFIG METRES_PER_TICK [SPEED]

Starts roscore and the launch file four times, for the wheel as nav_msgs/Odometry, as one joint and
as two sides of sensor_msgs/JointState, and as std_msgs/Int64 ticks; plays IN.bag on a simulated
clock at SPEED times real time (4), and writes each node's odometry_map to OUT/WHEEL.tum. Where this
machine was late, OUT/WHEEL.late says so: that node's poses then depend on what else ran. Fails
where tf, diagnostics or the services are not as told. Runs in a network namespace of its own, with
its loopback up.
"""

from __future__ import annotations

import math
import os
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import rosgraph
import rospy
from diagnostic_msgs.msg import DiagnosticArray
from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Log
from sensor_msgs.msg import Imu
from std_srvs.srv import Trigger
from tf2_msgs.msg import TFMessage

from bag import SIDES, WHEEL_JOINT, WHEEL_RADIUS_M

PATIENCE_S = 60.0
# A node says one of these where data or an answer came too late for its poses to be as in replay.
LATE = (
    "later than time.reorder_window",
    "not ready after",
    "not answered within",
    "joined with later input",
)
# A wheel tick has no stamp and counts when it comes in: if that many of a hundred come that much
# later (s of the clock), the poses are not those of replay. An IMU message has a stamp and shows
# how late this machine is.
TICK_LATE_S, TICKS_LATE_PCT = 0.1, 2.0
# No busy machine makes a node say this: its clock is not that of the bag.
WRONG_CLOCK = "stamp jumped ahead"
MAIN = "odometry"
NAMESPACES = {MAIN: "/", "joint": "/joint/", "joints": "/joints/", "ticks": "/ticks/"}


def wait_for(what: str, happened: Callable[[], bool]) -> None:
    """Until it `happened`."""
    deadline = time.monotonic() + PATIENCE_S
    while not happened():
        if time.monotonic() > deadline:
            raise SystemExit(f"in vain: {what}")
        time.sleep(0.05)


class Heard:
    """What the node in `namespace` ("/", "/joint/") publishes."""

    def __init__(self, namespace: str, transforms: bool) -> None:
        self.odometry: list[Odometry] = []
        self.odometry_map: list[Odometry] = []
        self.transforms: dict[tuple[str, str], Any] = {}
        self.levels: list[int] = []
        self._subscribers = [
            rospy.Subscriber(f"{namespace}{name}", Odometry, taken.append, queue_size=None)
            for name, taken in (("odometry", self.odometry), ("odometry_map", self.odometry_map))
        ]
        if transforms:
            self._subscribers += [
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


class Lateness:
    """Where this machine was too late."""

    def __init__(self) -> None:
        self._said: dict[str, str] = {}
        self.wrong_clocks: set[str] = set()
        self._imu_s: list[float] = []
        self._subscribers = [
            rospy.Subscriber("/rosout", Log, self._take_log, queue_size=None),
            rospy.Subscriber("/imu/data", Imu, self._take_imu, queue_size=None),
        ]

    def _take_log(self, m: Log) -> None:
        if WRONG_CLOCK in m.msg:
            self.wrong_clocks.add(m.name)
        if any(text in m.msg for text in LATE):
            self._said[m.name] = m.msg

    def _take_imu(self, m: Imu) -> None:
        self._imu_s.append((rospy.Time.now() - m.header.stamp).to_sec())

    def of(self, name: str) -> str:
        """Of the node for the wheel as `name`; empty where it was in time."""
        said = self._said.get(f"{NAMESPACES[name]}gprodom", "")
        late_pct = 100 * sum(s > TICK_LATE_S for s in self._imu_s) / max(1, len(self._imu_s))
        if not said and name == "ticks" and late_pct > TICKS_LATE_PCT:
            return f"{late_pct:.1f} % of the messages came over {TICK_LATE_S} s late"
        return said


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


def launch(name: str, config: str, metres_per_tick: str) -> subprocess.Popen[bytes]:
    """The node that takes the wheel as `name` says: /gprodom, or in a namespace of that name."""
    command = ["roslaunch", "gprodom_ros", "gprodom.launch", f"config:={config}", f"wheel:={name}"]
    command += [f"wheel_joint:={WHEEL_JOINT}", f"wheel_radius:={WHEEL_RADIUS_M}"]
    command += [f"{parameter}:={','.join(joints)}" for parameter, joints in SIDES.items()]
    command += [f"metres_per_tick:={metres_per_tick}", "use_sim_time:=true"]
    main_node = name == MAIN
    command += [f"publish_tf:={str(main_node).lower()}"]
    names = {} if main_node else {"ROS_NAMESPACE": name}
    return subprocess.Popen(command, stdout=subprocess.DEVNULL, env={**os.environ, **names})


def play(bag: str, speed: str) -> None:
    """The whole bag. The clock ticks often, since a node stamps wheel ticks by it."""
    command = ["rosbag", "play", "--quiet", "--clock", "--hz", "1000", "--rate", speed]
    command += ["--queue", "10000", "--wait-for-subscribers", bag]
    subprocess.run(command, check=True)


def settle(heard: dict[str, Heard]) -> None:
    """Waits until what is under way has arrived."""
    count = -1
    while count != (now := sum(len(each.odometry_map) for each in heard.values())):
        count = now
        time.sleep(1.0)


def check_services(saved: str) -> None:
    """save_map writes the ground, reset reaches the estimator, and both say so."""
    said: list[str] = []
    rospy.Subscriber("/rosout", Log, lambda m: said.append(m.msg))

    def ask(service: str, expected: str) -> None:
        answer = rospy.ServiceProxy(f"/gprodom/{service}", Trigger)()
        assert answer.success, answer.message
        wait_for(f"'{expected}', after ~{service}", lambda: any(expected in m for m in said))

    ask("save_map", f"{saved}: saved")
    assert os.path.getsize(saved) > 0
    ask("reset", "reset by command")


def main(bag: str, out: str, config: str, metres_per_tick: str, speed: str = "4") -> None:
    """The whole run."""
    os.environ.update(ROS_MASTER_URI="http://127.0.0.1:11311", ROS_IP="127.0.0.1")
    started = [subprocess.Popen(["roscore"], stdout=subprocess.DEVNULL)]
    try:
        wait_for("roscore", rosgraph.is_master_online)
        for name in NAMESPACES:
            own = config if name == MAIN else f"{config}.without_state"
            started.append(launch(name, own, metres_per_tick))
        wait_for("use_sim_time", lambda: rospy.has_param("/use_sim_time"))
        rospy.init_node("follow", disable_signals=True)
        heard = {name: Heard(space, name == MAIN) for name, space in NAMESPACES.items()}
        late = Lateness()
        for name, each in heard.items():
            wait_for(f"the node for {name}", each.connected)
        play(bag, speed)
        settle(heard)
        check(heard[MAIN])
        assert not late.wrong_clocks, f"{WRONG_CLOCK}, says {late.wrong_clocks}"
        for name, each in heard.items():
            write_tum(f"{out}/{name}.tum", each.odometry_map)
            Path(f"{out}/{name}.late").write_text(late.of(name))
            print(f"{name}: {len(each.odometry_map)} poses {late.of(name)}")
        check_services(f"{out}/state/saved.map")
        print(f"services answered, diagnostics {sorted(set(heard[MAIN].levels))}")
    finally:
        for process in reversed(started):
            process.terminate()
            process.wait()


if __name__ == "__main__":
    main(*sys.argv[1:])
