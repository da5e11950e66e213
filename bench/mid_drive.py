#!/usr/bin/env python3
"""A start on the move: each sequence cut where the robot drives, the first part thrown away.

Each SEQUENCE (zip, folder or LCM log) is cut at the first moment after --share of its length at
which the wheel has been turning for two seconds, and `imu_wheel` is run on the rest. Columns:

    cut_s      after so many seconds of the sequence
    start_s    seconds from the cut to the first pose
    stands_s   seconds from the cut to the robot's first standstill (the wheel at rest for 1 s)
    normal     error (m) over the rest of a run that began with the sequence; causal, smoothed
    causal     the same of the run that began at the cut; smoothed
    nees_xy    of the run that began at the cut; 2 is right

Both are scored on the truth's points from the later one's first pose on, aligned by se2. Asked: a
start within 10 s; where the robot stands within 20 s of the cut a causal ratio of 1.3 at most,
elsewhere a NEES of 4 and a smoothed ratio of 2 at most. Exit code 1 where one is missed.

With --gyro-bias, the gyro is worse than the simulation's: so much is added to its rates.

    bench/mid_drive.py ../shared/data/cmu_like/*.zip
    bench/mid_drive.py --share 0.3 --share 0.6 SEQ... --json
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from estimates import planar_figures, run_method
from gprodom.arrays import Floats, Ints
from gprodom.config import STANDARD
from gprodom.errors import Error
from gprodom.files import temporary_folder
from gprodom.lcm import logs
from gprodom.lcm.messages import message
from gprodom.odometry.dead_reckoning import wheel_distance
from gprodom.odometry.estimate import as_log
from gprodom.score.sources import read_truth
from log_events import read_events, write_events
from program import exit_with, one_by_one, parser_of, print_rows

DRIVING_S = 2.0
DRIVING_MPS = 0.05
STANDING_S = 1.0
STANDING_M = 0.001
SOON_S = 20.0  # in which a standstill is of use to the start
ASKED_START_S, ASKED_CAUSAL, ASKED_NEES, ASKED_SMOOTHED = 10.0, 1.3, 4.0, 2.0


def missed(outcome: dict[str, Any]) -> list[str]:
    """What was asked of a start and is not there."""
    found = ["start"] if outcome["start_s"] > ASKED_START_S else []
    if outcome["stands_s"] is not None and outcome["stands_s"] <= SOON_S:
        asked = {"causal": outcome["causal_m"] <= ASKED_CAUSAL * outcome["normal_m"]}
    else:
        smoothed = ASKED_SMOOTHED * outcome["normal_smoothed_m"]
        asked = {
            "NEES": outcome["nees_xy"] <= ASKED_NEES,
            "smoothed": outcome["smoothed_m"] <= smoothed,
        }
    return found + [name for name, held in asked.items() if not held]


def over(time: Ints, distance: Floats, seconds: float) -> tuple[Floats, Floats]:
    """Ends (us) of stretches of so many seconds, ten a second, and the unsigned way of each (m)."""
    ends = np.arange(time[0] + round(seconds * 1e6), time[-1], 100_000, dtype=float)
    path = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(distance)))])
    begun = np.interp(ends - seconds * 1e6, time, path)
    return ends, np.asarray(np.interp(ends, time, path) - begun)


def find_cut(time: Ints, distance: Floats, share: float) -> int:
    """Where the sequence is cut, us."""
    ends, way = over(time, distance, DRIVING_S)
    still = np.interp(ends, *over(time, distance, DRIVING_S / 4))  # way of the last part alone
    driving = (way > DRIVING_MPS * DRIVING_S) & (still > DRIVING_MPS * DRIVING_S / 4)
    driving &= ends >= time[0] + share * np.ptp(time)
    if not driving.any():
        raise Error(f"the robot does not drive after {share:g} of the sequence")
    return int(ends[driving][0])


def first_standstill(time: Ints, distance: Floats, cut: int) -> float | None:
    """Seconds after the cut at which the robot has stood for STANDING_S."""
    ends, way = over(time, distance, STANDING_S)
    standing = ends[(way < STANDING_M) & (ends >= cut + STANDING_S * 1e6)]
    return float(standing[0] - cut) * 1e-6 if len(standing) else None


def cut_log(log: Path, at: int, output: Path) -> Path:
    """Its messages from there on."""
    return write_events((event for event in read_events(log) if event[0] >= at), output)


def add_to_rates(log: Path, more: Floats) -> None:
    """Adds a bias (rad/s; three axes) to the gyro in a log's IMU messages."""

    def changed(data: bytes) -> bytes:
        imu = message("imu_t").decode(data)
        imu.angular_velocity = [*(imu.angular_velocity + more)]
        return bytes(imu.encode())

    events = [(t, c, changed(d) if c == STANDARD.imu else d) for t, c, d in read_events(log)]
    write_events(events, log)


def measure(sequence: Path, args: argparse.Namespace, folder: Path) -> Iterator[dict[str, Any]]:
    """A sequence, cut at each of the shares."""
    # Outputs lie beside what is run.
    whole = cut_log(as_log(sequence, folder), 0, folder / "whole.lcmlog")
    if any(args.gyro_bias):
        add_to_rates(whole, np.array(args.gyro_bias))
    output = folder / "out.lcmlog"
    normal = run_method(whole, "imu_wheel", output, args.overrides, smooth=True)
    truth = read_truth(whole).trajectory
    time, distance = wheel_distance(logs.read_roles(whole, STANDARD.of("imu", "wheel")))
    for share in args.shares or [0.5]:
        cut = find_cut(time, distance, share)
        log = cut_log(whole, cut, folder / "short.lcmlog")
        short = run_method(log, "imu_wheel", output, args.overrides, smooth=True)
        rest = truth.select(truth.time >= short.trajectory.time[0])
        paths = (normal.trajectory, short.trajectory, normal.smoothed, short.smoothed)
        scores = [planar_figures(path, rest) for path in paths if path]
        names = ("normal_m", "causal_m", "normal_smoothed_m", "smoothed_m")
        outcome = {
            "sequence": sequence.stem,
            "cut_s": (cut - int(time[0])) * 1e-6,
            "start_s": (int(short.trajectory.time[0]) - cut) * 1e-6,
            "stands_s": first_standstill(time, distance, cut),
            **{name: each.ate_rmse_m for name, each in zip(names, scores, strict=True)},
            "nees_xy": np.nan if scores[1].nees_xy is None else scores[1].nees_xy,
        }
        yield outcome | {"missed": missed(outcome)}


def main() -> int:
    """Runs the command line."""
    parser = parser_of(__doc__, overrides=True)
    parser.add_argument("sequences", nargs="+", type=Path, metavar="SEQUENCE")
    parser.add_argument("--share", type=float, action="append", metavar="0..1", dest="shares")
    parser.add_argument(
        "--gyro-bias", type=float, nargs=3, default=[0.0] * 3, metavar="RAD_S", help="added to it"
    )
    args = parser.parse_args()
    outcomes: list[dict[str, Any]] = []
    for sequence in one_by_one("replaying", args.sequences):
        with temporary_folder() as folder:
            outcomes += measure(sequence, args, folder)
    print_rows(args, outcomes)
    return 1 if any(outcome["missed"] for outcome in outcomes) else 0


if __name__ == "__main__":
    exit_with(main)
