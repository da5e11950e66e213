"""An estimate as a recording for ROS tools, by rosbags; needs no ROS: MCAP or the folder of a ROS 2
bag with SQLite, or a ROS 1 bag.

Topics, as the ROS 1 node has them where it has them: gprodom/odometry and gprodom/odometry_map with
covariances, gprodom/path, tf (map to odom to base_link), diagnostics, and gprodom/bscan, the last
traces of the radar as a picture, of a further antenna gprodom/bscan_ID; and those of
`gprodom.export.panels`.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from gprodom.arrays import Ints
from gprodom.drive.log import Drive
from gprodom.errors import need_module
from gprodom.export.panels import panels
from gprodom.files import replacing
from gprodom.lcm.antennas import apart
from gprodom.lcm.logs import Channel
from gprodom.score.sources import odometry
from gprodom.trajectory import Trajectory

TRANSFORMS = "tf2_msgs/msg/TFMessage"
BODY, MAP, ODOM = "base_link", "map", "odom"
SCAN = "/gprodom/bscan"  # of the antenna that is heard first
SCAN_TRACES = 200  # of a picture of the radar
SCAN_EVERY = 40  # traces from one picture to the next

Entry = tuple[int, str, str, Any]  # time (us), topic, type, message


class _Messages:
    """ROS messages of what a log holds; `one`: for ROS 1, whose headers have a sequence number."""

    def __init__(self, types: Any, one: bool) -> None:
        self._types, self._one = types, one

    def make(self, kind: str, /, **fields: Any) -> Any:
        return self._types[kind](**fields)

    def header(self, utime: int, frame: str) -> Any:
        seconds, micro = divmod(int(utime), 1_000_000)
        stamp = self.make("builtin_interfaces/msg/Time", sec=seconds, nanosec=micro * 1000)
        more = {"seq": 0} if self._one else {}
        return self.make("std_msgs/msg/Header", stamp=stamp, frame_id=frame, **more)

    def point(self, kind: str, xyz: Any) -> Any:
        x, y, z = (float(value) for value in xyz)
        return self.make(f"geometry_msgs/msg/{kind}", x=x, y=y, z=z)

    def _quaternion(self, wxyz: Any) -> Any:
        w, x, y, z = (float(value) for value in wxyz)
        return self.make("geometry_msgs/msg/Quaternion", x=x, y=y, z=z, w=w)

    def pose(self, position: Any, orientation: Any) -> Any:
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
            header = self.header(status.utime, "")
            yield (
                status.utime,
                "/diagnostics",
                array,
                self.make(array, header=header, status=[one]),
            )

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


def write_ros(
    path: Path, channels: dict[str, Channel], form: str, drive: Drive | None = None
) -> int:
    """Writes a recording; returns how many messages it holds.

    channels: of a log, by role; what is not there is left out.
    form: mcap or rosbag, files; or rosbag2, a folder, which must not be there yet.
    drive: for the panels of a viewer.
    """
    need_module("rosbags", "bag")
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    one = form == "rosbag"
    store = get_typestore(Stores.ROS1_NOETIC if one else Stores.ROS2_HUMBLE)
    if TRANSFORMS not in store.types:  # no part of what rosbags knows of ROS 1
        transforms = "geometry_msgs/TransformStamped[] transforms"
        store.register(get_types_from_msg(transforms, TRANSFORMS))
    make = _Messages(store.types, one)
    found = [*_entries(make, channels), *([] if drive is None else panels(make, drive))]
    entries = sorted(found, key=lambda entry: entry[0])
    with tempfile.TemporaryDirectory(dir=path.parent) as name:
        made = Path(name) / path.name  # by which the files in a folder are called
        _write(made, store, entries, form)
        if form == "rosbag2":
            made.rename(path)
        else:
            with replacing(path) as part:
                (made if one else next(made.glob("*.mcap"))).replace(part)
    return len(entries)


def _entries(make: _Messages, channels: dict[str, Channel]) -> Iterator[Entry]:
    if "odometry" in channels:
        yield from make.odometry(channels["odometry"], ODOM, "/gprodom/odometry")
        yield from make.transforms(channels["odometry"], ODOM, BODY)
    if "odometry_map" in channels:
        yield from make.odometry(channels["odometry_map"], MAP, "/gprodom/odometry_map")
        yield from make.path(odometry(channels["odometry_map"]), MAP, "/gprodom/path")
        if "odometry" not in channels:
            yield from make.transforms(channels["odometry_map"], MAP, BODY)
    if "correction" in channels:
        yield from make.transforms(channels["correction"], MAP, ODOM)
    if "status" in channels:
        yield from make.diagnostics(channels["status"])
    if "gpr_trace" in channels:
        for number, (antenna, radar) in enumerate(apart(channels["gpr_trace"]).items()):
            yield from make.scans(radar, f"/gprodom/bscan_{antenna}" if number else SCAN)


def _write(path: Path, store: Any, entries: list[Entry], form: str) -> None:
    from rosbags.rosbag1 import Writer as Writer1
    from rosbags.rosbag2 import StoragePlugin
    from rosbags.rosbag2 import Writer as Writer2

    # What describes the folder: of version 9 ROS 2 Humble cannot read the quality of service.
    made: Any = {
        "mcap": lambda: Writer2(path, version=9, storage_plugin=StoragePlugin.MCAP),
        "rosbag": lambda: Writer1(path),
        "rosbag2": lambda: Writer2(path, version=8, storage_plugin=StoragePlugin.SQLITE3),
    }[form]()
    serialize = store.serialize_ros1 if form == "rosbag" else store.serialize_cdr
    known: dict[str, Any] = {}
    with made as writer:
        for utime, topic, kind, message in entries:
            if topic not in known:
                known[topic] = writer.add_connection(topic, kind, typestore=store)
            writer.write(known[topic], utime * 1000, serialize(message, kind))
