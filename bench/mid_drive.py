#!/usr/bin/env python3
"""A start on the move: each sequence cut where the robot drives, the first part thrown away.

Each SEQUENCE (zip, folder or LCM log) is cut at the first moment after --share of its length at
which the wheel has been turning for two seconds, and `imu_wheel` is run on the rest. Columns:

    cut        after so many seconds of the sequence
    start      seconds from the cut to the first pose
    stands     seconds from the cut to the robot's first standstill (the wheel at rest for 1 s)
    normal     error (m) over the rest of a run that began with the sequence; causal, smoothed
    cut short  the same of the run that began at the cut
    ratio      of the two
    NEES       of x and y, of the run that began at the cut; 2 is right

Both are scored on the truth's points from the later one's first pose on, aligned by se2. Asked: a
start within 10 s; where the robot stands within 20 s of the cut a causal ratio of 1.3 at most,
elsewhere a NEES of 4 and a smoothed ratio of 2 at most. Exit code 1 where one is missed.

With --given, the runs that begin at the cut are given what a normal start knows from the stops
before it, and no estimator can know at once: the gyro's true bias (taken out of its data) or the
wheel's true scale, from the simulation's .json beside each SEQUENCE. What is then left is the
start's own error.

With --gyro-bias, the gyro is worse than the simulation's: so much is added to its rates.

    bench/mid_drive.py ../shared/data/cmu_like/*.zip
    bench/mid_drive.py --share 0.3 --share 0.6 SEQ... --json
"""

from __future__ import annotations

import json
import tempfile
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from gprodom.arrays import Floats, Ints
from gprodom.config import STANDARD
from gprodom.console import format_table
from gprodom.errors import Error
from gprodom.lcm import EventLog, logs
from gprodom.lcm.messages import message
from gprodom.odometry.dead_reckoning import wheel_distance
from gprodom.odometry.estimate import as_log, estimate
from gprodom.odometry.methods import find_method
from gprodom.score.associate import associate
from gprodom.score.figures import compare
from gprodom.score.sources import read_truth
from gprodom.trajectory import Trajectory
from program import exit_with, one_by_one, parser_of, print_figures

DRIVING_S = 2.0
DRIVING_MPS = 0.05
STANDING_S = 1.0
STANDING_M = 0.001
SOON_S = 20.0  # in which a standstill is of use to the start
GIVEN = ("bias", "scale")
ASKED_START_S, ASKED_CAUSAL, ASKED_NEES, ASKED_SMOOTHED = 10.0, 1.3, 4.0, 2.0


@dataclass(frozen=True)
class Outcome:
    """Of one sequence at one cut; errors in metres."""

    sequence: str
    cut_s: float
    start_s: float
    stands_s: float | None
    normal_m: float
    causal_m: float
    normal_smoothed_m: float
    smoothed_m: float
    nees_xy: float

    @property
    def missed(self) -> list[str]:
        """What was asked of it and is not there."""
        missed = [f"start {self.start_s:.1f} s"] if self.start_s > ASKED_START_S else []
        if self.stands_s is not None and self.stands_s <= SOON_S:
            if self.causal_m > ASKED_CAUSAL * self.normal_m:
                missed.append("causal")
            return missed
        if self.nees_xy > ASKED_NEES:
            missed.append("NEES")
        if self.smoothed_m > ASKED_SMOOTHED * self.normal_smoothed_m:
            missed.append("smoothed")
        return missed


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
    written = EventLog(str(output), "w", overwrite=True)
    for event in EventLog(str(log), "r"):
        if event.timestamp >= at:
            written.write_event(event.timestamp, event.channel, event.data)
    written.close()
    return output


def add_to_rates(log: Path, more: Floats) -> None:
    """Adds a bias (rad/s; three axes) to the gyro in a log's IMU messages."""
    events = [(e.timestamp, e.channel, e.data) for e in EventLog(str(log), "r")]
    written = EventLog(str(log), "w", overwrite=True)
    for time, channel, data in events:
        if channel == STANDARD.imu:
            imu = message("imu_t").decode(data)
            imu.angular_velocity = [*(imu.angular_velocity + more)]
            data = bytes(imu.encode())
        written.write_event(time, channel, data)
    written.close()


def run(log: Path, overrides: Sequence[str]) -> tuple[Trajectory, Trajectory]:
    """Causal and smoothed."""
    method = find_method("imu_wheel")
    found = estimate(log, method, (), overrides, log.with_suffix(".out.lcmlog"), smooth=True)
    if found.smoothed is None:
        raise Error(f"{log}: no smoothed solution")
    return found.trajectory, found.smoothed


def measure(
    sequence: Path,
    shares: Sequence[float],
    overrides: Sequence[str],
    folder: Path,
    given: Sequence[str] = (),
    gyro_bias: Sequence[float] = (0.0, 0.0, 0.0),
) -> list[Outcome]:
    """A sequence, cut at each of the shares; `given`: of GIVEN; `gyro_bias`: added, rad/s."""
    known = json.loads(sequence.with_suffix(".json").read_text()) if given else {}
    scale = [f"wheel.scale={known['scale']}", "wheel.scale_sigma=0"] if "scale" in given else []
    log = as_log(sequence, folder)
    whole = cut_log(log, 0, folder / "whole.lcmlog")  # outputs lie beside what is run
    if any(gyro_bias):
        add_to_rates(whole, np.array(gyro_bias))
    normal = run(whole, overrides)
    truth = read_truth(whole).trajectory
    time, distance = wheel_distance(logs.read_roles(whole, STANDARD.of("imu", "wheel")))
    outcomes = []
    for share in shares:
        cut = find_cut(time, distance, share)
        log = cut_log(whole, cut, folder / "short.lcmlog")
        if "bias" in given:
            add_to_rates(log, -np.add(known["bg"], gyro_bias))
        short = run(log, [*overrides, *scale])
        rest = truth.select(truth.time >= short[0].time[0])
        pairs = [associate(trajectory, rest) for trajectory in (*normal, *short)]
        scores = [compare(each, "se2", 3.0).figures for each in pairs]
        errors = [score.ate_rmse_m for score in scores]
        nees = scores[2].nees_xy
        outcomes.append(
            Outcome(
                sequence.stem,
                (cut - int(time[0])) * 1e-6,
                (int(short[0].time[0]) - cut) * 1e-6,
                first_standstill(time, distance, cut),
                errors[0],
                errors[2],
                errors[1],
                errors[3],
                np.nan if nees is None else nees,
            )
        )
    return outcomes


def table(outcomes: list[Outcome]) -> str:
    """For people."""
    heads = ["sequence", "cut (s)", "start (s)", "stands (s)", "normal", "cut short", "ratio"]
    heads += ["normal, smoothed", "cut short", "ratio", "NEES", "missed"]
    rows = []
    for o in outcomes:
        rows.append([o.sequence, f"{o.cut_s:.1f}", f"{o.start_s:.1f}"])
        rows[-1] += ["never" if o.stands_s is None else f"{o.stands_s:.1f}"]
        rows[-1] += [f"{o.normal_m:.3f}", f"{o.causal_m:.3f}", f"{o.causal_m / o.normal_m:.2f}"]
        rows[-1] += [f"{o.normal_smoothed_m:.3f}", f"{o.smoothed_m:.3f}"]
        rows[-1] += [f"{o.smoothed_m / o.normal_smoothed_m:.2f}", f"{o.nees_xy:.2f}"]
        rows[-1] += [", ".join(o.missed)]
    return format_table(heads, rows)


def main() -> int:
    """Runs the command line."""
    parser = parser_of(__doc__, overrides=True)
    parser.add_argument("sequences", nargs="+", type=Path, metavar="SEQUENCE")
    parser.add_argument("--share", type=float, action="append", metavar="0..1", dest="shares")
    parser.add_argument("--given", action="append", default=[], choices=GIVEN)
    parser.add_argument(
        "--gyro-bias", type=float, nargs=3, default=[0.0] * 3, metavar="RAD_S", help="added to it"
    )
    args = parser.parse_args()
    shares = args.shares or [0.5]
    outcomes: list[Outcome] = []
    for sequence in one_by_one("replaying", args.sequences):
        with tempfile.TemporaryDirectory(prefix="gprodom-") as folder:
            also = (args.given, args.gyro_bias)
            outcomes += measure(sequence, shares, args.overrides, Path(folder), *also)
    figures = [{**asdict(outcome), "missed": outcome.missed} for outcome in outcomes]
    print_figures(args, figures, table(outcomes))
    return 1 if any(outcome.missed for outcome in outcomes) else 0


if __name__ == "__main__":
    exit_with(main)
