#!/usr/bin/env python3
"""What `gprodom view` costs: opening a log, and watching a running robot.

SEQ is driven round after round for --length seconds, and replayed. Printed are the wall and
processor time in which `gprodom view` writes the recording of all of it, its size, and the share
of a core that the live view takes while the replay's input and output are played at the speed at
which they were recorded (in a network namespace of its own), first into a file and then with a
viewer that is served for a browser beside it.

    bench/view_load.py SEQ [--length 3600] [--seconds 60] [--json]
    bench/view_load.py IN.lcmlog --replayed OUT.lcmlog      # a log as it is
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

from gprodom.files import temporary_folder
from gprodom.odometry.replay import run_replay
from own_network import URL, parse_inside
from processes import children_seconds, processor_seconds
from program import exit_with, list_of, parser_of, print_figures
from repeat_log import repeat
from zips import log_of

VIEW = (sys.executable, "-m", "gprodom", "view")
ENDS_S = 60.0  # at most
SETTLES_S = 8.0  # imports, and the viewer's start


def open_log(out: Path, sensors: Path, path: Path) -> dict[str, float]:
    """Writes the recording."""
    before, begun = children_seconds(), time.monotonic()
    view = [*VIEW, str(out), "--sensors", str(sensors), "-o", str(path)]
    subprocess.run(view, check=True, stdout=subprocess.DEVNULL)
    return {
        "open_wall_s": time.monotonic() - begun,
        "open_processor_s": children_seconds() - before,
        "recording_mb": path.stat().st_size / 1e6,
    }


def watch(logs: list[Path], seconds: float, more: list[str]) -> float:
    """Share of a core, percent, of the process that logs."""
    players: list[subprocess.Popen[bytes]] = []
    viewer = subprocess.Popen([*VIEW, "--live", "--lcm-url", URL, *more], start_new_session=True)
    try:
        time.sleep(SETTLES_S)
        for log in logs:
            play = ["lcm-logplayer", "-l", URL, str(log)]
            players.append(
                subprocess.Popen(play, stdout=subprocess.DEVNULL, start_new_session=True)
            )
        time.sleep(2.0)
        begun, used = time.monotonic(), processor_seconds(viewer.pid)
        time.sleep(seconds)
        share = 100 * (processor_seconds(viewer.pid) - used) / (time.monotonic() - begun)
    finally:
        for process in (*players, viewer):  # with what a wrapper has started
            os.killpg(process.pid, signal.SIGINT)
            process.wait(ENDS_S)
    return share


def main() -> None:
    """Runs the command line."""
    parser = parser_of(__doc__)
    parser.add_argument("source", metavar="SEQ|LOG", type=Path)
    parser.add_argument("--replayed", metavar="OUT", type=Path, help="its replay, if there is one")
    parser.add_argument("--length", type=float, default=3600.0, help="s (default %(default)s)")
    parser.add_argument("--seconds", type=float, default=60.0, help="watched (default %(default)s)")
    args = parse_inside(parser)
    with temporary_folder() as folder:
        sensors, out = args.source, args.replayed
        if out is None:
            sensors, out = folder / "long.lcmlog", folder / "out.lcmlog"
            repeat(log_of(args.source, folder), sensors, args.length)
            run_replay(sensors, out)
        figures = open_log(out, sensors, folder / "drive.rrd")
        logs = [out, sensors]
        into_file = ["-o", str(folder / "live.rrd")]
        figures["live_to_file_core_pct"] = watch(logs, args.seconds, into_file)
        figures["live_to_viewer_core_pct"] = watch(logs, args.seconds, ["--web"])
    print_figures(args, figures, list_of(figures))


if __name__ == "__main__":
    exit_with(main)
