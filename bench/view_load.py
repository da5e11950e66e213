#!/usr/bin/env python3
"""What `gprodom view` costs: opening a log, scrubbing it, and watching a running robot.

SEQ is driven round after round for --length seconds, and replayed. Printed are the wall and
processor time in which `gprodom view` writes the recording of all of it, its size, and the share
of a core that the live view takes while the replay's input and output are played at the speed at
which they were recorded (in a network namespace of its own), first into a file and then with a
viewer that is served for a browser beside it.

Scrubbing, by the API of a viewer of 1440 x 900 under Xvfb, drawn by the processor (lavapipe): the
time cursor is put at a time of the drive at random, and a picture of the whole window is asked for;
measured is the time from before the first to when the picture is written. The same without a move
is measured beside it: what a picture costs by itself. The viewer loses a picture that it was asked
for now and then; after 15 s it is asked again, and the time goes on. A picture after a move must
differ from the one before it. Needs the packages xvfb and mesa-vulkan-drivers; --scrubs 0 leaves it
out.

    bench/view_load.py SEQ [--length 3600] [--seconds 60] [--scrubs 100] [--json]
    bench/view_load.py IN.lcmlog --replayed OUT.lcmlog      # a log as it is
"""

from __future__ import annotations

import os
import random
import shutil
import signal
import statistics
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

from gprodom.files import temporary_folder
from gprodom.odometry.replay import run_replay
from gprodom.view.record import TIMELINE
from gprodom.view.viewer import free_port, started, viewer_command, without_statistics
from own_network import URL, parse_inside
from processes import children_seconds, processor_seconds
from program import exit_with, list_of, parser_of, print_figures
from repeat_log import repeat
from zips import log_of

VIEW = (sys.executable, "-m", "gprodom", "view")
ENDS_S = 60.0  # at most
SETTLES_S = 8.0  # imports, and the viewer's start
LOADS_S = 120.0  # a viewer its recording, at most
WINDOW = "1440x900"
SEED = 1


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


def scrub(recording: Path, folder: Path, count: int) -> dict[str, float]:
    """Moves of the time cursor, and pictures."""
    from rerun.experimental import ViewerClient

    port = free_port()
    more = ["--renderer", "vulkan", "--window-size", WINDOW, str(recording)]
    screen = ["xvfb-run", "-a", "-s", "-screen 0 5000x4000x24"]
    with without_statistics() as environment:
        command = [*screen, *viewer_command("127.0.0.1", port, None, more)]
        begun = time.monotonic()
        viewer = started(command, environment, port)
        try:
            client = ViewerClient.connect(f"rerun+http://127.0.0.1:{port}/proxy")
            first, last = loaded(client)
            loads = time.monotonic() - begun
            shot = folder / "shot.png"
            client.set_time(TIMELINE, timestamp=first * 1e-9, play_state="paused")
            timed_picture(client, shot)
            still = [timed_picture(client, shot)[0] for _ in range(max(count // 5, 3))]
            before, moved, changed = timed_picture(client, shot)[1], [], 0
            random_times = random.Random(SEED)
            for _ in range(count):
                at = random_times.uniform(first, last) * 1e-9
                seconds, picture = timed_picture(client, shot, at)
                moved.append(seconds)
                changed += picture != before
                before = picture
        finally:
            os.killpg(viewer.pid, signal.SIGTERM)
            viewer.wait(ENDS_S)
    if changed < count:
        sys.exit(f"view_load: {count - changed} of {count} pictures did not change by a move")
    return {
        "viewer_loads_s": loads,
        "scrub_median_s": statistics.median(moved),
        "scrub_95_percent_s": sorted(moved)[round(0.95 * (count - 1))],
        "scrub_worst_s": max(moved),
        "picture_without_a_move_median_s": statistics.median(still),
    }


def loaded(client: Any) -> tuple[int, int]:
    """The span of the recording's times, ns, once all of it is in the viewer."""
    due, before = time.monotonic() + LOADS_S, None
    while time.monotonic() < due:
        state = client.get_state()
        lines = [each for every in state.recordings for each in every.timelines]
        span = next(((each.start, each.end) for each in lines if each.name == TIMELINE), None)
        if span is not None and span[0] is not None and not state.loading and span == before:
            return span
        before = span
        time.sleep(0.5)
    sys.exit("view_load: the viewer did not load the recording")


def timed_picture(client: Any, shot: Path, at_s: float | None = None) -> tuple[float, bytes]:
    """Moves the cursor to `at_s`, if given; seconds until the picture is there, and the picture."""
    shot.unlink(missing_ok=True)
    begun = time.monotonic()
    if at_s is not None:
        client.set_time(TIMELINE, timestamp=at_s)
    while not shot.is_file():
        try:
            client.save_screenshot(str(shot))
        except TimeoutError:  # after 15 s, on a busy computer: asked again, and the time goes on
            if time.monotonic() - begun > LOADS_S:
                raise
    return time.monotonic() - begun, shot.read_bytes()


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
    parser.add_argument(
        "--scrubs", type=int, default=100, metavar="N", help="moves (default %(default)s)"
    )
    args = parse_inside(parser)
    with temporary_folder() as folder:
        sensors, out = args.source, args.replayed
        if out is None:
            sensors, out = folder / "long.lcmlog", folder / "out.lcmlog"
            repeat(log_of(args.source, folder), sensors, args.length)
            run_replay(sensors, out)
        recording = folder / "drive.rrd"
        figures = open_log(out, sensors, recording)
        if args.scrubs and not shutil.which("xvfb-run"):
            sys.exit("view_load: scrubbing needs xvfb-run (package xvfb), or --scrubs 0")
        if args.scrubs:
            figures |= scrub(recording, folder, args.scrubs)
        logs = [out, sensors]
        into_file = ["-o", str(folder / "live.rrd")]
        figures["live_to_file_core_pct"] = watch(logs, args.seconds, into_file)
        figures["live_to_viewer_core_pct"] = watch(logs, args.seconds, ["--web"])
    print_figures(args, figures, list_of(figures))


if __name__ == "__main__":
    exit_with(main)
