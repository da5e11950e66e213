"""Logs as arrays: the same as the generated classes say, message by message."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gprodom.errors import Error
from gprodom.lcm import logs, wire
from gprodom.lcm.constants import constants, flag, flag_bits, health, kind
from gprodom.lcm.messages import fingerprint, message
from packets import packet, status, write_events

BOOLEANS = ("has_orientation", "valid", "mirrored", "has_heading")


def fill(name: str, generator: np.random.Generator, length: int) -> Any:
    """A message of type `name` with random content; strings and arrays as long as `length`."""
    result = message(name)()
    for field, element, shape in wire.LAYOUTS[name]:
        if element == "":
            value: Any = "ödometry"[:length]
        elif field in BOOLEANS:
            value = bool(generator.integers(2))
        elif isinstance(shape, str):
            value = generator.integers(-(2**31), 2**31, length).tolist()
            setattr(result, shape, length)
        elif element == ">f8":
            value = generator.normal(size=shape).tolist() if shape else generator.normal()
        else:
            value = int(generator.integers(-100, 100))
        if field != "num_samples":
            setattr(result, field, value)
    return result


@pytest.mark.parametrize("ragged", [False, True])
@pytest.mark.parametrize("name", wire.LAYOUTS)
def test_arrays_equal_the_generated_classes(name: str, ragged: bool) -> None:
    generator = np.random.default_rng(5)
    sent = [fill(name, generator, 3 + (i % 3 if ragged else 0)) for i in range(10)]
    payloads = [one.encode() for one in sent]
    arrays = wire.decode(name, payloads, "here")
    for field, _, _ in wire.LAYOUTS[name]:
        for row, one in zip(arrays[field], sent, strict=True):
            np.testing.assert_array_equal(row, getattr(one, field))
            if field in BOOLEANS:
                assert row.dtype == bool
    if not ragged and not any(kind == "" for _, kind, _ in wire.LAYOUTS[name]):
        assert wire.encode(name, arrays, 10) == payloads


def test_a_foreign_message_costs_only_itself(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Another type's message and bytes of no type, in the middle of a channel."""
    generator = np.random.default_rng(5)
    events = [(utime, "IMU", fill("imu_t", generator, 0).encode()) for utime in range(5)]
    other = fill("wheel_t", generator, 0).encode()
    events += [(2, "IMU", other), (2, "IMU", b"who knows what")]
    imu = logs.read(write_events(tmp_path / "log", events))["IMU"]
    assert (imu["type"], imu["log_utime"].tolist()) == ("imu_t", [0, 1, 2, 3, 4])
    assert imu["linear_acceleration"].shape == (5, 3)
    assert "channel IMU: 2 messages that are no imu_t" in capsys.readouterr().err


def test_log_by_channel(tmp_path: Path) -> None:
    generator = np.random.default_rng(5)
    events = []
    for utime in range(5):
        imu = fill("imu_t", generator, 0)
        imu.utime = utime
        pose = packet("pose_t", "bot_core")
        sent = {"IMU": imu.encode(), "STATUS": status(9, {}, 0, ["no radar"]), "POSE": pose}
        events += [(10 + utime, channel, data) for channel, data in sent.items()]
    content = logs.read(write_events(tmp_path / "log", events))
    assert set(content) == {"IMU", "STATUS"}
    assert content["IMU"]["utime"].tolist() == [0, 1, 2, 3, 4]
    assert content["IMU"]["log_utime"].tolist() == [10, 11, 12, 13, 14]
    assert content["STATUS"]["messages"][2].reasons == ["no radar"]
    assert set(logs.read(tmp_path / "log", ["IMU"])) == {"IMU"}


def test_damaged_logs_are_named(tmp_path: Path) -> None:
    with pytest.raises(Error, match="no such log"):
        logs.read(tmp_path / "missing")
    (tmp_path / "text").write_text("hello" * 100)
    with pytest.raises(Error, match="expected an LCM log"):
        logs.read(tmp_path / "text")
    write_events(tmp_path / "log", [(1, "IMU", packet("imu_t")[:-1])])
    with pytest.raises(Error, match="channel IMU: message 0 has 96 bytes, as no imu_t can"):
        logs.read(tmp_path / "log")


# Flags and kinds have the numbers of the message types, and one name each in all commands.


# Fingerprints of the released types. Constants and comments do not change them. A changed field
# would make older logs unreadable, so it needs a new type.
FINGERPRINTS = {
    "gpr_trace_t": "49e526d0b0c7b2c9",
    "imu_t": "0a170b716bb0a149",
    "wheel_t": "679ea99815b041e2",
    "wheels_t": "4d0f4d39e0feb30d",
    "displacement_t": "f888749f9d266787",
    "odometry_t": "abbdede81f929f4d",
    "correction_t": "a359df710ec0655d",
    "sfm_t": "cd0519d87babcb41",
    "status_t": "9273f74c71f3eb9b",
    "position_truth_t": "0a7e47c86cccfbab",
    "command_t": "8a8691b212605be7",
    "position_fix_t": "d2ba87590c33a909",
}


def test_released_types_keep_their_fingerprints() -> None:
    assert {name: fingerprint(name).hex() for name in FINGERPRINTS} == FINGERPRINTS


def test_every_flag_of_the_type_has_a_name() -> None:
    bits = set(flag_bits().values())
    assert bits == set(constants("odometry_t").values()) == {1 << i for i in range(11)}
    assert flag("SLIPPING") == message("odometry_t").SLIPPING


def test_kinds_and_health_are_those_of_the_types() -> None:
    assert [kind(name) for name in ("SEQUENTIAL", "MOTION", "REVISIT", "EXTERNAL")] == [0, 1, 2, 3]
    assert [health(value) for value in range(3)] == ["ok", "degraded", "failed"]
