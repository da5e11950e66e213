#!/usr/bin/env python3
"""Is a robot told that its wheels turn and the ground stands (flag IMMOBILISED)?

Simulated drives, two cases each: once the robot digs itself in while it drives, once it stands and
does not get going. In every second drive the wheel turns slowly (0.05 to 0.25 m/s), in the others
at 0.3 to 0.8 m/s. A case begins when the ground stands and the wheel turns, and is told in time if
the flag comes within 1 s at 0.3 m/s or more, else within 0.3 m that the wheel turns. With --km,
drives besides on which the robot is never immobilised, of so many km in all: creeping, driving and
resting, on ground of any unevenness down to none, where the radar sees no motion. A false alarm is
a flag without a case.

    bench/immobilised.py [--cases 40] [--km 20] [-j 2] [--json]
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from estimates import run_method
from gprodom.arrays import Bools, Floats, runs
from gprodom.files import temporary_folder
from gprodom.ground.survey import shipped
from gprodom.lcm import logs
from gprodom.lcm.constants import flag
from gprodom.lcm.log_writer import write_log
from gprodom.random_streams import stream
from gprodom.simulate.drives import creeping_drive, immobilised_drive
from gprodom.simulate.ground import GroundSpec
from gprodom.simulate.recording import log_streams
from gprodom.simulate.sequence import Simulated, SurveySpec
from gprodom.simulate.wheel import Stuck
from program import exit_with, in_processes, parser_of, print_figures, table_of

IN_TIME_S, IN_TIME_M = 1.0, 0.3
FAST_MPS = 0.3  # from here on, the time counts
OVER_S = 1.5  # after the end of a case, the flag may still stand
PIECE_M = 500.0  # of the drives without cases
RAYS = "rays"


@dataclass(frozen=True)
class Told:
    """Poses: times (n,), s from the start; flagged (n,); positions (n, 3), m. And for how long
    STATUS says that the robot is immobilised, s."""

    t: Floats
    flagged: Bools
    position: Floats
    in_status_s: float


def replay(log: Path, output: Path, start: int) -> Told:
    """What the estimator tells of a log. start: us, of its times."""
    run_method(log, "gprodom", output)
    said = logs.read(output, ["ODOMETRY", "STATUS"])
    odometry, messages = said["ODOMETRY"], said["STATUS"]["messages"]
    said_so = sum(any("immobilised:" in reason for reason in m.reasons) for m in messages)
    bits = (odometry["flags"] & flag("IMMOBILISED")) != 0
    t = odometry["utime"] * 1e-6 - start * 1e-6
    return Told(t, bits, odometry["position"], float(said_so))


def ground_of(seed: int) -> tuple[str, GroundSpec | SurveySpec]:
    """The grounds take turns."""
    names = (*shipped(), RAYS)
    name = names[seed % len(names)]
    return name, GroundSpec() if name == RAYS else SurveySpec(name)


def case_of(simulated: Simulated, name: str, stuck: Stuck, told: Told) -> dict[str, Any]:
    """One time that the robot was immobilised. late_s: until told; None: it was not. turned_m: by
    the wheel until then. moved_m: of the estimate, from begin to end of the case: the truth is 0.
    """
    wheel_t = (simulated.wheel_utime - simulated.spec.start_utime) * 1e-6
    rolled = simulated.wheel.ticks * simulated.spec.wheel.quantum
    begin, end = span_of(simulated, stuck)
    late = turned = math.inf
    flags = told.t[(told.t >= begin) & (told.t <= end) & told.flagged]
    if len(flags):
        late = float(flags[0] - begin)
        turned = float(np.ptp(np.interp([begin, begin + late], wheel_t, rolled)))
    places = told.position[np.searchsorted(told.t, [begin, end])]
    return {
        "drive": name,
        "from_rest": begin == stuck.start,
        "wheel_mps": abs(stuck.speed),
        "late_s": late if len(flags) else None,
        "turned_m": turned if len(flags) else None,
        "in_time": late <= IN_TIME_S if abs(stuck.speed) >= FAST_MPS else turned <= IN_TIME_M,
        "turned_in_all_m": float(np.ptp(np.interp([begin, end], wheel_t, rolled))),
        "moved_m": float(np.linalg.norm(places[1] - places[0])),
    }


def span_of(simulated: Simulated, stuck: Stuck) -> tuple[float, float]:
    """When ground and robot stand and the wheel turns, s from the start."""
    end = stuck.start + stuck.duration
    stands = max(begin for _, begin, _ in simulated.drive.standstills() if begin < end)
    return max(stands, stuck.start), end


def judge(simulated: Simulated, name: str) -> dict[str, Any]:
    """Replays a simulated drive and holds the flags against its cases. false_alarms: flags beside
    these, s from the start, from and to."""
    with temporary_folder() as folder:
        log = folder / "in.lcmlog"
        write_log(log, log_streams(simulated))
        told = replay(log, folder / "out.lcmlog", simulated.spec.start_utime)
    stuck = simulated.spec.wheel.stuck
    spans = [span_of(simulated, each) for each in stuck]
    alarms = [(float(told.t[a]), float(told.t[b - 1])) for a, b in runs(told.flagged)]
    return {
        "name": name,
        "km": float(simulated.truth.travelled[-1]) / 1000,
        "cases": [case_of(simulated, name, each, told) for each in stuck],
        "false_alarms": [
            (first, last)
            for first, last in alarms
            if not any(first <= end + OVER_S and last >= begin for begin, end in spans)
        ],
        "in_status_s": told.in_status_s,
    }


def run_case(seed: int) -> dict[str, Any]:
    """One drive with two cases."""
    choose = stream(seed, "case")
    speed = choose.uniform(0.05, 0.25) if seed % 2 else choose.uniform(0.3, 0.8)
    ground_name, ground = ground_of(seed // 2)
    return judge(immobilised_drive(seed, ground, speed), f"{seed} {ground_name}")


def run_creeping(seed: int, distance_m: float) -> dict[str, Any]:
    """One drive without a case."""
    simulated = creeping_drive(seed, distance_m)
    ground = simulated.spec.ground
    assert isinstance(ground, GroundSpec)
    return judge(simulated, f"{seed} uneven {ground.waviness:g}, {ground.scatterers:g}/m2")


def table(results: list[dict[str, Any]]) -> str:
    """A line for each case and each drive with a false alarm, and of all together."""
    cases = [case for each in results for case in each["cases"]]
    alarms = [
        {**each, "false_alarms": len(each["false_alarms"]), "cases": len(each["cases"])}
        for each in results
    ]
    km, false = (sum(each[key] for each in alarms) for key in ("km", "false_alarms"))
    shown = [each for each in alarms if each["false_alarms"] or not each["cases"]]
    text = "".join(f"{table_of(rows)}\n" for rows in (cases, shown) if rows)
    text += f"{sum(case['in_time'] for case in cases)} of {len(cases)} in time, "
    return f"{text}false alarms: {false} in {km:.2f} km"


def main() -> None:
    """Runs the command line."""
    parser = parser_of(__doc__, jobs=2)
    parser.add_argument("--cases", type=int, default=40, help="default: %(default)s")
    parser.add_argument("--km", type=float, default=0.0, help="default: %(default)s")
    parser.add_argument("--seed", type=int, default=0, help="of the first drive")
    args = parser.parse_args()
    seeds = range(args.seed, args.seed + args.cases // 2)
    pieces = range(args.seed, args.seed + round(args.km * 1000 / PIECE_M))
    creeping = partial(run_creeping, distance_m=PIECE_M)
    results = in_processes(args.jobs, "drives", run_case, seeds)
    results += in_processes(args.jobs, "creeping drives", creeping, pieces)
    print_figures(args, results, table(results))


if __name__ == "__main__":
    exit_with(main)
