#!/usr/bin/env python3
"""What the daemon costs a robot: memory and processor time of gprodomd, live.

A log is played at the speed it was recorded (--speed) to a daemon in a network namespace of its
own. Printed are the peak of resident memory (VmHWM, shared libraries included) and the processor
time, user and system, as a share of one core while the log played. Exit code 1 where either is
over its limit.

    bench/live_load.py IN.lcmlog
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

from gprodom.console import add_json_flag, format_table, print_json
from gprodom.errors import Error
from gprodom.lcm import LCM
from gprodom.replay import default_config, find_program

URL = "udpm://239.255.76.67:7667?ttl=0"
NAMESPACE = 'ip link set lo up && ip route add 224.0.0.0/4 dev lo && exec "$@"'


def peak_memory_mb(pid: int) -> float:
    """Peak resident memory of a process, MB (10^6 bytes)."""
    for line in Path(f"/proc/{pid}/status").read_text().splitlines():
        if line.startswith("VmHWM:"):
            return int(line.split()[1]) * 1024e-6
    raise Error(f"/proc/{pid}/status: no VmHWM")


def processor_seconds(pid: int) -> float:
    """User and system time of a process so far."""
    fields = Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def measure(log: Path, config: Path, overrides: list[str], seconds: float, speed: float) -> Any:
    """Plays `log` to a daemon, for `seconds` at most; the figures by name."""
    command = [str(find_program("gprodomd")), "-c", str(config), "--lcm-url", URL]
    for override in overrides:
        command += ["--set", override]
    poses = 0

    def count(channel: str, data: bytes) -> None:
        nonlocal poses
        poses += 1

    lcm = LCM(URL + "&recv_buf_size=4194304")
    lcm.subscribe("ODOMETRY", count).set_queue_capacity(10000)
    daemon = subprocess.Popen(command, stderr=subprocess.DEVNULL)
    player = None
    try:
        time.sleep(1.0)  # the daemon listens
        if daemon.poll() is not None:
            raise Error(f"gprodomd ended at once: {' '.join(command)}")
        play = [
            "/usr/bin/lcm-logplayer",
            f"--speed={speed}",
            f"--lcm-url={URL}",
            str(log),
        ]
        begun, spent = time.monotonic(), processor_seconds(daemon.pid)
        player = subprocess.Popen(play, stdout=subprocess.DEVNULL)
        while player.poll() is None and time.monotonic() < begun + seconds:
            lcm.handle_timeout(100)
        elapsed = time.monotonic() - begun
        return {
            "seconds": elapsed,
            "poses": poses,
            "memory_mb": peak_memory_mb(daemon.pid),
            "core_percent": 100 * (processor_seconds(daemon.pid) - spent) / elapsed,
        }
    finally:
        for process in (player, daemon):
            if process is not None and process.poll() is None:
                process.send_signal(signal.SIGTERM)
                process.wait(10)


def main() -> int:
    """Runs the command line, in a network namespace."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("log", type=Path, metavar="IN.lcmlog")
    parser.add_argument("-c", "--config", type=Path, help="default: gprodom.yaml")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", dest="overrides")
    parser.add_argument("--seconds", type=float, default=60.0, help="at most (default: 60)")
    parser.add_argument("--speed", type=float, default=1.0, help="times real time (default: 1)")
    parser.add_argument("--max-memory", type=float, default=60.0, metavar="MB")
    parser.add_argument("--max-core", type=float, default=5.0, metavar="PERCENT")
    parser.add_argument("--inside", action="store_true", help=argparse.SUPPRESS)
    add_json_flag(parser)
    args = parser.parse_args()
    if not args.inside:
        again = [sys.executable, __file__, *sys.argv[1:], "--inside"]
        os.execvp(
            "unshare",
            ["unshare", "-n" if os.geteuid() == 0 else "-rn", "sh", "-c", NAMESPACE, "sh", *again],
        )
    try:
        if not args.log.is_file():
            raise Error(f"{args.log}: no such log")
        config = args.config or default_config()
        figures = measure(args.log, config, args.overrides, args.seconds, args.speed)
    except Error as error:
        print(f"live_load: error: {error}", file=sys.stderr)
        return 1
    if args.json:
        print_json(figures)
    else:
        rows = [
            ["resident memory, peak, MB", figures["memory_mb"], args.max_memory],
            ["processor, % of a core", figures["core_percent"], args.max_core],
        ]
        print(f"{figures['seconds']:.1f} s live, {figures['poses']} poses")
        print(format_table(["", "measured", "limit"], rows))
    within = figures["memory_mb"] < args.max_memory and figures["core_percent"] < args.max_core
    return 0 if within and figures["poses"] > 0 else 1


if __name__ == "__main__":
    sys.exit(main())
