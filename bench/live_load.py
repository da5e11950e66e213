#!/usr/bin/env python3
"""Cost and latency of gprodomd, live.

A log is played at the speed it was recorded (--speed) to a daemon in a network namespace of its
own. Printed are the peak of resident memory (VmHWM, shared libraries included), the processor
time, user and system, as a share of one core while the log played, and what the daemon itself
counts: from the arrival of an IMU message to its ODOMETRY being out, from the last trace of a radar
tick to its measurement being ready, the longest queues, and messages lost inside; and what the
host of a virtual machine took from it, which no program can make up for. --busy keeps as many
processes computing meanwhile.

Exit code 1 where memory or processor time is over its limit, or something was lost inside.

    bench/live_load.py IN.lcmlog
    bench/live_load.py IN.lcmlog --busy 2
    bench/live_load.py IN.lcmlog --speed 10 --max-core 100
    bench/live_load.py IN.lcmlog -c config/paper.yaml --seconds 30 --json
"""

from __future__ import annotations

import argparse
import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

from gprodom.errors import Error
from gprodom.files import temporary_folder
from gprodom.lcm import LCM
from gprodom.lcm.messages import message
from gprodom.options import add_config_options
from own_network import URL, parse_inside, start_daemon
from processes import memory_mb, processor_seconds
from program import exit_with, list_of, parser_of, print_figures
from zips import log_of

COUNTED = ("latency.imu", "latency.radar", "queue.input.longest", "queue.output.longest")
LOST = "dropped"  # in the name of each count of messages lost inside


def stolen_seconds() -> float:
    """Processor time that this machine's host has taken from it so far, all cores."""
    fields = Path("/proc/stat").read_text().splitlines()[0].split()
    return int(fields[8]) / os.sysconf("SC_CLK_TCK")


class Told:
    """What the daemon says of itself, second by second."""

    def __init__(self) -> None:
        self.poses = 0
        self.series: list[dict[str, float]] = []

    def count(self, channel: str, data: bytes) -> None:
        """Takes an ODOMETRY."""
        self.poses += 1

    def take(self, channel: str, data: bytes) -> None:
        """Takes a STATUS."""
        status = message("status_t").decode(data)
        values = dict(zip(status.names, status.values, strict=True))
        self.series.append({"utime": status.utime, **values})

    def figures(self) -> dict[str, Any]:
        """The newest counts; of queues the longest of all."""
        last = self.series[-1] if self.series else {}
        counted = {name: value for name, value in last.items() if name.startswith(COUNTED)}
        for name in [name for name in counted if name.startswith("queue.")]:
            counted[name] = max(row.get(name, 0.0) for row in self.series)
        lost = sum(
            value
            for name, value in last.items()
            if LOST in name and name != "displacements.dropped"  # those the window cannot use
        )
        return {"poses": self.poses, "lost": lost, **counted}


def measure(log: Path, args: argparse.Namespace) -> Any:
    """Plays `log` to a daemon, for --seconds at most; the figures by name."""
    told = Told()
    lcm = LCM(URL + "&recv_buf_size=4194304")
    lcm.subscribe("ODOMETRY", told.count).set_queue_capacity(10000)
    lcm.subscribe("STATUS", told.take).set_queue_capacity(100)
    daemon = start_daemon(args.configs, Path(os.devnull), args.overrides)
    player = None
    try:
        time.sleep(1.0)  # the daemon listens
        if daemon.poll() is not None:
            raise Error("gprodomd ended at once")
        play = ["/usr/bin/lcm-logplayer", f"--speed={args.speed}", f"--lcm-url={URL}", str(log)]
        begun, spent = time.monotonic(), processor_seconds(daemon.pid)
        stolen = stolen_seconds()
        player = subprocess.Popen(play, stdout=subprocess.DEVNULL)
        while player.poll() is None and time.monotonic() < begun + args.seconds:
            lcm.handle_timeout(100)
        elapsed = time.monotonic() - begun
        return {
            "seconds": elapsed,
            **told.figures(),
            "memory_mb": memory_mb(daemon.pid, "VmHWM"),
            "core_percent": 100 * (processor_seconds(daemon.pid) - spent) / elapsed,
            "stolen_percent": 100 * (stolen_seconds() - stolen) / elapsed,
        }
    finally:
        for process in (player, daemon):
            if process is not None and process.poll() is None:
                process.send_signal(signal.SIGTERM)
                process.wait(10)


def main() -> int:
    """Runs the command line, in a network namespace."""
    parser = parser_of(__doc__)
    parser.add_argument("log", type=Path, metavar="IN", help="log or zip")
    add_config_options(parser)
    parser.add_argument("--seconds", type=float, default=60.0, help="at most (default: 60)")
    parser.add_argument("--speed", type=float, default=1.0, help="times real time (default: 1)")
    parser.add_argument("--max-memory", type=float, default=60.0, metavar="MB")
    parser.add_argument("--max-core", type=float, default=5.0, metavar="PERCENT")
    parser.add_argument("--busy", type=int, default=0, metavar="N", help="processes that compute")
    args = parse_inside(parser)
    compute = [sys.executable, "-c", "while True: pass"]
    others = [subprocess.Popen(compute) for _ in range(args.busy)]
    try:
        with temporary_folder() as folder:
            figures = measure(log_of(args.log, folder), args)
    finally:
        for process in others:
            process.kill()
            process.wait()
    print_figures(args, figures, list_of(figures))
    within = figures["memory_mb"] < args.max_memory and figures["core_percent"] < args.max_core
    return 0 if within and figures["poses"] > 0 and figures["lost"] == 0 else 1


if __name__ == "__main__":
    exit_with(main)
