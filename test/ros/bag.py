"""An LCM log as a ROS bag, for Debian's own Python: bag.py IN.lcmlog OUT.bag

/imu/data (sensor_msgs/Imu), /wheel_odometry (nav_msgs/Odometry, straight ahead) and /gpr
(gprodom_ros/GprTrace), stamped with the log's data time.
"""

from __future__ import annotations

import sys
from typing import Any

import rosbag
import rospy
from gprodom_ros.msg import GprTrace
from nav_msgs.msg import Odometry
from sensor_msgs.msg import Imu

from gprodom.lcm import EventLog
from gprodom.messages import message


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


STREAMS = {
    "IMU": ("imu_t", "/imu/data", imu),
    "WHEEL": ("wheel_t", "/wheel_odometry", wheel),
    "GPR_TRACE": ("gpr_trace_t", "/gpr", trace),
}


def main(log: str, bag: str) -> None:
    """Converts."""
    with rosbag.Bag(bag, "w") as out:
        for event in EventLog(log):
            if event.channel in STREAMS:
                name, topic, convert = STREAMS[event.channel]
                m = message(name).decode(event.data)
                stamp = rospy.Time(m.utime // 1_000_000, m.utime % 1_000_000 * 1000)
                converted = convert(m)
                converted.header.stamp = stamp
                out.write(topic, converted, stamp)


if __name__ == "__main__":
    main(*sys.argv[1:])
