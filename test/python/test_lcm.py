"""Our binding over liblcm and the PyPI module are interchangeable."""

import random
import sys
from pathlib import Path
from types import ModuleType

import pytest

import gprodom.lcm.binding
from conftest import run_isolated, run_program

pypi = pytest.importorskip("lcm")
BINDINGS = [pytest.param(pypi, id="pypi"), pytest.param(gprodom.lcm.binding, id="ctypes")]

_random = random.Random(1)
EVENTS = [
    (1_700_000_000_000_000 + 977 * i, f"CHANNEL_{i % 7}", _random.randbytes(i % 90))
    for i in range(1, 400)
]


def write(binding: ModuleType, path: Path) -> None:
    log = binding.EventLog(path, "w", overwrite=True)
    for event in EVENTS:
        log.write_event(*event)
    log.close()


def test_logs_are_the_same_to_the_byte(tmp_path: Path) -> None:
    write(pypi, tmp_path / "pypi")
    write(gprodom.lcm.binding, tmp_path / "ctypes")
    assert (tmp_path / "pypi").read_bytes() == (tmp_path / "ctypes").read_bytes()


@pytest.mark.parametrize("binding", BINDINGS)
@pytest.mark.parametrize("writer", BINDINGS)
def test_log_is_read_back(binding: ModuleType, writer: ModuleType, tmp_path: Path) -> None:
    write(writer, tmp_path / "log")
    log = binding.EventLog(str(tmp_path / "log"))
    assert log.size() == (tmp_path / "log").stat().st_size
    read = [(e.eventnum, e.timestamp, e.channel, e.data) for e in log]
    assert read == [(i, *event) for i, event in enumerate(EVENTS)]
    assert log.tell() == log.size()
    assert log.read_next_event() is None
    log.seek(1)  # inside the first event: reading resumes at the second
    assert log.read_next_event().eventnum == 1
    log.seek_to_timestamp(EVENTS[200][0])
    assert abs(log.read_next_event().eventnum - 200) <= 1
    log.close()


@pytest.mark.parametrize("binding", BINDINGS)
def test_log_refuses(binding: ModuleType, tmp_path: Path) -> None:
    write(binding, tmp_path / "log")
    with pytest.raises(ValueError, match="overwrite"):
        binding.EventLog(tmp_path / "log", "w")
    with pytest.raises(ValueError, match="mode"):
        binding.EventLog(tmp_path / "log", "a")
    with pytest.raises(OSError):
        binding.EventLog(tmp_path / "missing")


@pytest.mark.parametrize("binding", BINDINGS)
def test_file_provider_dispatches(binding: ModuleType, tmp_path: Path) -> None:
    write(binding, tmp_path / "log")
    lcm = binding.LCM(f"file://{tmp_path / 'log'}?speed=0")
    received: list[tuple[str, bytes]] = []
    lcm.subscribe("CHANNEL_[12]", lambda channel, data: received.append((channel, bytes(data))))
    dropped = lcm.subscribe("CHANNEL_3", lambda channel, data: received.append((channel, data)))
    lcm.unsubscribe(dropped)
    with pytest.raises(OSError):
        while True:
            lcm.handle()
    assert received == [e[1:] for e in EVENTS if e[1] in ("CHANNEL_1", "CHANNEL_2")]


@pytest.mark.parametrize("binding", BINDINGS)
def test_error_in_a_callback_reaches_the_caller(binding: ModuleType) -> None:
    lcm = binding.LCM("memq://")
    lcm.subscribe("A", lambda channel, data: {}[channel])
    lcm.publish("A", b"x")
    with pytest.raises(KeyError):
        lcm.handle()


ROUND_TRIP = """
import select
import lcm as pypi
from gprodom.lcm import binding as lcm_ctypes

url = "udpm://239.255.76.67:7667?ttl=0"
ends = {"pypi": pypi.LCM(url), "ctypes": lcm_ctypes.LCM(url)}
for name, end in ends.items():
    got = []
    subscription = end.subscribe("X.*", lambda channel, data: got.append((channel, bytes(data))))
    subscription.set_queue_capacity(100)
    assert end.handle_timeout(0) == 0
    sent = [(f"X{i}", bytes([i]) * (1 + 4000 * i)) for i in range(20)]
    for sender in ends.values():
        got.clear()
        for message in sent:
            sender.publish(*message)
            assert select.select([end.fileno()], [], [], 5)[0]
            assert end.handle_timeout(5000) > 0
        assert got == sent
    end.unsubscribe(subscription)
print("round trips done")
"""


def test_udp_round_trip_between_both() -> None:
    result = run_isolated(ROUND_TRIP)
    assert result.stdout == "round trips done\n", result.stderr


@pytest.mark.parametrize("choice", ["pypi", "ctypes"])
def test_choice_by_environment(choice: str) -> None:
    code = "from gprodom.lcm import SOURCE; print(SOURCE)"
    assert run_program(sys.executable, "-c", code, GPRODOM_LCM=choice).stdout == f"{choice}\n"
