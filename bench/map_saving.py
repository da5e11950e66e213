#!/usr/bin/env python3
"""What it costs to save the ground: bytes written, by file of state.directory, and processor time.

Each LOG is replayed with a folder for its state, going on from the one before, under strace, which
counts what is written to each file; and --repeats times without strace, with that folder and
without one, for the processor time of all threads (the least counts). Printed for each log: its
seconds of data and the length of the map at its end, bytes written for ground.map (the whole
ground), ground.new (what is new of it) and the other files, each a second of data, and the
processor time that the folder takes, as a share of the time without one.

    bench/map_saving.py LOG.lcmlog... [--save-period S] [--repeats N] [--json]

Needs strace.
"""

from __future__ import annotations

import argparse
import re
import shutil
import subprocess
from collections import Counter
from pathlib import Path
from typing import Any

from gprodom.files import temporary_folder
from gprodom.map.ground import read_map
from gprodom.odometry.replay import find_program
from log_events import read_events
from processes import children_seconds
from program import exit_with, parser_of, print_rows

WRITE = re.compile(r"^\d+ +writev?\(\d+<([^>]*)>.* = (\d+)$", re.M)
FILES = ("ground.map", "ground.new")


def command(
    log: Path, config: Path, output: Path, state: Path | None, period_s: float
) -> list[str]:
    """A replay. state: its folder, if any."""
    settings = ["--set", f"state.save_period={period_s}", "--set", "state.resume_within=0"]
    if state:
        settings += ["--set", f"state.directory={state}"]
    return [str(find_program("gprodom-replay")), "-c", str(config), *settings, str(log),
            "-o", str(output)]  # fmt: skip


def processor_s(arguments: list[str]) -> float:
    """Of a process, all threads."""
    before = children_seconds()
    subprocess.run(arguments, check=True, capture_output=True)
    return children_seconds() - before


def written(arguments: list[str], state: Path, calls: Path) -> Counter[str]:
    """Bytes by file of the folder; those of temporary files count as of the files they become."""
    strace = ["strace", "-f", "-y", "-s", "0", "-e", "trace=write,writev", "-e", "signal=none"]
    subprocess.run([*strace, "-o", str(calls), *arguments], check=True, capture_output=True)
    total: Counter[str] = Counter()
    for path, count in WRITE.findall(calls.read_text()):
        if Path(path).parent == state:
            total[re.sub(r"\.\d+\.part$", "", Path(path).name)] += int(count)
    return total


def measure(log: Path, state: Path, folder: Path, args: argparse.Namespace) -> dict[str, Any]:
    """The figures of one log. state: goes on from the log before."""
    output = folder / "out.lcmlog"
    events = read_events(log)
    seconds = (events[-1][0] - events[0][0]) * 1e-6
    times: dict[bool, float] = {}
    for keeps in (False, True):
        for _ in range(args.repeats):
            again = folder / "again"
            shutil.rmtree(again, ignore_errors=True)
            shutil.copytree(state, again)
            run = command(log, args.config, output, again if keeps else None, args.save_period)
            times[keeps] = min(processor_s(run), times.get(keeps, float("inf")))
    run = command(log, args.config, output, state, args.save_period)
    total = written(run, state, folder / "calls")
    rates = {f"{name} (B/s)": round(total.pop(name, 0) / seconds) for name in FILES}
    return {
        "log": log.stem,
        "data_s": round(seconds, 1),
        "map_m": round(read_map(state / "ground.map").length_m, 1),
        **rates,
        "others (B/s)": round(sum(total.values()) / seconds),
        "processor_share": round(times[True] / times[False] - 1, 4),
    }


def main() -> None:
    """Runs the command line."""
    parser = parser_of(__doc__)
    parser.add_argument("logs", nargs="+", type=Path, metavar="LOG")
    parser.add_argument(
        "-c", "--config", type=Path, metavar="CONFIG",
        default=Path(__file__).resolve().parents[1] / "config" / "gprodom.yaml",
        help="default: %(default)s",
    )  # fmt: skip
    parser.add_argument("--save-period", type=float, default=1.0, metavar="S", help="default: 1")
    parser.add_argument("--repeats", type=int, default=3, metavar="N", help="default: 3")
    args = parser.parse_args()
    with temporary_folder() as folder:
        state = folder / "state"
        state.mkdir()
        found = [measure(log, state, folder, args) for log in args.logs]
    print_rows(args, found)


if __name__ == "__main__":
    exit_with(main)
