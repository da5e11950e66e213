"""A network of the bench's own for live runs: nothing reaches a network card."""

from __future__ import annotations

import argparse
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

from gprodom.config import Configs, config_arguments
from gprodom.lcm import LCM
from gprodom.lcm.messages import message
from gprodom.odometry.replay import find_program
from log_events import Message

GROUP, PORT = "239.255.76.67", 7667
URL = f"udpm://{GROUP}:{PORT}?ttl=0"
_LOOPBACK = 'ip link set lo up && ip route add 224.0.0.0/4 dev lo && exec "$@"'


def parse_inside(parser: argparse.ArgumentParser, *, mounts: bool = False) -> argparse.Namespace:
    """Parses the command line and starts the program again in namespaces of its own.

    That of the network, in which multicast goes to the loopback alone, and with `mounts` that of
    the file systems. Returns inside them; other users than root are root there.
    """
    parser.add_argument("--inside", action="store_true", help=argparse.SUPPRESS)
    args = parser.parse_args()
    if not args.inside:
        rights = ("-n" if os.geteuid() == 0 else "-rn") + ("m" if mounts else "")
        again = [sys.executable, sys.argv[0], *sys.argv[1:], "--inside"]
        os.execvp("unshare", ["unshare", rights, "sh", "-c", _LOOPBACK, "sh", *again])
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))  # so that what was started ends, too
    return args


class Heard:
    """What a daemon publishes in this network: of each pose when it came (s), its stamp (us) and
    position (m), and each STATUS."""

    def __init__(self) -> None:
        self.lcm = LCM(URL + "&recv_buf_size=8388608")
        self.poses: list[tuple[float, int, tuple[float, ...]]] = []
        self.statuses: list[Any] = []
        for channel, take in (("ODOMETRY", self._pose), ("STATUS", self._status)):
            self.lcm.subscribe(channel, take).set_queue_capacity(0)

    def _pose(self, _: str, data: bytes) -> None:
        m = message("odometry_t").decode(data)
        self.poses.append((time.monotonic(), m.utime, m.position))

    def _status(self, _: str, data: bytes) -> None:
        self.statuses.append(message("status_t").decode(data))


def start_daemon(
    configs: Configs, said: Path, overrides: Sequence[str] = ()
) -> subprocess.Popen[bytes]:
    """gprodomd in this network. said: a file to which its standard error is added."""
    command = [str(find_program("gprodomd")), *config_arguments(configs), "--lcm-url", URL]
    for override in overrides:
        command += ["--set", override]
    with open(said, "a") as file:
        return subprocess.Popen(command, stderr=file)


def in_time(
    events: Sequence[Message], speed: float = 1.0, wait: Callable[[float], object] = time.sleep
) -> Iterator[Message]:
    """The events, each at its time, at so many times real time. wait: is given the seconds that are
    left, and may return sooner."""
    begun, first = time.monotonic(), events[0][0]
    for event in events:
        while (ahead := (event[0] - first) * 1e-6 / speed - (time.monotonic() - begun)) > 0:
            wait(ahead)
        yield event
