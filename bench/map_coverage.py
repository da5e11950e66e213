#!/usr/bin/env python3
"""Is the pose in map as sure as it says, and does it withstand wrong revisits? Simulated drives.

Each run draws everything from a seed: a line driven to and fro or laps, of some 45 m, over ground
of scatterers and layers, the wheel's scale, the errors of the sensors, two episodes of slip. The
truth is placed by its first pose. Of the position in `map`:

    coverage   share of the drives, at their end, in which the 95 % ellipse holds the truth; and the
               same of all moments, a second apart, from the first revisit on
    mean NEES  of the drives at their end, and the 95 % band of a right covariance
    --laps N   N laps of 14 m without slip, always forwards, in which the robot wanders (--wander);
               with wheel.slip_share=0, what revisits of the same ground again and again know
    --abreast M
               two antennas on such laps, M metres abreast; with --one, the left one alone
    --wrong    the same drives with wrong revisits told by another process besides: every 20 m one
               that is 0.3 to 3 m off, and three a metre apart that agree with each other, one pitch
               of 0.5 m off. Prints how far the final pose lies from that of the clean run.

    bench/map_coverage.py --runs 100
    bench/map_coverage.py --runs 20 --wrong
    bench/map_coverage.py --runs 50 --laps 30 --set wheel.slip_share=0
    bench/map_coverage.py --runs 12 --laps 6 --wander 0.15 --abreast 0.2
"""

from __future__ import annotations

import math
from functools import partial
from typing import Any

import numpy as np

from gprodom.benchmark.monte_carlo import estimate_told, judge
from gprodom.simulate.drives import drive_on_known_ground, laps_drive, wrong_revisits
from program import add_seeds, exit_with, in_processes, list_of, parser_of, print_figures, seeds_of

WANDER_M = 0.1  # to either side of the track, in laps
ELLIPSE = -2 * math.log(0.05)  # chi-square of 2 degrees of freedom, 95 %


def drive(
    seed: int,
    overrides: list[str],
    wrong: bool,
    laps: int = 0,
    wander: float = WANDER_M,
    abreast: float = 0.0,
    one: bool = False,
) -> dict[str, Any]:
    """One run. nees: of x, y in map, at moments a second apart from the first revisit on; end_m:
    error at the end; rms_m: of all moments; moved_m: of the final pose, by wrong revisits."""
    run = laps_drive(seed, laps, wander, abreast) if laps else drive_on_known_ground(seed)
    if abreast > 0:
        places = {0: [0, abreast / 2, 0]} | ({} if one else {1: [0, -abreast / 2, 0]})
        overrides = [f"gpr.antennas={places}", *overrides]
    [outputs] = estimate_told(run, overrides)
    pose = outputs.odometry_map
    time = pose["time"]
    first = outputs.corrections[0]["time"] if outputs.corrections else time[-1]
    moments = np.unique(np.append(np.searchsorted(time, np.arange(first, time[-1], 10**9)),
                                  len(time) - 1))  # fmt: skip
    truth = run.position_from(time[0] // 1000, time[moments] // 1000)
    error = pose["position"][moments, :2] - truth
    covariance = pose["pose_covariance"][moments].reshape(-1, 6, 6)[:, :2, :2]
    nees = np.einsum("ni,ni->n", error, np.linalg.solve(covariance, error[:, :, None])[:, :, 0])
    moved = 0.0
    if wrong:
        other = estimate_told(run, overrides, wrong_revisits(run))[-1].odometry_map["position"][-1]
        moved = float(np.linalg.norm(other - pose["position"][-1]))
    revisits = outputs.corrections[-1]["revisits"] if outputs.corrections else 0
    rms = float(np.sqrt(np.mean(np.sum(error**2, axis=1))))
    found = {"seed": seed, "revisits": revisits, "nees": nees.tolist()}
    return found | {"end_m": float(np.linalg.norm(error[-1])), "rms_m": rms, "moved_m": moved}


def summarise(drives: list[dict[str, Any]], wrong: bool) -> dict[str, Any]:
    """The figures of ``--json``."""
    tied = [run for run in drives if run["revisits"] > 0]
    inside = np.concatenate([np.array(run["nees"]) <= ELLIPSE for run in tied])
    ends = [run["nees"][-1] for run in drives]
    end = judge(ends, 2, 0.95)
    figures: dict[str, Any] = {
        "runs": len(drives),
        "with_revisits": len(tied),
        "revisits_mean": float(np.mean([run["revisits"] for run in drives])),
        "coverage_end": float(np.mean(np.array(ends) <= ELLIPSE)),
        "coverage_all": float(inside.mean()),
        **{f"nees_end_{key}": end[key] for key in ("mean", "low", "high")},
        "nees_all_mean": float(np.mean([np.mean(run["nees"]) for run in tied])),
        "end_m_rms": float(np.sqrt(np.mean([run["end_m"] ** 2 for run in drives]))),
        "all_m_rms": float(np.sqrt(np.mean([run["rms_m"] ** 2 for run in drives]))),
    }
    if wrong:
        moved = [run["moved_m"] for run in drives]
        figures |= {"moved_m_max": max(moved), "moved_m_median": float(np.median(moved))}
    return figures


def main() -> None:
    """Runs the command line."""
    parser = parser_of(__doc__, jobs=2, overrides=True)
    add_seeds(parser, "--runs", 100)
    parser.add_argument("--laps", type=int, default=0, metavar="N", help="laps, instead")
    parser.add_argument(
        "--wander", type=float, default=WANDER_M, metavar="M", help="default: %(default)s"
    )
    parser.add_argument("--abreast", type=float, default=0.0, metavar="M", help="two antennas")
    parser.add_argument("--one", action="store_true", help="of these, the left one alone")
    parser.add_argument("--wrong", action="store_true", help="wrong revisits besides")
    args = parser.parse_args()
    if args.abreast > 0 and args.laps == 0:
        parser.error("--abreast: expected with --laps")
    if args.one and args.abreast == 0:
        parser.error("--one: expected with --abreast")
    chosen = ("overrides", "wrong", "laps", "wander", "abreast", "one")
    work = partial(drive, **{name: getattr(args, name) for name in chosen})
    drives = in_processes(args.jobs, "drives", work, seeds_of(args))
    figures = summarise(drives, args.wrong)
    print_figures(args, figures | {"drives": drives}, list_of(figures))


if __name__ == "__main__":
    exit_with(main)
