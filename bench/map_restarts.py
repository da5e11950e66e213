#!/usr/bin/env python3
"""The map of before is there and has grown, however often gprodomd is told to start anew.

As map_faults.py, live: in a network of its own, gprodomd drives on from the map of a first drive
over other ground, at ten times real time, and gets SIGHUP with a change that restarts its
estimator (wheel.max_speed) at --moments random moments, five in each drive. After each drive
ground.map must be sound, have all ground of before, and nothing must have been set aside; at the
end it must have grown. Exit code 1 where it is not so.

With --errors FOLDER (of the built tests) the live estimator also fails by an exception at so many
random moments: that is test_live, told by GPRODOM_MOMENTS.

    bench/map_restarts.py --moments 200 --errors build/test --json
"""

from __future__ import annotations

import argparse
import os
import random
import shutil
import signal
import subprocess
import time
from pathlib import Path
from typing import Any

from gprodom.files import temporary_folder
from gprodom.lcm import LCM
from gprodom.map.ground import read_map
from gprodom.odometry.replay import run_replay
from log_events import read_events
from map_faults import fault_of
from own_network import URL, in_time, parse_inside, start_daemon
from program import command, exit_with, parser_of, print_figures, table_of

SPEED = 10.0  # times real time
IN_EACH = 5  # reloads of a drive
PATIENCE_S = 30.0
ERRORS = "Live.GroundOutlastsAnInternalError"


def write_config(folder: Path, state: Path, max_speed: float) -> Path:
    """The daemon's configuration."""
    path = folder / "config.yaml"
    path.write_text(
        f"state: {{directory: {state}, save_period: 0.05}}\nwheel: {{max_speed: {max_speed}}}\n"
    )
    return path


def reloads(log: Path, folder: Path, state: Path, chance: random.Random) -> None:
    """A drive with reloads at random moments."""
    config = write_config(folder, state, 5.0)
    events = read_events(log)
    first, last = events[0][0], events[-1][0]
    moments = sorted(chance.uniform(first, last) for _ in range(IN_EACH))
    lcm = LCM(URL)
    daemon = start_daemon([config], folder / "log")
    deadline = time.monotonic() + PATIENCE_S
    while " runs: " not in (folder / "log").read_text() and time.monotonic() < deadline:
        time.sleep(0.05)
    done = 0
    for stamp, channel, data in in_time(events, SPEED):
        if done < len(moments) and stamp >= moments[done]:
            done += 1
            write_config(folder, state, 5.0 - 0.1 * done)
            daemon.send_signal(signal.SIGHUP)
        lcm.publish(channel, data)
    daemon.terminate()
    if daemon.wait(PATIENCE_S) != 0:
        raise RuntimeError((folder / "log").read_text())


def measure_reloads(moments: int, chance: random.Random, folder: Path) -> dict[str, Any]:
    """SIGHUP at so many moments."""
    logs = []
    for seed in (1, 2):
        logs.append(folder / f"{seed}.lcmlog")
        drive = ["--route", "loop", "--distance", "14", "--seed", str(seed)]
        command("simulate", *drive, "-o", logs[-1])
    before = folder / "before"
    before.mkdir()
    run_replay(logs[0], folder / "out.lcmlog", [write_config(folder, before, 5.0)])
    length_m = read_map(before / "ground.map").length_m
    lost, grown_m = [], 0.0
    for number in range(-(-moments // IN_EACH)):
        state = folder / "state"
        shutil.copytree(before, state)
        reloads(logs[1], folder, state, chance)
        if said := fault_of(state, length_m):
            lost.append(f"drive {number}: {said}")
        else:
            grown_m = max(grown_m, read_map(state / "ground.map").length_m - length_m)
        shutil.rmtree(state)
    if grown_m == 0.0:
        lost.append("the map has never grown")
    return {"fault": "reload", "moments": moments, "kept": moments - len(lost), "lost": lost}


def measure_errors(moments: int, tests: Path) -> dict[str, Any]:
    """Exceptions at so many moments."""
    environment = {**os.environ, "GPRODOM_MOMENTS": str(moments)}
    test = [str(tests / "test_live"), f"--gtest_filter={ERRORS}"]
    done = subprocess.run(test, env=environment, capture_output=True, text=True, check=False)
    passed = done.returncode == 0 and f"[       OK ] {ERRORS}" in done.stdout
    lost = [] if passed else done.stdout.splitlines()[-30:]
    return {"fault": "error", "moments": moments, "kept": moments if passed else 0, "lost": lost}


def parse() -> argparse.Namespace:
    """The command line; from here on in a network namespace of its own."""
    parser = parser_of(__doc__)
    parser.add_argument("--moments", type=int, default=200, metavar="N", help="default: 200")
    parser.add_argument("--errors", type=Path, metavar="FOLDER", help="see above")
    parser.add_argument("--seed", type=int, default=1, help="of the moments (default: 1)")
    return parse_inside(parser)


def main() -> int:
    """Runs the command line."""
    args = parse()
    with temporary_folder() as folder:
        found = [measure_reloads(args.moments, random.Random(args.seed), folder)]
    if args.errors:
        found.append(measure_errors(args.moments, args.errors))
    print_figures(args, {"faults": found}, table_of(found))
    return 1 if any(each["lost"] for each in found) else 0


if __name__ == "__main__":
    exit_with(main)
