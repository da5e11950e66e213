"""Logs as arrays: the same as the generated classes say, message by message."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gprodom.errors import Error
from gprodom.lcm import EventLog, logs, wire
from gprodom.lcm.messages import message

BOOLEANS = ("has_orientation", "valid", "mirrored", "has_heading")


def fill(name: str, generator: np.random.Generator, length: int) -> Any:
    """A message of type `name` with random content; strings and arrays as long as `length`."""
    result = message(name)()
    for field, kind, shape in wire.LAYOUTS[name]:
        if kind == "":
            value: Any = "ödometry"[:length]
        elif field in BOOLEANS:
            value = bool(generator.integers(2))
        elif isinstance(shape, str):
            value = generator.integers(-(2**31), 2**31, length).tolist()
            setattr(result, shape, length)
        elif kind == ">f8":
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
    log = EventLog(tmp_path / "log", "w")
    for utime in range(5):
        log.write_event(utime, "IMU", fill("imu_t", generator, 0).encode())
        if utime == 2:
            log.write_event(20, "IMU", fill("wheel_t", generator, 0).encode())
            log.write_event(21, "IMU", b"who knows what")
    log.close()
    imu = logs.read(tmp_path / "log")["IMU"]
    assert (imu["type"], imu["log_utime"].tolist()) == ("imu_t", [0, 1, 2, 3, 4])
    assert imu["linear_acceleration"].shape == (5, 3)
    assert "channel IMU: 2 messages that are no imu_t" in capsys.readouterr().err


def test_log_by_channel(tmp_path: Path) -> None:
    generator = np.random.default_rng(5)
    status = message("status_t")()
    status.utime, status.num_reasons, status.reasons = 9, 1, ["no radar"]
    pose = message("pose_t", "bot_core")()
    log = EventLog(tmp_path / "log", "w")
    for utime in range(5):
        imu = fill("imu_t", generator, 0)
        imu.utime = utime
        log.write_event(10 + utime, "IMU", imu.encode())
        log.write_event(10 + utime, "STATUS", status.encode())
        log.write_event(10 + utime, "POSE", pose.encode())
    log.close()
    content = logs.read(tmp_path / "log")
    assert set(content) == {"IMU", "STATUS"}
    assert content["IMU"]["utime"].tolist() == [0, 1, 2, 3, 4]
    assert content["IMU"]["log_utime"].tolist() == [10, 11, 12, 13, 14]
    assert content["STATUS"]["messages"][2].reasons == ["no radar"]
    assert set(logs.read(tmp_path / "log", ["IMU"])) == {"IMU"}
    assert set(logs.of_type(content, "status_t")) == {"STATUS"}


def test_damaged_logs_are_named(tmp_path: Path) -> None:
    with pytest.raises(Error, match="no such log"):
        logs.read(tmp_path / "missing")
    (tmp_path / "text").write_text("hello" * 100)
    with pytest.raises(Error, match="expected an LCM log"):
        logs.read(tmp_path / "text")
    log = EventLog(tmp_path / "log", "w")
    log.write_event(1, "IMU", message("imu_t")().encode()[:-1])
    log.close()
    with pytest.raises(Error, match="channel IMU: message 0 has 96 bytes, as no imu_t can"):
        logs.read(tmp_path / "log")
