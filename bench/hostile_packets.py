#!/usr/bin/env python3
"""A million hostile packets beside a robot's real ones, live: does the daemon hold?

A log is played to gprodomd in a network namespace of its own, at --speed times real time, with
--packets packets between its messages that no daemon should believe: counts that are negative or
huge, packets cut short or with bytes left over, of another type, of random bytes, with values that
are not finite or cannot be, stamps from another age, commands that do not exist, and datagrams that
are no LCM at all. Afterwards the poses published are compared with those of a replay of the log
alone: they must be the same. Printed are what STATUS counted, the poses, and the daemon's resident
memory after the first tenth, half of the packets and all. Exit code 1 where the daemon ended, poses
differ, packets went uncounted or memory grew by more than --max-growth after the tenth.

    bench/hostile_packets.py IN.lcmlog
    bench/hostile_packets.py IN.lcmlog --packets 20000 --speed 10 --json
"""

from __future__ import annotations

import argparse
import math
import socket
import struct
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from gprodom.config import Configs
from gprodom.console import Progress
from gprodom.errors import Error
from gprodom.files import temporary_folder
from gprodom.lcm import LCM, logs
from gprodom.lcm.messages import fingerprint, message
from gprodom.odometry.replay import run_replay
from gprodom.options import add_config_option
from log_events import read_events
from own_network import GROUP, PORT, URL, Heard, in_time, parse_inside, start_daemon
from processes import memory_mb
from program import exit_with, list_of, parser_of, print_figures, told_wrong
from zips import log_of

VARIANTS = 4000  # different packets, sent again and again
FOREIGN_SHARE = 0.02  # of the packets are datagrams that are no LCM
NOT_FINITE = [math.nan, math.inf, -math.inf]
CHANNELS = {
    "IMU": "imu_t",
    "WHEEL": "wheel_t",
    "WHEELS": "wheels_t",
    "GPR_TRACE": "gpr_trace_t",
    "GPR_DISPLACEMENT_IN": "displacement_t",
    "POSITION_FIX": "position_fix_t",
    "COMMAND": "command_t",
}
BAD_VALUES = [*NOT_FINITE, 1e300, -1e18]


def valid(channel: str, utime: int, rng: np.random.Generator) -> Any:
    """A message that would be taken."""
    m = message(CHANNELS[channel])()
    m.utime = utime
    if channel == "IMU":
        m.linear_acceleration = [0.0, 0.0, 9.8]
    elif channel == "WHEEL":
        m.ticks, m.metres_per_tick = 1, 1e-3
    elif channel == "WHEELS":
        m.left_ticks, m.right_ticks, m.metres_per_tick = 1, 1, 1e-3
    elif channel == "GPR_TRACE":
        m.sample_interval = 2e-10
        m.num_samples = 201
        m.samples = rng.integers(-9000, 9000, 201).tolist()
    elif channel == "GPR_DISPLACEMENT_IN":
        m.source, m.kind, m.valid = "learned", 3, True
        m.utime_from, m.utime_to = utime - 200_000, utime
        m.distance, m.sigma, m.scale, m.score = 0.05, 0.01, 1.0, 0.9
    elif channel == "POSITION_FIX":
        m.quality, m.position, m.covariance = 3, [1.0, 2.0, 0.0], np.eye(3).ravel().tolist()
    else:
        m.name, m.argument = "dance", ""
    return m


def count_offset(channel: str) -> int:
    """Where a packet's count or first string length stands; -1: it has none."""
    return {"GPR_TRACE": 52, "GPR_DISPLACEMENT_IN": 32, "COMMAND": 16}.get(channel, -1)


def malformed(channel: str, rng: np.random.Generator, utime: int) -> bytes:
    """A packet whose bytes do not make a message of the channel's type."""
    data = bytearray(valid(channel, utime, rng).encode())
    kind = rng.integers(0, 5)
    at = count_offset(channel)
    if kind == 0 and at >= 0:
        counts = [-1, -(2**31), 2**31 - 1, 1 << 30, 65537, 70_000, len(data)]
        data[at : at + 4] = struct.pack(">i", int(rng.choice(counts)))
    elif kind <= 1:
        del data[rng.integers(0, len(data)) :]
    elif kind == 2:
        data += rng.bytes(int(rng.integers(1, 2000)))
    elif kind == 3:
        other = str(rng.choice([name for name in CHANNELS if name != channel]))
        data[:8] = fingerprint(CHANNELS[other])
    else:
        data = bytearray(rng.bytes(int(rng.integers(0, 3000))))
    return bytes(data)


def impossible(channel: str, rng: np.random.Generator, utime: int) -> bytes:
    """A well-formed message whose values cannot be."""
    m = valid(channel, utime, rng)
    bad = BAD_VALUES[rng.integers(0, len(BAD_VALUES))]
    if rng.random() < 0.2:  # a stamp from another age
        m.utime = int(rng.choice([-1, 0, 1, -(2**63), 2**63 - 1]))
    elif channel == "IMU":
        field = m.linear_acceleration if rng.random() < 0.5 else m.angular_velocity
        field[rng.integers(0, 3)] = bad
    elif channel in ("WHEEL", "WHEELS"):
        m.metres_per_tick = bad
    elif channel == "GPR_TRACE":
        which = rng.integers(0, 3)
        if which == 0:
            m.sample_interval = float(rng.choice([bad, 0.0, -1e-10, 1e-300, 1e-18, 1e-7, 1.0]))
        elif which == 1:
            m.time_zero = float(rng.choice(NOT_FINITE))
        else:
            m.num_samples = int(rng.integers(0, 16))
            m.samples = m.samples[: m.num_samples]
    elif channel == "GPR_DISPLACEMENT_IN":
        m.kind = int(rng.choice([2, 3]))
        name = str(rng.choice(["distance", "sigma", "lateral", "lateral_sigma", "scale", "score"]))
        setattr(m, name, float(rng.choice(NOT_FINITE)))
    elif channel == "POSITION_FIX":
        field = m.position if rng.random() < 0.5 else m.covariance
        field[rng.integers(0, 3)] = float(rng.choice(NOT_FINITE))
    return bytes(m.encode())


def foreign(rng: np.random.Generator) -> bytes:
    """A datagram that is no LCM, or whose header and fragments lie."""
    size = int(rng.integers(0, 1400))
    kind = rng.integers(0, 3)
    if kind == 0:
        return rng.bytes(size)
    if kind == 1:  # a short message without the end of its channel's name
        return struct.pack(">II", 0x4C433032, 7) + b"A" * size
    sizes = [0, 1, 2**32 - 1, 2**31, 1 << 20, 100]
    header = [int(rng.choice(sizes)), int(rng.choice(sizes)), *rng.integers(0, 65536, 2).tolist()]
    return struct.pack(">IIIIHH", 0x4C433033, 7, *header) + b"IMU\0" + rng.bytes(size)


def hostile(seed: int, utime: int) -> list[tuple[str, bytes]]:
    """Packets by channel; an empty channel: a datagram for the socket itself."""
    rng = np.random.default_rng(seed)
    packets = []
    for _ in range(VARIANTS):
        channel = str(rng.choice(list(CHANNELS)))
        make = malformed if rng.random() < 0.6 else impossible
        if rng.random() < FOREIGN_SHARE:
            packets.append(("", foreign(rng)))
        else:
            packets.append((channel, make(channel, rng, utime)))
    return packets


def receive(heard: Heard, wait_ms: int = 0) -> None:
    """Takes what has come."""
    while heard.lcm.handle_timeout(wait_ms):
        pass


class Attack:
    """Plays a log with hostile packets between its messages."""

    def __init__(self, log: Path, packets: int, speed: float, seed: int) -> None:
        self.events = [event for event in read_events(log) if event[1] in CHANNELS]
        if not self.events:
            raise Error(f"{log}: no messages of {', '.join(CHANNELS)}")
        self.packets, self.speed = packets, speed
        self.hostile = hostile(seed, self.events[len(self.events) // 2][0])
        self.sender = LCM(URL)
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.sent = self.foreign = 0

    def send_hostile(self, until: int) -> None:
        """Sends hostile packets until so many are sent."""
        while self.sent < until:
            channel, data = self.hostile[self.sent % len(self.hostile)]
            if channel:
                self.sender.publish(channel, data)
            else:
                self.socket.sendto(data, (GROUP, PORT))
                self.foreign += 1
            self.sent += 1

    def run(self, heard: Heard, alive: Callable[[int], None]) -> None:
        """`alive` is told the packets sent, now and then."""
        paced = in_time(self.events, self.speed, lambda _: receive(heard, 1))
        for i, (_, channel, data) in enumerate(paced):
            self.send_hostile(self.packets * (i + 1) // len(self.events))
            self.sender.publish(channel, data)
            receive(heard)
            if i % 200 == 0:
                alive(self.sent)


def apart(replayed: Path, poses: dict[int, tuple[float, ...]]) -> tuple[int, int, float]:
    """Poses of the replay, how many of them came live, and the largest distance between both."""
    odometry = logs.read(replayed, ["ODOMETRY"])["ODOMETRY"]
    stamps = odometry["utime"].tolist()
    both = [
        math.dist(poses[stamp], position)
        for stamp, position in zip(stamps, odometry["position"].tolist(), strict=True)
        if stamp in poses
    ]
    return len(stamps), len(both), max(both, default=math.inf)


def measure(
    log: Path, configs: Configs, packets: int, speed: float, seed: int, folder: Path
) -> dict[str, Any]:
    """The figures by name."""
    attack, heard = Attack(log, packets, speed, seed), Heard()
    daemon_log = folder / "daemon.log"
    daemon = start_daemon(configs, daemon_log)
    memory: list[float] = []
    try:
        time.sleep(1.0)  # the daemon listens
        with Progress("packets", packets) as progress:

            def alive(sent: int) -> None:
                if daemon.poll() is not None:
                    raise Error(f"gprodomd ended ({daemon.returncode}):\n{daemon_log.read_text()}")
                memory.append(memory_mb(daemon.pid, "VmRSS"))
                progress.update(sent)

            attack.run(heard, alive)
            receive(heard, 1500)
            alive(attack.sent)
            daemon.terminate()
            receive(heard, 1000)  # the last status
    finally:
        if daemon.poll() is None:
            daemon.terminate()
            daemon.wait(20)
    code = daemon.returncode
    run_replay(log, folder / "replay.lcmlog", configs)
    live = {utime: position for _, utime, position in heard.poses}
    poses, both, distance_m = apart(folder / "replay.lcmlog", live)
    counted = {
        name: value
        for m in heard.statuses
        for name, value in zip(m.names, m.values, strict=True)
        if name.split(": ")[0] in (*CHANNELS, "input queue")
    }
    return {
        "packets": attack.sent,
        "datagrams": attack.foreign,
        "counted": int(sum(counted.values())),
        "reasons": dict(sorted(counted.items())),
        "exit_code": code,
        "poses": poses,
        "poses_live": both,
        "apart_m": distance_m,
        "memory_tenth_mb": memory[len(memory) // 10],
        "memory_half_mb": memory[len(memory) // 2],
        "memory_end_mb": memory[-1],
    }


def verdict(figures: dict[str, Any], max_growth_mb: float) -> list[str]:
    """What is not as it should be."""
    asked = figures["packets"] - figures["datagrams"]
    alike = figures["poses_live"] >= 0.999 * figures["poses"] and figures["apart_m"] <= 1e-6
    growth_mb = figures["memory_end_mb"] - figures["memory_tenth_mb"]
    checks = {
        f"gprodomd ended with {figures['exit_code']}": figures["exit_code"] == 0,
        "the poses are not those of the log alone": alike,
        f"STATUS counted {figures['counted']} of {asked}": figures["counted"] >= 0.995 * asked,
        "memory grew": growth_mb <= max_growth_mb,
    }
    return [what for what, held in checks.items() if not held]


def parse() -> argparse.Namespace:
    """The command line; from here on in a network namespace."""
    parser = parser_of(__doc__)
    parser.add_argument("log", type=Path, metavar="IN", help="log or zip")
    add_config_option(parser)
    parser.add_argument("--packets", type=int, default=1_000_000, help="default: 1000000")
    parser.add_argument("--speed", type=float, default=2.0, help="times real time (default: 2)")
    parser.add_argument("--seed", type=int, default=1, help="default: 1")
    parser.add_argument("--max-growth", type=float, default=5.0, metavar="MB", help="default: 5")
    return parse_inside(parser)


def main() -> int:
    """Runs the command line."""
    args = parse()
    with temporary_folder() as folder:
        log = log_of(args.log, folder)
        figures = measure(log, args.configs, args.packets, args.speed, args.seed, folder)
    wrong = verdict(figures, args.max_growth)
    shown = {**figures, "reasons": "", **figures["reasons"]}
    print_figures(args, {**figures, "wrong": wrong}, list_of(shown))
    return told_wrong(wrong)


if __name__ == "__main__":
    exit_with(main)
