"""What a log of the estimator holds, as ROS messages."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from gprodom.arrays import Ints
from gprodom.lcm.logs import Channel
from gprodom.trajectory import Trajectory

TRANSFORMS = "tf2_msgs/msg/TFMessage"
BODY, MAP, ODOM = "base_link", "map", "odom"
SCAN_TRACES = 200  # of a picture of the radar
SCAN_EVERY = 40  # traces from one picture to the next

Entry = tuple[int, str, str, Any]  # time (us), topic, type, message


class Messages:
    """ROS messages of what a log holds; `one`: for ROS 1, whose headers have a sequence number."""

    def __init__(self, types: Any, one: bool) -> None:
        self._types, self._one = types, one

    def make(self, kind: str, /, **fields: Any) -> Any:
        """A message of that type."""
        return self._types[kind](**fields)

    def header(self, utime: int, frame: str) -> Any:
        """A header."""
        seconds, micro = divmod(int(utime), 1_000_000)
        stamp = self.make("builtin_interfaces/msg/Time", sec=seconds, nanosec=micro * 1000)
        more = {"seq": 0} if self._one else {}
        return self.make("std_msgs/msg/Header", stamp=stamp, frame_id=frame, **more)

    def point(self, kind: str, xyz: Any) -> Any:
        """A point or vector."""
        x, y, z = (float(value) for value in xyz)
        return self.make(f"geometry_msgs/msg/{kind}", x=x, y=y, z=z)

    def _quaternion(self, wxyz: Any) -> Any:
        w, x, y, z = (float(value) for value in wxyz)
        return self.make("geometry_msgs/msg/Quaternion", x=x, y=y, z=z, w=w)

    def pose(self, position: Any, orientation: Any) -> Any:
        """A pose."""
        return self.make(
            "geometry_msgs/msg/Pose",
            position=self.point("Point", position),
            orientation=self._quaternion(orientation),
        )

    def odometry(self, content: Channel, frame: str, topic: str) -> Iterator[Entry]:
        """nav_msgs/Odometry of a channel of odometry_t."""
        for i, utime in enumerate(content["utime"].tolist()):
            pose = self.make(
                "geometry_msgs/msg/PoseWithCovariance",
                pose=self.pose(content["position"][i], content["orientation"][i]),
                covariance=np.array(content["pose_covariance"][i], np.float64),
            )
            spread = np.zeros((6, 6))
            spread[:3, :3] = content["velocity_covariance"][i].reshape(3, 3)
            twist = self.make(
                "geometry_msgs/msg/Twist",
                linear=self.point("Vector3", content["velocity"][i]),
                angular=self.point("Vector3", content["angular_velocity"][i]),
            )
            twist = self.make(
                "geometry_msgs/msg/TwistWithCovariance", twist=twist, covariance=spread.ravel()
            )
            message = self.make(
                "nav_msgs/msg/Odometry",
                header=self.header(utime, frame),
                child_frame_id=BODY,
                pose=pose,
                twist=twist,
            )
            yield utime, topic, "nav_msgs/msg/Odometry", message

    def transforms(self, content: Channel, parent: str, child: str) -> Iterator[Entry]:
        """tf2_msgs/TFMessage of a channel with position and orientation of `child` in `parent`."""
        for i, utime in enumerate(content["utime"].tolist()):
            transform = self.make(
                "geometry_msgs/msg/Transform",
                translation=self.point("Vector3", content["position"][i]),
                rotation=self._quaternion(content["orientation"][i]),
            )
            stamped = self.make(
                "geometry_msgs/msg/TransformStamped",
                header=self.header(utime, parent),
                child_frame_id=child,
                transform=transform,
            )
            yield utime, "/tf", TRANSFORMS, self.make(TRANSFORMS, transforms=[stamped])

    def path(self, way: Trajectory, frame: str, topic: str) -> Iterator[Entry]:
        """A whole way as one nav_msgs/Path, stamped with its begin: so a viewer shows it always."""
        level = (1.0, 0.0, 0.0, 0.0)
        poses = [
            self.make(
                "geometry_msgs/msg/PoseStamped",
                header=self.header(utime, frame),
                pose=self.pose(
                    way.position[i], level if way.orientation is None else way.orientation[i]
                ),
            )
            for i, utime in enumerate(way.time.tolist())
        ]
        begin = int(way.time[0])
        message = self.make("nav_msgs/msg/Path", header=self.header(begin, frame), poses=poses)
        yield begin, topic, "nav_msgs/msg/Path", message

    def names(self, kind: str) -> list[str]:
        """Of the fields of a type."""
        return list(self._types[kind].__dataclass_fields__)

    def diagnostics(self, content: Channel) -> Iterator[Entry]:
        """diagnostic_msgs/DiagnosticArray of status_t."""
        array = "diagnostic_msgs/msg/DiagnosticArray"
        for status in content["messages"]:
            values = [
                self.make("diagnostic_msgs/msg/KeyValue", key=key, value=f"{value:g}")
                for key, value in zip(status.names, status.values, strict=True)
            ]
            one = self.make(
                "diagnostic_msgs/msg/DiagnosticStatus",
                level=int(status.health),
                name="gprodom",
                message="; ".join(status.reasons) or "ok",
                hardware_id="",
                values=values,
            )
            message = self.make(array, header=self.header(status.utime, ""), status=[one])
            yield status.utime, "/diagnostics", array, message

    def scans(self, radar: Channel, topic: str) -> Iterator[Entry]:
        """sensor_msgs/Image, mono8: a column for each trace, less the mean trace of the picture."""
        samples = np.stack(list(radar["samples"])).astype(np.float64)
        for end in range(SCAN_TRACES, len(samples) + 1, SCAN_EVERY):
            grey = as_grey(samples[end - SCAN_TRACES : end])
            utime = int(radar["utime"][end - 1])
            message = self.make(
                "sensor_msgs/msg/Image",
                header=self.header(utime, BODY),
                height=grey.shape[0],
                width=grey.shape[1],
                encoding="mono8",
                is_bigendian=0,
                step=grey.shape[1],
                data=grey.ravel(),
            )
            yield utime, topic, "sensor_msgs/msg/Image", message


def as_grey(traces: Any) -> Ints:
    """(samples, n) uint8 of traces (n, samples): 128 is 0, and the strongest 1 % are clipped."""
    echoes = (traces - traces.mean(axis=0)).T
    reach = max(float(np.quantile(np.abs(echoes), 0.99)), 1e-9)
    return np.asarray(np.clip(np.rint(127.5 + 127.5 * echoes / reach), 0, 255), np.uint8)
