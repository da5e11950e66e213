"""An estimate as a recording for ROS tools, by rosbags; needs no ROS: MCAP or the folder of a ROS 2
bag with SQLite, or a ROS 1 bag.

Topics, as the ROS 1 node has them where it has them: gprodom/odometry and gprodom/odometry_map with
covariances, gprodom/path, tf (map to odom to base_link), diagnostics, and gprodom/bscan, the last
traces of the radar as a picture, of a further antenna gprodom/bscan_ID; and those of
`gprodom.export.panels`.
"""

import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from gprodom.drive.log import Drive
from gprodom.errors import need_module
from gprodom.export.messages import BODY, MAP, ODOM, TRANSFORMS, Entry, Messages
from gprodom.export.panels import panels
from gprodom.files import replacing
from gprodom.lcm.antennas import apart
from gprodom.lcm.logs import Channel
from gprodom.score.sources import odometry

SCAN = "/gprodom/bscan"  # of the antenna that is heard first


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
    make = Messages(store.types, one)
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


def _entries(make: Messages, channels: dict[str, Channel]) -> Iterator[Entry]:
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
