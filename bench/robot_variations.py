#!/usr/bin/env python3
"""Recordings of real robots, varied in what differs from one robot to the next.

The motion and its noise stay real; rates, delays, biases, mounting, encoder and the moment of the
start change (variations.py). Each is measured as bench/robots.py measures a recording, its IMU's
mounting found anew: error of dead reckoning and of `imu_wheel` (m), their ratio, NEES of x and y,
seconds until the start, the largest jump of `odom` (m), and what health says after the start.
Those of the IMU's place are run only where --vary names them; "given": with imu.lever_arm.

SOURCE is the folder of bench/robots.py, or a sequence or log with truth.

    bench/robot_variations.py SOURCE [--only RECORDING]... [--vary NAME]... [-j 2] [--json]
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from estimates import mount_in
from gprodom.commission.parameter import listed
from gprodom.drive.imu_mounting import matrix_of
from gprodom.errors import Error
from gprodom.files import temporary_folder
from gprodom.odometry.estimate import as_log
from gprodom.score.consistency import TruthError
from program import exit_with, in_processes, parser_of, print_figures, table_of
from recordings import Recording, chosen, convert, recordings_of
from robots import measure
from sensors import read, write
from variations import LEVER_ARMS, VARIATIONS

Row = dict[str, Any]
SEQUENCE = Recording((), TruthError(), "")


def is_folder(source: Path) -> bool:
    """Of recordings; not a sequence's."""
    return source.is_dir() and not any(source.glob("we_odom*.csv"))


def recorded(source: Path, name: str, folder: Path) -> tuple[Recording, Path]:
    """What is known of a recording, and its log, in the folder or where it is."""
    if not is_folder(source):
        return SEQUENCE, as_log(source, folder)
    recording = recordings_of(source)[name]
    log = folder / "recorded.lcmlog"
    convert(recording, source, log)
    return recording, log


def names_of(source: Path, only: Sequence[str]) -> list[str]:
    """Those of --only, or all."""
    return list(chosen(source, only)) if is_folder(source) else [source.stem]


def run(source: Path, name: str, variation: str, overrides: Sequence[str]) -> Row:
    """The figures of one variation of one recording."""
    row: Row = {"recording": name, "variation": variation}
    varied = (VARIATIONS | LEVER_ARMS)[variation]
    with temporary_folder() as folder:
        recording, log = recorded(source, name, folder)
        sensors = varied.change(read(log), np.random.default_rng(1))
        try:
            whole = write(sensors, folder / "whole.lcmlog")
            try:
                mount = mount_in(whole if varied.known else log)
            except Error:  # as found in the recording; a user measures it otherwise
                row["mounting"] = "of the recording"
                mount = mount_in(log)
            log = write(varied.cut(sensors), folder / "in.lcmlog")
            place = listed((matrix_of(mount.rpy) @ varied.arm_m).tolist())
            given = [f"imu.lever_arm={place}"] * any(varied.arm_m)
            return row | measure(recording, log, mount, [*given, *overrides], smooth=False)
        except Error as error:  # one that does not start is a row, too
            return row | {"error": str(error)}


def said(row: Row) -> Row:
    """A row for people: its numbers, and what went wrong in a few words."""
    words = row.get("error", "").splitlines()[:1] + ["mounting not found"] * ("mounting" in row)
    words += sorted({reason.split(":")[0] for reason in row.get("reasons", ())})
    numbers = {key: value for key, value in row.items() if isinstance(value, float | None)}
    return {"variation": row["variation"], **numbers, "said": "; ".join(words)[:60]}


def main() -> None:
    """Runs the command line."""
    parser = parser_of(__doc__, jobs=2, overrides=True)
    parser.add_argument("source", type=Path, metavar="SOURCE")
    parser.add_argument("--only", action="append", metavar="RECORDING", default=[])
    parser.add_argument("--vary", action="append", choices=VARIATIONS | LEVER_ARMS, default=[])
    args = parser.parse_args()
    names = names_of(args.source, args.only)
    cases = [(name, variation) for variation in args.vary or VARIATIONS for name in names]
    of, kinds = zip(*cases, strict=True)
    work = partial(run, args.source, overrides=args.overrides)
    rows = in_processes(args.jobs, "variations", work, of, kinds)
    print_figures(args, rows, table_of([said(row) for row in rows]))


if __name__ == "__main__":
    exit_with(main)
