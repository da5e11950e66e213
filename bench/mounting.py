#!/usr/bin/env python3
"""A wrong imu.rpy_body_imu: is it told, after how long, and is a right one left alone?

Each SEQUENCE (zip, folder or LCM log) is replayed (`imu_wheel`) as it is, and with the IMU turned
from how it sits by the angles of the columns: about x (roll) or about z (yaw), degrees. A cell says
after how many seconds of data STATUS first gave the reason "IMU mounting", and until when, where it
took that back before the end. --mount: how the IMU sits; --find: as calibrate mount finds it.

Exit code 1 where a right mounting is told.

    bench/mounting.py ../shared/data/cmu_like/*.zip ../shared/data/rough/*.zip
    bench/mounting.py husky.lcmlog --find
"""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from estimates import mount_in
from gprodom.calibrate.mount import rpy_of
from gprodom.commission.parameter import listed
from gprodom.config import STANDARD
from gprodom.lcm import logs
from gprodom.odometry.estimate import as_log
from gprodom.odometry.methods import find_method
from gprodom.odometry.replay import run_replay
from gprodom.simulate.imu import rotation_from_rpy
from program import exit_with, one_by_one, parser_of, print_figures, table_of

CASES = {
    "right": (0, 0),
    "yaw 20": (0, 20),
    "yaw -20": (0, -20),
    "yaw 90": (0, 90),
    "yaw 180": (0, 180),
    "roll 20": (20, 0),
    "roll 90": (90, 0),
    "roll 180": (180, 0),
}


def told(log: Path, output: Path, settings: Sequence[str]) -> list[float]:
    """Seconds of data at which STATUS begins, and ends, to tell of the mounting."""
    run_replay(log, output, (), [*find_method("imu_wheel").overrides, *settings])
    status = logs.read(output, ["STATUS"])["STATUS"]
    imu = logs.read_roles(log, STANDARD.of("imu"))["imu"]
    changes: list[float] = []
    for message in status["messages"]:
        tells = any(reason.startswith("IMU mounting") for reason in message.reasons)
        if tells == (len(changes) % 2 == 0):
            changes.append((message.utime - int(imu["utime"][0])) * 1e-6)
    return changes


def measure(
    sequence: Path, cases: Sequence[str], mount: Sequence[float] | None, overrides: Sequence[str]
) -> dict[str, list[float]]:
    """Of one sequence, by case. mount: None: it is looked for."""
    with tempfile.TemporaryDirectory(prefix="gprodom-") as name:
        folder = Path(name)
        log = as_log(sequence, folder)
        if mount is None:
            mount = mount_in(log).rpy
        sits, found = rotation_from_rpy(tuple(mount)), {}
        for case in cases:
            roll, yaw = np.radians(CASES[case])
            angles = listed(rpy_of(rotation_from_rpy((roll, 0, yaw)) @ sits), 5)
            setting = f"imu.rpy_body_imu={angles}"
            found[case] = told(log, folder / "out.lcmlog", [*overrides, setting])
    return found


def main() -> int:
    """Runs the command line."""
    parser = parser_of(__doc__, overrides=True)
    parser.add_argument("sequences", nargs="+", type=Path, metavar="SEQUENCE")
    parser.add_argument("--mount", type=float, nargs=3, default=[0, 0, 0], metavar="RAD")
    parser.add_argument("--find", action="store_true", help="as gprodom calibrate mount does")
    parser.add_argument("--case", action="append", choices=CASES, help="default: all")
    args = parser.parse_args()
    mount, cases = None if args.find else args.mount, args.case or list(CASES)
    found: dict[str, dict[str, list[float]]] = {}
    for sequence in one_by_one("mountings", args.sequences):
        found[sequence.stem] = measure(sequence, cases, mount, args.overrides)
    rows = [
        {"sequence": name} | {case: " to ".join(f"{s:.0f}" for s in of[case]) for case in cases}
        for name, of in found.items()
    ]
    print_figures(args, found, table_of(rows))
    return 1 if any(of.get("right") for of in found.values()) else 0


if __name__ == "__main__":
    exit_with(main)
