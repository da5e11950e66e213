"""ROS bags of three kinds, made here: their conversion, and damaged ones."""

import random
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from conftest import Cli, run_cli
from gprodom.cli import main
from gprodom.convert.bag_reader import choose_topics
from gprodom.errors import Error
from gprodom.lcm.logs import read

pytest.importorskip("rosbags")
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as Writer2
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

START_NS = 1_700_000_000_000_000_000
COUNT = 400  # of the IMU's messages at 100 Hz; the others have fewer
RADIUS = 0.1  # m, of the wheel that turns at 2 rad/s
RADIUS_OPTION = ("--wheel-radius", str(RADIUS))
TRACE = (Path(__file__).parents[2] / "ros" / "msg" / "GprTrace.msg").read_text()

Put = Callable[[str, str, Any, int], None]  # topic, type, message, ns


@contextmanager
def bag(path: Path, kind: str) -> Iterator[tuple[Any, Put]]:
    """A bag to be written: its types, and a function that puts a message in."""
    one = kind == "ros1"
    types = get_typestore(Stores.ROS1_NOETIC if one else Stores.ROS2_HUMBLE)
    text = TRACE.replace("Header header", "std_msgs/Header header")
    types.register(get_types_from_msg(text, "gprodom/msg/GprTrace"))
    if one:
        writer: Any = Writer1(path)
    else:
        plugin = StoragePlugin.MCAP if kind == "mcap" else StoragePlugin.SQLITE3
        writer = Writer2(path, version=9, storage_plugin=plugin)
    known: dict[str, Any] = {}
    with writer:

        def put(topic: str, name: str, message: Any, time: int) -> None:
            if topic not in known:
                known[topic] = writer.add_connection(topic, name, typestore=types)
            serialize = types.serialize_ros1 if one else types.serialize_cdr
            writer.write(known[topic], time, serialize(message, name))

        yield types.types, put


def write(path: Path, kind: str, radars: tuple[str, ...] = ("/radar",), **antennas: int) -> Path:
    """A bag with a drive. antennas: what the messages of a topic (less its /) say; default 0."""
    with bag(path, kind) as (types, put):
        write_drive(types, put, kind, radars, {f"/{name}": id_ for name, id_ in antennas.items()})
    return path


def write_drive(
    types: Any, put: Put, kind: str, radars: tuple[str, ...], antennas: Mapping[str, int] = {}
) -> Callable[[int], Any]:
    """A drive straight on: IMU, joint states, radar traces of 64 samples. Returns what makes the
    header of a time (ns)."""
    rng = np.random.default_rng(1)
    stamp, header_of = types["builtin_interfaces/msg/Time"], types["std_msgs/msg/Header"]
    xyz, unit = types["geometry_msgs/msg/Vector3"], types["geometry_msgs/msg/Quaternion"]

    def header(time: int) -> Any:
        seconds, rest = divmod(time, 1_000_000_000)
        more = {"seq": 0} if kind == "ros1" else {}
        return header_of(stamp=stamp(sec=seconds, nanosec=rest), frame_id="base", **more)

    unknown = np.concatenate([[-1.0], np.zeros(8)])
    for i in range(COUNT):
        time = START_NS + i * 10_000_000
        imu = types["sensor_msgs/msg/Imu"](
            header(time), unit(0.0, 0.0, 0.0, 1.0), unknown, xyz(0.0, 0.0, 0.01), np.zeros(9),
            xyz(*(rng.normal(0, 0.05, 3) + [0, 0, 9.81])), np.zeros(9),
        )  # fmt: skip
        put("/imu", "sensor_msgs/msg/Imu", imu, time)
        if i % 5 == 0:
            turned = np.array([0.02 * i])
            empty = np.zeros(0)
            joints = types["sensor_msgs/msg/JointState"](
                header(time), ["left"], turned, empty, empty
            )
            put("/joints", "sensor_msgs/msg/JointState", joints, time)
            for topic in radars:
                samples = rng.integers(-900, 900, 64).astype(np.int32)
                trace = types["gprodom/msg/GprTrace"](
                    header(time), i, antennas.get(topic, 0), 3.125e-10, 1e-9, 0.5, samples
                )
                put(topic, "gprodom/msg/GprTrace", trace, time)
    return header


def convert(path: Path, *arguments: str) -> dict[str, Any]:
    """The log that comes of the bag."""
    log = path.parent / "out.lcmlog"
    run_cli("convert", "bag", path, "-o", log, *RADIUS_OPTION, *arguments)
    return read(log)


@pytest.mark.parametrize("kind", ["ros1", "sqlite3", "mcap"])
def test_every_kind_of_bag(kind: str, tmp_path: Path) -> None:
    """The same log comes of the same drive, radar included without being asked for."""
    path = write(tmp_path / ("drive.bag" if kind == "ros1" else "drive"), kind)
    log = convert(path)
    assert {name: len(c["utime"]) for name, c in log.items()} == {
        "IMU": COUNT, "WHEEL": COUNT // 5, "GPR_TRACE": COUNT // 5
    }  # fmt: skip
    assert log["IMU"]["utime"][0] == START_NS // 1000
    wheel = log["WHEEL"]
    distance = np.ptp(wheel["ticks"] * wheel["metres_per_tick"])
    assert distance == pytest.approx(RADIUS * 0.02 * (COUNT - 5), abs=2e-5)
    assert not log["IMU"]["has_orientation"].any()
    assert set(log["GPR_TRACE"]["sample_interval"]) == {3.125e-10}
    assert set(log["GPR_TRACE"]["time_zero"]) == {1e-9}
    assert log["GPR_TRACE"]["samples"].shape == (COUNT // 5, 64)


def test_one_file_of_a_ros2_bag(tmp_path: Path) -> None:
    (file,) = write(tmp_path / "drive", "mcap").glob("*.mcap")
    assert len(convert(file)["IMU"]["utime"]) == COUNT


def test_a_joint_wants_its_radius(tmp_path: Path, cli: Cli) -> None:
    path = write(tmp_path / "drive.bag", "ros1")
    assert "--wheel-radius M" in cli.error("convert", "bag", path, "-o", tmp_path / "l")
    assert not (tmp_path / "l").exists()


def test_all_that_is_in_question_is_told_at_once(tmp_path: Path) -> None:
    kinds = {"/a": "sensor_msgs/msg/Imu", "/b": "sensor_msgs/msg/Imu"}
    bag = SimpleNamespace(topics=kinds, traces=lambda: ["/left", "/right"])
    nothing = dict.fromkeys(("imu", "wheel", "truth", "gpr"))
    with pytest.raises(Error) as raised:
        choose_topics(tmp_path, bag, nothing)  # type: ignore[arg-type]
    for said in ("--imu? It has /a, /b", "--wheel? It has none of", "--gpr? It has /left, /right"):
        assert said in str(raised.value)


def test_two_radars_want_a_choice(tmp_path: Path, cli: Cli) -> None:
    path = write(tmp_path / "drive.bag", "ros1", ("/left", "/right"))
    command = ["convert", "bag", path, "-o", tmp_path / "l", *RADIUS_OPTION]
    assert "which topic is --gpr? It has /left, /right" in cli.error(*command)
    assert "GPR_TRACE" in convert(path, "--gpr", "/right")
    assert "GPR_TRACE" not in convert(path, "--gpr", "none")
    cli(*command, "--gpr", "none", "--gpr", "/left", code=2)
    assert "no topic /rigth" in cli.error(*command, "--gpr", "/left", "--gpr", "/rigth")


@pytest.mark.parametrize(
    ("told", "expected"),
    [({}, {"/right": 0, "/left": 1}), ({"left": 4, "right": 2}, {"/right": 2, "/left": 4})],
    ids=["by order", "by message"],
)
def test_topics_of_two_antennas(
    told: dict[str, int], expected: dict[str, int], tmp_path: Path
) -> None:
    """By what their messages say, if they differ in that; otherwise in the order of the options."""
    path = write(tmp_path / "drive.bag", "ros1", ("/left", "/right"), **told)
    both = convert(path, "--gpr", "/right", "--gpr", "/left")["GPR_TRACE"]
    assert sorted(set(both["antenna_id"])) == sorted(expected.values())
    for topic, antenna in expected.items():
        alone = convert(path, "--gpr", topic)["GPR_TRACE"]
        mine = both["antenna_id"] == antenna
        np.testing.assert_array_equal(both["samples"][mine], alone["samples"])
        np.testing.assert_array_equal(both["seq"][mine], np.arange(COUNT // 5))
        assert set(alone["antenna_id"]) == {told.get(topic[1:], 0)}


def test_topics_that_share_an_antenna(tmp_path: Path, cli: Cli) -> None:
    """One of two with antennas 0 and 1, the other with 0: whose are they?"""
    path = tmp_path / "drive.bag"
    with bag(path, "ros1") as (types, put):
        header = write_drive(types, put, "ros1", ("/left",))(START_NS)
        for antenna in (0, 1):
            trace = types["gprodom/msg/GprTrace"](
                header, 0, antenna, 3.125e-10, 1e-9, 0.5, np.arange(64, dtype=np.int32)
            )
            put("/pair", "gprodom/msg/GprTrace", trace, START_NS)
    command = ["convert", "bag", path, "-o", tmp_path / "l", *RADIUS_OPTION]
    said = cli.error(*command, "--gpr", "/left", "--gpr", "/pair")
    assert "/pair holds traces of the antennas 0, 1, of which another" in said
    assert convert(path, "--gpr", "/pair")["GPR_TRACE"]["antenna_id"].tolist() == [0, 1]


@pytest.mark.parametrize("kind", ["ros1", "sqlite3", "mcap"])
def test_damage_is_told_in_one_line(
    kind: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = write(tmp_path / ("drive.bag" if kind == "ros1" else "drive"), kind)
    [file] = [path] if kind == "ros1" else [f for f in path.iterdir() if f.suffix != ".yaml"]
    whole, rng = file.read_bytes(), random.Random(7)
    refused = 0
    for round_ in range(25):
        data = bytearray(whole[: rng.randrange(len(whole))] if round_ % 5 == 0 else whole)
        for _ in range(rng.choice([1, 30, 1000])):
            data[rng.randrange(len(data))] = rng.randrange(256)
        file.write_bytes(data)
        code = main(["convert", "bag", str(path), "-o", str(tmp_path / "l"), "--wheel-radius", "1"])
        refused += code
        said = capsys.readouterr().err
        if code:
            assert said.startswith("gprodom: error: ") and said.count("\n") == 1, said
            assert len(said) < 1000
    assert refused > 3
