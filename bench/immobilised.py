#!/usr/bin/env python3
"""Is a robot told that its wheels turn and the ground stands (flag IMMOBILISED)?

Without SEQUENCE, simulated drives, two cases each: once the robot digs itself in while it drives,
once it stands and does not get going. In every second drive the wheel turns slowly (0.05 to 0.25
m/s), in the others at 0.3 to 0.8 m/s. A case begins when the ground stands and the wheel turns, and
is told in time if the flag comes within 1 s at 0.3 m/s or more, else within 0.3 m that the wheel
turns. With --km, drives besides on which the robot is never immobilised, of so many km in all:
creeping, driving and resting, on ground of any unevenness down to none, where the radar sees no
motion. A false alarm is a flag without a case.

With SEQUENCEs, flags on those: none is immobilised, so that each is a false alarm.

    bench/immobilised.py [--cases 40] [--km 20] [--lines NAME|FILE] [-j 2] [--json]
    bench/immobilised.py ../shared/data/cmu_like/*.zip ../shared/data/rough/*.zip
"""

from __future__ import annotations

import math
import sys
import tempfile
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path

import numpy as np

from gprodom.arrays import Bools, Floats
from gprodom.benchmark.motion import runs
from gprodom.console import format_table
from gprodom.ground.survey import shipped
from gprodom.lcm import logs
from gprodom.lcm.constants import flag
from gprodom.lcm.log_writer import write_log
from gprodom.odometry.estimate import as_log, estimate
from gprodom.odometry.methods import find_method
from gprodom.random_streams import stream
from gprodom.simulate.drives import creeping_drive, immobilised_drive
from gprodom.simulate.ground import GroundSpec
from gprodom.simulate.recording import log_streams
from gprodom.simulate.sequence import Simulated, SurveySpec
from gprodom.simulate.wheel import Stuck
from program import in_processes, parser_of, print_figures

IN_TIME_S, IN_TIME_M = 1.0, 0.3
FAST_MPS = 0.3  # from here on, the time counts
OVER_S = 1.5  # after the end of a case, the flag may still stand
PIECE_M = 500.0  # of the drives without cases
RAYS = "rays"


@dataclass(frozen=True)
class Case:
    """One time that the robot was immobilised. `late_s`: until told; None: it was not."""

    drive: str
    from_rest: bool
    wheel_mps: float
    late_s: float | None
    turned_m: float | None  # by the wheel until then
    in_time: bool
    turned_in_all_m: float
    moved_m: float  # of the estimate from begin to end of the case: the truth is 0


@dataclass(frozen=True)
class Result:
    """Of one drive."""

    name: str
    km: float
    cases: list[Case]
    false_alarms: list[tuple[float, float]]  # s from the start, from and to
    in_status_s: float  # STATUS says it, one message a second
    cannot_tell_s: float


@dataclass(frozen=True)
class Told:
    """Poses: times (n,), s; flagged (n,); positions (n, 3), m. And for how long STATUS says that
    the robot is immobilised, and that it cannot tell, s."""

    t: Floats
    flagged: Bools
    position: Floats
    in_status_s: float
    cannot_tell_s: float


def replay(log: Path, output: Path) -> Told:
    """What the estimator tells of a log."""
    estimate(log, find_method("gprodom"), (), (), output)
    said = logs.read(output, ["ODOMETRY", "STATUS"])
    odometry = said["ODOMETRY"]
    said_so, cannot = (
        float(sum(any(words in reason for reason in m.reasons) for m in said["STATUS"]["messages"]))
        for words in ("immobilised:", "cannot be told from slow motion")
    )
    bits = (odometry["flags"] & flag("IMMOBILISED")) != 0
    return Told(odometry["utime"] * 1e-6, bits, odometry["position"], said_so, cannot)


def ground_of(seed: int, lines: tuple[str, ...]) -> tuple[str, GroundSpec | SurveySpec]:
    """The grounds take turns."""
    names = (*shipped(), RAYS, *lines)
    name = names[seed % len(names)]
    return Path(name).stem, GroundSpec() if name == RAYS else SurveySpec(name)


def case_of(simulated: Simulated, name: str, stuck: Stuck, t: Floats, told: Told) -> Case:
    """One of a simulated drive; `t`: times of the poses, s from its start."""
    wheel_t = (simulated.wheel_utime - simulated.spec.start_utime) * 1e-6
    rolled = simulated.wheel.ticks * simulated.spec.wheel.quantum
    begin, end = span_of(simulated, stuck)
    late = turned = math.inf
    flags = t[(t >= begin) & (t <= end) & told.flagged]
    if len(flags):
        late = float(flags[0] - begin)
        turned = float(np.ptp(np.interp([begin, begin + late], wheel_t, rolled)))
    places = told.position[np.searchsorted(t, [begin, end])]
    return Case(
        drive=name,
        from_rest=begin == stuck.start,
        wheel_mps=abs(stuck.speed),
        late_s=late if len(flags) else None,
        turned_m=turned if len(flags) else None,
        in_time=late <= IN_TIME_S if abs(stuck.speed) >= FAST_MPS else turned <= IN_TIME_M,
        turned_in_all_m=float(np.ptp(np.interp([begin, end], wheel_t, rolled))),
        moved_m=float(np.linalg.norm(places[1] - places[0])),
    )


def span_of(simulated: Simulated, stuck: Stuck) -> tuple[float, float]:
    """When ground and robot stand and the wheel turns, s from the start."""
    end = stuck.start + stuck.duration
    stands = max(begin for _, begin, _ in simulated.drive.standstills() if begin < end)
    return max(stands, stuck.start), end


def judge(simulated: Simulated, name: str, folder: Path) -> Result:
    """Replays a simulated drive and holds the flags against its cases."""
    log = folder / "in.lcmlog"
    write_log(log, log_streams(simulated))
    told = replay(log, folder / "out.lcmlog")
    t = told.t - simulated.spec.start_utime * 1e-6
    spans = [span_of(simulated, stuck) for stuck in simulated.spec.wheel.stuck]
    false = [
        (float(t[a]), float(t[b - 1]))
        for a, b in runs(told.flagged)
        if not any(t[a] <= end + OVER_S and t[b - 1] >= begin for begin, end in spans)
    ]
    cases = [case_of(simulated, name, stuck, t, told) for stuck in simulated.spec.wheel.stuck]
    km = float(simulated.truth.travelled[-1]) / 1000
    return Result(name, km, cases, false, told.in_status_s, told.cannot_tell_s)


def run_case(seed: int, lines: tuple[str, ...]) -> Result:
    """One drive with two cases."""
    choose = stream(seed, "case")
    speed = choose.uniform(0.05, 0.25) if seed % 2 else choose.uniform(0.3, 0.8)
    ground_name, ground = ground_of(seed // 2, lines)
    simulated = immobilised_drive(seed, ground, speed)
    with tempfile.TemporaryDirectory() as folder:
        return judge(simulated, f"{seed} {ground_name}", Path(folder))


def run_creeping(seed: int, distance_m: float) -> Result:
    """One drive without a case."""
    simulated = creeping_drive(seed, distance_m)
    ground = simulated.spec.ground
    assert isinstance(ground, GroundSpec)
    name = f"{seed} uneven {ground.waviness:g}, {ground.scatterers:g}/m2"
    with tempfile.TemporaryDirectory() as folder:
        return judge(simulated, name, Path(folder))


def run_sequence(sequence: Path) -> Result:
    """A recorded one."""
    with tempfile.TemporaryDirectory() as folder:
        log = as_log(sequence, Path(folder), None)
        told = replay(log, Path(folder) / "out.lcmlog")
        wheel = logs.read(log, ["WHEEL"])["WHEEL"]
        km = float(np.abs(np.diff(wheel["ticks"] * wheel["metres_per_tick"])).sum()) / 1000
    t = told.t - told.t[0]
    false = [(float(t[a]), float(t[b - 1])) for a, b in runs(told.flagged)]
    return Result(sequence.stem, km, [], false, told.in_status_s, told.cannot_tell_s)


def table(results: list[Result]) -> str:
    """A line for each case or drive, and of all together."""
    cases = [case for result in results for case in result.cases]
    text = ""
    if cases:
        rows = []
        for c in cases:
            late = "" if c.late_s is None else f"{c.late_s:.2f}"
            turned = "" if c.turned_m is None else f"{c.turned_m:.2f}"
            how = "from rest" if c.from_rest else "driving"
            rows.append([c.drive, how, f"{c.wheel_mps:.2f}", late, turned])
            rows[-1] += [f"{c.turned_in_all_m:.2f}", f"{c.moved_m:.3f}", str(c.in_time)]
        heads = ["drive", "", "wheel m/s", "told after s", "m", "of m", "estimate moved", "in time"]
        text = format_table(heads, rows) + "\n"
        for name, of in (
            ("fast", [c for c in cases if c.wheel_mps >= FAST_MPS]),
            ("slow", [c for c in cases if c.wheel_mps < FAST_MPS]),
        ):
            told = [c for c in of if c.late_s is not None]
            text += f"{name}: {sum(c.in_time for c in of)} of {len(of)} in time, {len(told)} told\n"
    rows = [
        [r.name, f"{r.km:.2f}", str(len(r.false_alarms)), f"{r.cannot_tell_s:.0f}"]
        for r in results
        if r.false_alarms or not r.cases
    ]
    if rows:
        text += format_table(["drive", "km", "false alarms", "cannot tell s"], rows) + "\n"
    km, false = sum(r.km for r in results), sum(len(r.false_alarms) for r in results)
    return text + f"false alarms: {false} in {km:.2f} km, {false / km:.2f} per km"


def main() -> int:
    """Runs the command line."""
    parser = parser_of(__doc__, jobs=2)
    parser.add_argument("sequences", metavar="SEQUENCE", type=Path, nargs="*")
    parser.add_argument("--cases", type=int, default=40, help="default: %(default)s")
    parser.add_argument("--km", type=float, default=0.0, help="default: %(default)s")
    parser.add_argument("--seed", type=int, default=0, help="of the first drive")
    parser.add_argument(
        "--lines",
        metavar="NAME|FILE",
        action="append",
        default=[],
        help="ground of survey lines besides (`gprodom convert survey`)",
    )
    args = parser.parse_args()
    if args.sequences:
        results = in_processes(args.jobs, "drives", run_sequence, args.sequences)
    else:
        seeds = range(args.seed, args.seed + args.cases // 2)
        pieces = range(args.seed, args.seed + round(args.km * 1000 / PIECE_M))
        case, creeping = (
            partial(run_case, lines=tuple(args.lines)),
            partial(run_creeping, distance_m=PIECE_M),
        )
        results = in_processes(args.jobs, "drives", case, seeds)
        results += in_processes(args.jobs, "creeping drives", creeping, pieces)
    print_figures(args, [asdict(result) for result in results], table(results))
    return 0


if __name__ == "__main__":
    sys.exit(main())
