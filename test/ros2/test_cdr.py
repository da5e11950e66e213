"""The bytes of every message are those of rosbags, both ways; the package of our messages."""

from __future__ import annotations

import re
import struct
import subprocess
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from rosbags.typesys import Stores, get_typestore

from kit import BIN, CHECKOUT, PACKAGE, from_cdr, from_the_wire, on_the_wire, store, to_cdr

# Of the node.
MESSAGES = (CHECKOUT / "ros2/src/messages.h").read_text()
KINDS = [from_the_wire(name) for name in re.findall(r'GPRODOM_MESSAGE\("([\w:]+)"', MESSAGES)]
BASES = {"int8", "uint8", "int16", "uint16", "int32", "uint32", "int64", "uint64"}


def random_value(field: Any, rng: np.random.Generator) -> Any:
    """`field`: as rosbags' type store describes one."""
    nodetype, what = field
    if nodetype.name == "NAME":
        return random_message(what, rng)
    if nodetype.name == "BASE":
        base = what[0]
        if base == "string":
            return "".join(rng.choice(list("aß∂ \n/_0"), rng.integers(0, 12)))
        if base == "bool":
            return bool(rng.integers(0, 2))
        if base == "byte":  # rosbags takes those of int8
            return int(rng.integers(0, 128))
        if base in BASES:
            limits = np.iinfo(base)
            return int(rng.integers(limits.min, limits.max, dtype=limits.dtype, endpoint=True))
        return float(rng.choice([rng.normal(), 1e300, -0.0, np.inf, 5e-324]))
    (inner, size) = what
    count = size if nodetype.name == "ARRAY" else int(rng.integers(0, 6))
    values = [random_value(inner, rng) for _ in range(count)]
    if inner[0].name == "BASE" and inner[1][0] != "string":
        return np.array(values, inner[1][0])
    return values


def random_message(kind: str, rng: np.random.Generator) -> Any:
    _, fields = store().fielddefs[kind]
    return store().types[kind](**{name: random_value(field, rng) for name, field in fields})


class Echo:
    """Our own reader and writer."""

    def __init__(self) -> None:
        self.process = subprocess.Popen(
            [str(BIN / "cdr_echo")], stdin=subprocess.PIPE, stdout=subprocess.PIPE
        )

    def __call__(self, kind: str, cdr: bytes) -> tuple[bool, bytes]:
        ask, answer = self.process.stdin, self.process.stdout
        assert ask is not None and answer is not None
        for part in (on_the_wire(kind).encode(), cdr):
            ask.write(struct.pack("<I", len(part)) + part)
        ask.flush()
        good, size = struct.unpack("<bI", answer.read(5))
        return bool(good), answer.read(size)


@pytest.fixture(scope="module")
def echo() -> Iterator[Echo]:
    echo = Echo()
    yield echo
    assert echo.process.stdin is not None
    echo.process.stdin.close()
    assert echo.process.wait(10) == 0


@pytest.mark.parametrize("kind", KINDS)
def test_bytes_are_those_of_rosbags_both_ways(kind: str, echo: Echo) -> None:
    rng = np.random.default_rng(1)
    for _ in range(100):
        cdr = to_cdr(kind, random_message(kind, rng))
        good, ours = echo(kind, cdr)
        assert good, ours
        assert ours == cdr
        assert to_cdr(kind, from_cdr(kind, ours)) == cdr


@pytest.mark.parametrize("kind", KINDS)
def test_changed_bytes_are_read_or_refused(kind: str, echo: Echo) -> None:
    """Nothing ends the program, and what is read is what is written."""
    rng = np.random.default_rng(2)
    refused = 0
    for _ in range(200):
        cdr = bytearray(to_cdr(kind, random_message(kind, rng)))
        for _ in range(rng.integers(1, 4)):
            cdr[rng.integers(0, len(cdr))] = rng.integers(0, 256)
        if rng.random() < 0.5:
            del cdr[rng.integers(0, len(cdr)) :]
        good, said = echo(kind, bytes(cdr))
        if good:
            assert echo(kind, said) == (True, said)
        else:
            refused += 1
            assert re.match("is |has ", said.decode())
    assert refused > 20


def test_idl_has_the_fields_of_the_definitions() -> None:
    """Names and order; that their bytes are the same is seen where Fast DDS speaks to the node."""
    text = re.sub(r"//.*", "", (CHECKOUT / "ros2/idl/messages.idl").read_text())
    seen = 0
    for package, body in re.findall(r"module (\w+) { module msg {(.*?)\n}; };", text, re.S):
        for name, inside in re.findall(r"struct (\w+) {(.*?)};", body, re.S):
            _, fields = store().fielddefs[f"{package}/msg/{name}"]
            names = re.findall(r"(\w+);", inside)
            assert names == [field for field, _ in fields], name
            seen += 1
    assert seen == len(KINDS) + 1  # geometry_msgs/Point, which here is Vector3


def test_package_names_its_messages_and_what_they_need() -> None:
    made = re.search(
        r"rosidl_generate_interfaces\((.*?)\)", (PACKAGE / "CMakeLists.txt").read_text(), re.S
    )
    assert made is not None
    listed = set(re.findall(r"msg/\w+\.msg", made[1]))
    assert listed == {f"msg/{path.name}" for path in (PACKAGE / "msg").glob("*.msg")}
    others = {
        kind.split("/")[0]
        for path in (PACKAGE / "msg").glob("*.msg")
        for kind in re.findall(r"^(\w+/\w+) ", path.read_text(), re.M)
    }
    assert set(made[1].split("DEPENDENCIES")[1].split()) == others
    package = (PACKAGE / "package.xml").read_text()
    assert set(re.findall(r"<depend>(\w+)</depend>", package)) == others


def test_layout_is_the_same_for_later_ros() -> None:
    """Of the types that ROS 2 defines: Humble, Jazzy and Kilted have the same fields."""
    for later in (Stores.ROS2_JAZZY, Stores.ROS2_KILTED):
        known = get_typestore(later)
        for kind in KINDS:
            if not kind.startswith("gprodom_msgs/"):
                assert known.fielddefs[kind][1] == store().fielddefs[kind][1], (later, kind)
