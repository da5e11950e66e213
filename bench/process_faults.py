#!/usr/bin/env python3
"""How a live gprodomd behaves when its process, its disk or a listener fails.

The first --seconds of a log are played to gprodomd at real time, in a network namespace of its
own, once for each fault: stopped for 5 s (SIGSTOP); killed (SIGKILL) and started again at once; the
state's folder on a full file system, and on one that cannot be written; standard error on a full
one; a listener that has stopped. Printed for each: whether the daemon held, seconds from its end
to the next pose, the longest silence (s of data), how far the way from the last pose before the
fault to the first after it is from a replay's without faults, and what STATUS or the log said.
Exit code 1 where a daemon ended, was silent about a fault, a pose was earlier than the one before,
or a killed daemon took more than 2 s.

    bench/process_faults.py IN.lcmlog          as root: it mounts small file systems
"""

from __future__ import annotations

import argparse
import math
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path
from typing import Any

from gprodom.config import Configs
from gprodom.files import temporary_folder
from gprodom.lcm import LCM, logs
from gprodom.odometry.replay import run_replay
from gprodom.options import add_config_option
from hostile_packets import CHANNELS
from log_events import Message, read_events
from own_network import URL, Heard, in_time, parse_inside, start_daemon
from program import exit_with, parser_of, print_figures, table_of, told_wrong
from zips import log_of

FAULT_AT = 0.6  # of the time played
PAUSE_S = 5.0
LONG_QUEUE = 100  # messages
LIMIT_S = 2.0  # from a restart to a pose


@dataclass
class Run:
    """One run's daemon and what was heard of it."""

    folder: Path
    configs: Configs
    stderr: Path
    process: subprocess.Popen[bytes] | None = None
    heard: Heard = field(default_factory=Heard)

    def start(self) -> None:
        """Starts the daemon, with its state in folder/state."""
        state = f"state.directory={self.folder / 'state'}"
        self.process = start_daemon(self.configs, self.stderr, [state])

    def signal(self, which: signal.Signals) -> None:
        """Sends the daemon a signal."""
        assert self.process is not None
        self.process.send_signal(which)

    def said(self) -> set[str]:
        """By STATUS: reasons, counted events, and a queue that was long."""
        said: set[str] = set()
        for m in self.heard.statuses:
            values = dict(zip(m.names, m.values, strict=True))
            said.update(m.reasons, (name for name in values if ": " in name))
            if values.get("queue.input.longest", 0.0) > LONG_QUEUE:
                said.add(f"queue.input.longest above {LONG_QUEUE}")
        return said


@dataclass(frozen=True)
class Fault:
    """prepare: before the daemon starts. strike: at the fault's time. mend: `seconds` later."""

    name: str
    prepare: Callable[[Run], None] = lambda run: None
    strike: Callable[[Run], None] = lambda run: None
    mend: Callable[[Run], None] = lambda run: None
    seconds: float = 0.0
    told: str = ""  # STATUS or the log says this


def mounted(folder: Path, options: str) -> None:
    """A small file system in memory, gone with the namespace."""
    folder.mkdir(exist_ok=True)
    subprocess.run(["mount", "-t", "tmpfs", "-o", options, "none", str(folder)], check=True)


def fill(folder: Path) -> None:
    """Writes until nothing more fits."""
    with open(folder / "filler", "wb", buffering=0) as file:
        try:
            while True:
                file.write(bytes(4096))
        except OSError:
            pass


def full_state(run: Run) -> None:
    """The state's folder on a full file system."""
    mounted(run.folder / "state", "size=64k")
    fill(run.folder / "state")


def full_log(run: Run) -> None:
    """Standard error on a full file system."""
    mounted(run.folder / "log", "size=64k")
    run.stderr = run.folder / "log" / "stderr"
    run.stderr.touch()
    fill(run.folder / "log")


def stopped_listener(run: Run) -> None:
    """Another program that subscribed to everything, and has stopped."""
    program = "from gprodom.lcm import LCM; import time\n"
    program += f"l = LCM({URL!r}); l.subscribe('.*', lambda *_: time.sleep(60)); l.handle()"
    subprocess.Popen([sys.executable, "-c", program])


def kill(run: Run) -> None:
    """SIGKILL, and started again."""
    run.signal(signal.SIGKILL)
    assert run.process is not None
    run.process.wait()
    run.start()


FAULTS = [
    Fault(
        "stopped for 5 s",
        strike=lambda run: run.signal(signal.SIGSTOP),
        mend=lambda run: run.signal(signal.SIGCONT),
        seconds=PAUSE_S,
        told="queue.input.longest",  # the network held what came meanwhile
    ),
    Fault("killed and started again", strike=kill, told="resumed from the pose saved"),
    Fault("disk of the state full", prepare=full_state, told="cannot be written"),
    Fault(
        "folder of the state not writable",
        prepare=lambda run: mounted(run.folder / "state", "size=64k,ro"),
        told="cannot be written",
    ),
    Fault("disk of the log full", prepare=full_log),
    Fault("a listener has stopped", prepare=stopped_listener),
]


def play(events: list[Message], lcm: LCM, at: dict[float, Callable[[], None]]) -> None:
    """Sends the events at real time; calls what is due at a time (s from the first)."""
    due, first = sorted(at.items()), events[0][0]
    for stamp, channel, data in in_time(
        events, wait=lambda left: lcm.handle_timeout(max(1, min(10, round(left * 1e3))))
    ):
        while due and (stamp - first) * 1e-6 >= due[0][0]:
            due.pop(0)[1]()
        lcm.publish(channel, data)
    deadline = time.monotonic() + 1.0
    while time.monotonic() < deadline:
        lcm.handle_timeout(20)


def outcome(run: Run, fault: Fault, ended_at: float, clean: dict[int, Any]) -> dict[str, Any]:
    """The figures of one run."""
    assert run.process is not None
    held = run.process.poll() is None
    run.process.terminate()
    log = run.stderr.read_text() if run.stderr.is_file() else ""
    poses = run.heard.poses
    before = [p for p in poses if p[0] < ended_at - fault.seconds]
    after = [p for p in poses if p[0] >= ended_at]
    both = [p for p in (before[-1:] + after[:1]) if p[1] in clean]
    steps = [b[1] - a[1] for a, b in pairwise(poses)]
    jump = math.nan
    if len(both) == 2:
        ways = [math.dist(both[0][2], both[1][2]), math.dist(clean[both[0][1]], clean[both[1][1]])]
        jump = abs(ways[0] - ways[1])
    told = [text for text in (*sorted(run.said()), *log.splitlines()) if fault.told in text]
    return {
        "fault": fault.name,
        "held": held,
        "pose_after_s": after[0][0] - ended_at if after else math.inf,
        "silent_s": max(steps, default=0) * 1e-6,
        "jump_m": jump,
        "told": (told[0][:100] if told else "") if fault.told else "-",
        "monotone": all(step > 0 for step in steps),
        "poses": len(poses),
    }


def measure(
    fault: Fault, log: Path, seconds: float, configs: Configs, folder: Path
) -> dict[str, Any]:
    """Plays the log with the fault."""
    events = read_events(log)
    events = [e for e in events if e[1] in CHANNELS and e[0] < events[0][0] + seconds * 1e6]
    run_replay(log, folder / "clean.lcmlog", configs)
    odometry = logs.read(folder / "clean.lcmlog", ["ODOMETRY"])["ODOMETRY"]
    clean = dict(zip(odometry["utime"].tolist(), odometry["position"].tolist(), strict=True))
    run = Run(folder, configs, folder / "stderr")
    (folder / "state").mkdir()
    fault.prepare(run)
    run.start()
    time.sleep(1.0)  # the daemon listens
    ended = [math.inf]

    def mend() -> None:
        ended[0] = time.monotonic()
        fault.mend(run)

    def strike() -> None:
        ended[0] = time.monotonic()
        fault.strike(run)

    at = {FAULT_AT * seconds: strike}
    if fault.seconds:
        at[FAULT_AT * seconds + fault.seconds] = mend
    try:
        play(events, run.heard.lcm, at)
        return outcome(run, fault, ended[0], clean)
    finally:
        if run.process is not None and run.process.poll() is None:
            run.process.kill()


def verdict(figures: dict[str, Any]) -> list[str]:
    """What is not as it should be."""
    silence = figures["pose_after_s"]
    checks = {
        "gprodomd ended": figures["held"],
        "a pose was earlier than the one before": figures["monotone"],
        "not told of": figures["told"],
        f"{silence:.1f} s without a pose": "killed" not in figures["fault"] or silence <= LIMIT_S,
    }
    return [f"{figures['fault']}: {what}" for what, held in checks.items() if not held]


def parse() -> argparse.Namespace:
    """The command line; from here on in network and mount namespaces of its own."""
    parser = parser_of(__doc__)
    parser.add_argument("log", type=Path, metavar="IN", help="log or zip")
    add_config_option(parser)
    parser.add_argument("--seconds", type=float, default=40.0, help="of the log (default: 40)")
    return parse_inside(parser, mounts=True)


def by_itself(fault: Fault, log: Path, args: argparse.Namespace) -> dict[str, Any]:
    """The figures of one fault; what it mounted is gone afterwards."""
    with tempfile.TemporaryDirectory(prefix="gprodom-", ignore_cleanup_errors=True) as name:
        figures = measure(fault, log, args.seconds, args.configs, Path(name))
        for mount in (Path(name) / "state", Path(name) / "log"):
            if mount.is_mount():
                subprocess.run(["umount", "-l", str(mount)], check=True)
    return figures


def main() -> int:
    """Runs the command line."""
    args = parse()
    results, wrong = [], []
    with temporary_folder() as folder:
        log = log_of(args.log, folder)
        for fault in FAULTS:
            print(f"{fault.name} ...", file=sys.stderr)
            results.append(by_itself(fault, log, args))
            wrong += verdict(results[-1])
    print_figures(args, {"runs": results, "wrong": wrong}, table_of(results))
    return told_wrong(wrong)


if __name__ == "__main__":
    exit_with(main)
