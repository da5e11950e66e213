"""What a viewer's panels show of a drive beside its poses, as ROS messages: the ways to compare
with, revisits, speeds, the ellipse of the position, standstill and slip.

What is true of the whole drive (ways, revisits) is stamped with its begin, so that a viewer shows
it from there on.
"""

from collections.abc import Iterator

import numpy as np

from gprodom.arrays import Floats, Ints
from gprodom.drive.log import Drive
from gprodom.export.messages import BODY, MAP, Entry, Messages
from gprodom.lcm.constants import flag
from gprodom.plot.log import radar_speed, wheel_speed
from gprodom.plot.revisits import find_revisits
from gprodom.trajectory import Trajectory, interpolate, thin

PERIOD_US = 100_000  # of ellipses and speeds
FLAGS = {"/gprodom/standing": "STANDING", "/gprodom/slipping": "SLIPPING"}
REVISIT_RGBA = (0.8, 0.475, 0.655, 0.7)
REVISIT_WIDTH_M = 0.02


def panels(make: Messages, drive: Drive) -> Iterator[Entry]:
    """All of it that the drive has."""
    ways = {
        "/gprodom/path_odom": drive.odom_in_map,
        "/gprodom/path_wheel_gyro": drive.dead_reckoning,
        "/gprodom/truth": drive.aligned_truth,
    }
    for topic, way in ways.items():
        if way is not None:
            yield from make.path(thin(way, PERIOD_US), MAP, topic)
    yield from _ellipses(make, drive.path)
    yield from _speeds(make, drive)
    yield from _flags(make, drive)
    if "displacement" in drive.log:
        yield from _revisits(make, drive)


def _ellipses(make: Messages, path: Trajectory) -> Iterator[Entry]:
    kind = "geometry_msgs/msg/PoseWithCovarianceStamped"
    path = thin(path, PERIOD_US)
    assert path.orientation is not None and path.covariance is not None
    for i, utime in enumerate(path.time.tolist()):
        pose = make.make(
            "geometry_msgs/msg/PoseWithCovariance",
            pose=make.pose(path.position[i], path.orientation[i]),
            covariance=np.array(path.covariance[i].ravel(), np.float64),
        )
        message = make.make(kind, header=make.header(utime, MAP), pose=pose)
        yield utime, "/gprodom/pose", kind, message


def _speeds(make: Messages, drive: Drive) -> Iterator[Entry]:
    measured = wheel_speed(drive.sensors)
    if measured is not None:
        kept = np.flatnonzero(np.diff(measured[0] // PERIOD_US))
        yield from _twists(make, "/gprodom/speed/wheel", measured[0][kept], measured[1][kept])
    if "displacement" in drive.log:
        yield from _twists(make, "/gprodom/speed/radar", *radar_speed(drive.log["displacement"]))


def _twists(make: Messages, topic: str, times: Ints, speeds: Floats) -> Iterator[Entry]:
    kind, none = "geometry_msgs/msg/TwistStamped", make.point("Vector3", (0, 0, 0))
    for utime, speed in zip(times.tolist(), speeds.tolist(), strict=True):
        linear = make.point("Vector3", (speed, 0, 0))
        twist = make.make("geometry_msgs/msg/Twist", linear=linear, angular=none)
        yield utime, topic, kind, make.make(kind, header=make.header(utime, BODY), twist=twist)


def _flags(make: Messages, drive: Drive) -> Iterator[Entry]:
    """Where they change, and once at the begin."""
    odometry = drive.log["odometry"]
    for topic, name in FLAGS.items():
        on = (odometry["flags"] & flag(name)) != 0
        for row in np.concatenate([[0], np.flatnonzero(np.diff(on)) + 1]):
            message = make.make("std_msgs/msg/Bool", data=bool(on[row]))
            yield int(odometry["utime"][row]), topic, "std_msgs/msg/Bool", message


def _revisits(make: Messages, drive: Drive) -> Iterator[Entry]:
    """Lines from where ground was first seen to where it was known again, as one marker."""
    path = drive.path
    found = find_revisits(drive.log).within(path)
    if not len(found.end):
        return
    ends = [interpolate(path, each).position for each in (found.start, found.end)]
    points = [make.point("Point", xyz) for pair in zip(*ends, strict=True) for xyz in pair]
    kind, utime = "visualization_msgs/msg/Marker", int(path.time[0])
    duration = make.make("builtin_interfaces/msg/Duration", sec=0, nanosec=0)
    colour = dict(zip("rgba", REVISIT_RGBA, strict=True))
    fields = {
        "header": make.header(utime, MAP), "ns": "revisits", "id": 0, "type": 5, "action": 0,
        "pose": make.pose((0, 0, 0), (1, 0, 0, 0)), "lifetime": duration, "frame_locked": False,
        "scale": make.point("Vector3", (REVISIT_WIDTH_M, 0, 0)), "points": points,
        "color": make.make("std_msgs/msg/ColorRGBA", **colour), "colors": [], "text": "",
        "mesh_resource": "", "mesh_use_embedded_materials": False,
    }  # fmt: skip
    if "texture" in make.names(kind):  # of ROS 2
        nothing = np.zeros(0, np.uint8)
        texture = {"header": make.header(utime, MAP), "format": "", "data": nothing}
        fields |= {"texture_resource": "", "uv_coordinates": []}
        fields["texture"] = make.make("sensor_msgs/msg/CompressedImage", **texture)
        fields["mesh_file"] = make.make(
            "visualization_msgs/msg/MeshFile", filename="", data=nothing
        )
    yield utime, "/gprodom/revisits", kind, make.make(kind, **fields)
