#!/usr/bin/env python3
"""How far the position is off behind a gap of the wheel's messages, seen from before the gap.

In the log of each recording the wheel is silent for so many seconds, again and again, with 9 s in
between. The tracks of truth, `imu_wheel` and dead reckoning (which spreads the encoder's count
evenly over the gap) are laid over each other by the 8 s before a gap. The error is the distance
from the truth 2 s behind it (RMS over the gaps, m). Gaps before which the robot moved less than
0.7 m are left out.

SOURCE is the folder of bench/robots.py, or a sequence or log with truth.

    bench/wheel_gaps.py SOURCE [--only RECORDING]... [--gap SECONDS]... [-j 2] [--json]
"""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from estimates import mount_in
from gprodom.arrays import Floats
from gprodom.config import STANDARD
from gprodom.lcm import logs
from gprodom.odometry.dead_reckoning import wheel_and_gyro
from gprodom.score.sources import read_estimate, read_truth
from gprodom.trajectory import Trajectory, path_length
from program import exit_with, in_processes, parser_of, print_rows
from recordings import recordings_of
from robot_variations import is_folder, names_of, recorded
from robots import measure
from sensors import read, write

FIRST, BETWEEN, BEFORE, BEHIND = 15.0, 9.0, 8.0, 2.0  # s
LEAST_M = 0.7
GAPS = (0.5, 1.5, 3.0, 10.0)  # s


def seen_from_before(track: Trajectory, truth: Trajectory, begin: float, end: float) -> Floats:
    """Where the track ends up less where the truth does (m, x and y), as laid over each other.

    Empty without a way before the gap, or data behind it.
    """
    times = np.append(np.arange(begin - BEFORE, begin, 0.1), end + BEHIND)
    both = [
        np.stack([np.interp(times, t.time * 1e-6, t.position[:, i]) for i in range(2)], axis=1)
        for t in (track, truth)
    ]
    inside = all(
        t.time[0] * 1e-6 <= times[0] and times[-1] <= t.time[-1] * 1e-6 for t in (track, truth)
    )
    if not inside or path_length(both[1][:-1:10])[-1] < LEAST_M:
        return np.empty(0)
    a, b = (points - points[-2] for points in both)  # from the gap's begin
    turn = np.angle(np.sum(np.conj(a[:-2] @ (1, 1j)) * (b[:-2] @ (1, 1j))))
    c, s = np.cos(turn), np.sin(turn)
    return np.asarray(a[-1] @ np.array([[c, s], [-s, c]]) - b[-1])


def run(source: Path, name: str, gap: float, overrides: Sequence[str]) -> dict[str, Any]:
    """The figures of gaps of one length in one recording."""
    with tempfile.TemporaryDirectory(prefix="gprodom-") as folder:
        recording, log = recorded(source, name, Path(folder))
        mount, sensors = mount_in(log), read(log)
        t = sensors.wheel_time * 1e-6
        begins = np.arange(t[0] + FIRST, t[-1] - gap - BEHIND, gap + BETWEEN)
        rest = ~np.any((t > begins[:, None]) & (t < begins[:, None] + gap), axis=0)
        log = write(sensors.wheel_at(rest), Path(folder) / "in.lcmlog")
        measure(recording, log, mount, overrides, smooth=False)
        truth = read_truth(log).trajectory
        tracks = {
            "imu_wheel_m": read_estimate(log.with_suffix(".out.lcmlog"), "odom").trajectory,
            "wheel_m": wheel_and_gyro(logs.read_roles(log, STANDARD.of("imu", "wheel"))),
        }
    off = {
        key: [seen_from_before(track, truth, begin, begin + gap) for begin in begins]
        for key, track in tracks.items()
    }
    known = [all(len(each[i]) for each in off.values()) for i in range(len(begins))]
    row: dict[str, Any] = {"recording": name, "gap_s": gap, "gaps": sum(known)}
    for key, each in off.items():
        errors = [float(np.hypot(*e)) for e, k in zip(each, known, strict=True) if k]
        row[key] = float(np.sqrt(np.mean(np.square(errors)))) if errors else None
    return row


def main() -> int:
    """Runs the command line."""
    parser = parser_of(__doc__, jobs=2, overrides=True)
    parser.add_argument("source", type=Path, metavar="SOURCE")
    parser.add_argument("--only", action="append", metavar="RECORDING", default=[])
    parser.add_argument("--gap", action="append", type=float, metavar="SECONDS", default=[])
    args = parser.parse_args()
    known = names_of(args.source, args.only)
    if is_folder(args.source):  # the truth of others tells the distance alone
        known = [name for name in known if recordings_of(args.source)[name].points]
    cases = [(name, gap) for name in known for gap in args.gap or GAPS]
    names, gaps = zip(*cases, strict=True)
    work = partial(run, args.source, overrides=args.overrides)
    rows = in_processes(args.jobs, "gaps", work, names, gaps)
    print_rows(args, rows, ["recording", "gap (s)", "gaps", "imu_wheel (m)", "wheel (m)"])
    return 0


if __name__ == "__main__":
    exit_with(main)
