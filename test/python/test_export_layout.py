"""gprodom export --layout: its panels ask for what --mcap writes, and that is the drive."""

import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from conftest import run_cli
from made_drive import RADIUS, SECONDS, SLIPS_S, SPEED, STANDS_S, START_US, place

pytest.importorskip("rosbags", reason="rosbags (the extra bag) is not installed")
pytest.importorskip("mcap_ros2", reason="mcap-ros2-support (the extra test) is not installed")


# What Foxglove's panels draw of ROS messages, as the documentation of each panel lists them; the
# two others take any number on a message path.
POSE, MARKER = "geometry_msgs/msg/PoseWithCovarianceStamped", "visualization_msgs/msg/Marker"
DRAWN = {
    "3D": {"nav_msgs/msg/Path", POSE, MARKER},
    "Image": {"sensor_msgs/msg/Image", "sensor_msgs/msg/CompressedImage"},
    "DiagnosticSummary": {"diagnostic_msgs/msg/DiagnosticArray"},
    "Plot": set(),
    "StateTransitions": set(),
}


@pytest.fixture(scope="module")
def made(made_log: Path) -> Path:
    """The folder of drive.mcap and drive.json."""
    folder = made_log.parent
    run_cli("export", made_log, "--mcap", folder / "drive.mcap", "--layout", folder / "drive.json")
    return folder


@pytest.fixture(scope="module")
def messages(made: Path) -> dict[str, list[tuple[float, Any]]]:
    """By topic: seconds after the begin, and message."""
    from mcap_ros2.reader import read_ros2_messages

    found: dict[str, list[tuple[float, Any]]] = {}
    for each in read_ros2_messages(str(made / "drive.mcap")):
        second = each.log_time_ns * 1e-9 - START_US * 1e-6
        found.setdefault(each.channel.topic, []).append((second, each.ros_msg))
    return found


def value_at(message: Any, path: str) -> float:
    """What a message path of Foxglove stands for."""
    value = message
    for name, index in re.findall(r"\.(\w+)|\[(\d+)\]", path.partition(".@")[0]):
        value = getattr(value, name) if name else value[int(index)]
    return float(value)


def test_every_panel_finds_its_data(
    made: Path, messages: dict[str, list[tuple[float, Any]]]
) -> None:
    layout = json.loads((made / "drive.json").read_text())
    panels = layout["configById"]

    def leaves(node: Any) -> list[str]:
        return [node] if isinstance(node, str) else leaves(node["first"]) + leaves(node["second"])

    assert sorted(leaves(layout["layout"])) == sorted(panels)
    paths = [
        each["value"]
        for name, panel in panels.items()
        if name.startswith(("Plot", "StateTransitions"))
        for each in panel["paths"]
    ]
    assert len(paths) == 9
    for path in paths:
        topic = re.match(r"[/\w]+", path)
        assert topic is not None
        if topic[0] == "/gprodom/speed/radar":  # the made-up radar tells no speed
            continue
        values = [value_at(m, path.removeprefix(topic[0])) for _, m in messages[topic[0]]]
        assert np.all(np.isfinite(values)), path
        assert path.partition(".@")[2] in ("", "sqrt")
    shown = panels["3D!way"]["topics"]
    assert set(shown) - set(messages) == {"/gprodom/truth"}  # which this log does not have
    assert panels["DiagnosticSummary!told"]["topicToRender"] in messages
    assert panels["Image!ground"]["imageMode"]["imageTopic"] in messages


def topics_of(name: str, panel: dict[str, Any]) -> list[str]:
    """Topics that a panel draws whole."""
    if name.startswith("3D!"):
        return list(panel["topics"])
    if name.startswith("Image!"):
        return [panel["imageMode"]["imageTopic"]]
    return [panel["topicToRender"]] if name.startswith("DiagnosticSummary!") else []


def test_schemas_are_those_that_foxglove_draws(made: Path) -> None:
    """In the file itself: its schema of a topic says that the panel can draw it."""
    from mcap.reader import make_reader

    with (made / "drive.mcap").open("rb") as file:
        summary = make_reader(file).get_summary()
    assert summary is not None
    schemas = {each.topic: summary.schemas[each.schema_id] for each in summary.channels.values()}
    assert {each.encoding for each in schemas.values()} == {"ros2msg"}
    assert {each.message_encoding for each in summary.channels.values()} == {"cdr"}
    panels = json.loads((made / "drive.json").read_text())["configById"]
    assert {name.partition("!")[0] for name in panels} == set(DRAWN)
    looked_at = 0
    for name, panel in panels.items():
        for topic in topics_of(name, panel):
            if topic == "/gprodom/truth":  # which this log does not have
                continue
            assert schemas[topic].name in DRAWN[name.partition("!")[0]], topic
            looked_at += 1
    assert looked_at == 5 + 1 + 1


def test_messages_for_the_panels_are_those_of_the_drive(
    messages: dict[str, list[tuple[float, Any]]],
) -> None:
    for topic in ("/gprodom/path", "/gprodom/path_odom", "/gprodom/path_wheel_gyro"):
        [(second, way)] = messages[topic]
        assert second == 0.0  # so that a viewer shows it always
        places = np.array([[p.pose.position.x, p.pose.position.y] for p in way.poses])
        np.testing.assert_allclose(
            np.linalg.norm(places - [0.0, RADIUS], axis=1), RADIUS, atol=0.05
        )
    speeds = [m.twist.linear.x for t, m in messages["/gprodom/speed/wheel"] if t > STANDS_S + 1]
    assert np.median(speeds) == pytest.approx(SPEED, abs=0.01)
    changes = [(t, m.data) for t, m in messages["/gprodom/slipping"]]
    expected = [0.0, *(edge for span in SLIPS_S for edge in span)]
    np.testing.assert_allclose([t for t, _ in changes], expected, atol=0.1)
    assert [on for _, on in changes] == [False, True, False, True, False]
    [(second, marker)] = messages["/gprodom/revisits"]
    assert second == 0.0 and len(marker.points) == 4
    assert marker.points[0].x == pytest.approx(place(20)[0], abs=0.01)
    assert len(messages["/gprodom/pose"]) > 9 * SECONDS


def test_the_same_in_a_ros_1_bag(made: Path) -> None:
    from rosbags.highlevel import AnyReader

    bag = made / "drive.bag"
    run_cli("export", made / "drive.lcmlog", "--rosbag", bag)
    with AnyReader([bag]) as reader:
        counts = {each.topic: each.msgcount for each in reader.connections}
    assert counts["/gprodom/revisits"] == 1 and counts["/gprodom/slipping"] == 5
