"""An LCM log as a ROS bag, for Debian's own Python: bag.py IN.lcmlog OUT.bag

/imu/data (sensor_msgs/Imu), /gpr (gprodom_ros/GprTrace), and the wheel in the three ways that the
node takes it: /wheel_odometry (nav_msgs/Odometry, straight ahead), /joint_states
(sensor_msgs/JointState) and /wheel_ticks (std_msgs/Int64). Stamped with the log's data time.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import Any

import rosbag
import rospy
from gprodom_ros.msg import GprTrace
from nav_msgs.msg import Odometry
from sensor_msgs.msg import Imu, JointState
from std_msgs.msg import Int64

from gprodom.lcm import EventLog
from gprodom.lcm.messages import message

WHEEL_RADIUS_M = 0.1
WHEEL_JOINT = "front_left"
SIDES = {"left_joints": (WHEEL_JOINT, "rear_left"), "right_joints": ("front_right", "rear_right")}


def imu(m: Any) -> Imu:
    """`m`: imu_t."""
    out = Imu()
    a, w = out.linear_acceleration, out.angular_velocity
    a.x, a.y, a.z = m.linear_acceleration
    w.x, w.y, w.z = m.angular_velocity
    out.orientation_covariance[0] = -1  # none
    return out


def wheel(m: Any) -> Odometry:
    """`m`: wheel_t."""
    out = Odometry()
    out.pose.pose.position.x = m.ticks * m.metres_per_tick
    out.pose.pose.orientation.w = 1.0
    return out


def joints(m: Any) -> JointState:
    """`m`: wheel_t. Among others, as a robot has them."""
    angle = m.ticks * m.metres_per_tick / WHEEL_RADIUS_M
    wheels = [name for side in SIDES.values() for name in side]
    return JointState(name=["arm", *wheels], position=[1.0, *(len(wheels) * [angle])])


def ticks(m: Any) -> Int64:
    """`m`: wheel_t."""
    return Int64(data=m.ticks)


def trace(m: Any) -> GprTrace:
    """`m`: gpr_trace_t."""
    return GprTrace(
        trace=m.seq,
        antenna_id=m.antenna_id,
        sample_interval=m.sample_interval,
        time_zero=m.time_zero,
        volts_per_count=m.volts_per_count,
        samples=m.samples,
    )


STREAMS: dict[str, tuple[str, dict[str, Callable[[Any], Any]]]] = {
    "IMU": ("imu_t", {"/imu/data": imu}),
    "WHEEL": (
        "wheel_t",
        {"/wheel_odometry": wheel, "/joint_states": joints, "/wheel_ticks": ticks},
    ),
    "GPR_TRACE": ("gpr_trace_t", {"/gpr": trace}),
}


def main(log: str, bag: str) -> None:
    """Converts, and prints metres per tick of the wheel."""
    metres_per_tick = 0.0
    with rosbag.Bag(bag, "w") as out:
        for event in EventLog(log):
            if event.channel in STREAMS:
                name, topics = STREAMS[event.channel]
                m = message(name).decode(event.data)
                metres_per_tick = getattr(m, "metres_per_tick", metres_per_tick)
                stamp = rospy.Time(m.utime // 1_000_000, m.utime % 1_000_000 * 1000)
                for topic, convert in topics.items():
                    converted = convert(m)
                    if topic != "/wheel_ticks":  # which alone has no stamp of its own
                        converted.header.stamp = stamp
                    out.write(topic, converted, stamp)
    print(metres_per_tick)


if __name__ == "__main__":
    main(*sys.argv[1:])
