#!/usr/bin/env python3
"""The ROS 2 node, live, from and to a program on Fast DDS: latency and losses.

A log is played at --speed times real time to gprodom_ros2 in a network namespace of its own,
again and again (stamped on) until --seconds are played, and its poses are taken. Printed are the
time from an IMU message's being written by its publisher to its pose's being read by a
subscriber, both on Fast DDS; poses that did not come; messages that the node knows to be lost;
and what the node itself counts from the arrival of an IMU message to its pose being out. The node
and its peer are built first if they are not there (scripts/check-ros2 --build). Exit code 1 where a
pose did not come or, with reliable sensors, a message was lost.

    bench/ros2_live.py SEQ|LOG
    bench/ros2_live.py SEQ|LOG --seconds 600 --best-effort --json
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from gprodom.config import Configs, config_arguments
from gprodom.errors import Error
from gprodom.files import temporary_folder
from gprodom.options import add_config_option
from own_network import parse_inside
from zips import log_of

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "test" / "ros2"))
import kit

from program import exit_with, list_of, parser_of, print_figures

PERCENTILES = (50, 99, 100)
PAUSE_NS = 50_000_000  # between the end of the log and its start again


def repeated(plan: list[kit.Record], seconds: float, speed: float) -> list[kit.Record]:
    """The plan again and again, stamped on; the wheel's distance begins anew each time."""
    last_ns = plan[-1].at_ns + PAUSE_NS
    rounds = max(1, round(seconds * 1e9 / last_ns))
    records = []
    for i in range(rounds):
        shift_us = int(i * last_ns * speed) // 1000
        for r in plan:
            cdr = r.cdr
            if i > 0:
                m = r.value()
                m.header = kit.header(kit.utime_of(m.header.stamp) + shift_us, m.header.frame_id)
                cdr = kit.to_cdr(r.kind, m)
            records.append(replace(r, at_ns=r.at_ns + i * last_ns, cdr=cdr))
    return records


def latencies_ms(plan: list[kit.Record], records: list[kit.Record]) -> np.ndarray:
    """From IMU message written to pose read."""
    sent = [r for r in records if not r.raw and r.topic == "/imu/data"]
    stamps = [kit.utime_of(r.value().header.stamp) for r in plan if r.topic == "/imu/data"]
    sent_ns = dict(zip(stamps, (r.at_ns for r in sent), strict=True))
    poses = [r for r in records if r.raw and r.topic == "/odometry"]
    taken_ns = {kit.utime_of(r.value().header.stamp): r.at_ns for r in poses}
    begun = min(taken_ns)
    missing = sum(stamp >= begun and stamp not in taken_ns for stamp in stamps)
    late = np.array([taken_ns[s] - sent_ns[s] for s in taken_ns]) * 1e-6
    return np.concatenate([late, np.full(missing, np.inf)])


def measure(log: Path, configs: Configs, args: argparse.Namespace, folder: Path) -> dict[str, Any]:
    """The figures by name."""
    plan = repeated(kit.plan_of(log_of(log, folder), args.speed), args.seconds, args.speed)
    reliable = str(not args.best_effort).lower()
    topics = {"/odometry": (kit.ODOMETRY, "r"), "/diagnostics": (kit.DIAGNOSTICS, "r")}
    with kit.Node(folder, *config_arguments(configs), "-p", f"sensors_reliable:={reliable}"):
        peer = kit.Peer(folder, "robot", plan, topics, "--quiet-s", "3").matched().sent()
        time.sleep(2.0)
    records = peer.end()
    late = latencies_ms(plan, records)
    said = kit.received(records, "/diagnostics")
    link, own = (kit.values_of(said, f"gprodom: {name}") for name in ("ROS 2", "odometry"))
    came = late[np.isfinite(late)]
    return {
        "seconds": round(plan[-1].at_ns * 1e-9, 1),
        "messages": len(plan),
        "poses": len(came),
        "poses_missing": len(late) - len(came),
        **{f"latency_p{p}_ms": float(np.percentile(came, p)) for p in PERCENTILES},
        "lost": sum(v for name, v in link.items() if name.endswith(": lost")),
        "poses_not_sent": link.get("poses not sent"),
        **{name: v for name, v in own.items() if name.startswith("latency.imu")},
    }


def main() -> int:
    """Runs the command line."""
    parser = parser_of(__doc__)
    parser.add_argument("log", type=Path, metavar="SEQ|LOG", help="drive")
    add_config_option(parser)
    parser.add_argument("--seconds", type=float, default=0, help="default: the log once")
    parser.add_argument("--speed", type=float, default=1.0, help="times real time (default: 1)")
    parser.add_argument("--best-effort", action="store_true", help="sensors are best effort")
    args = parse_inside(parser)
    if not any(path.is_file() for path in (kit.BIN / "peer", kit.NO_PEER)):
        build = [str(kit.CHECKOUT / "scripts" / "check-ros2"), "--build"]
        if subprocess.run(build, stdout=sys.stderr).returncode != 0:
            raise Error("the ROS 2 node and its peer could not be built (see above)")
    if kit.NO_PEER.is_file():
        print(kit.NO_PEER.read_text(), file=sys.stderr)
        return 3
    with temporary_folder() as folder:
        figures = measure(args.log, args.configs, args, folder)
    print_figures(args, figures, list_of(figures))
    lost = figures["poses_missing"] or (figures["lost"] and not args.best_effort)
    return 1 if lost else 0


if __name__ == "__main__":
    exit_with(main)
