"""Each fault of a receiver, in the middle of a drive with good fixes: errors from its begin on."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from typing import Any

import drives
import numpy as np

from gprodom.fixes.made import CENTIMETRES, FAULTS, fixes_of_truth, in_degrees, with_fault
from program import seeds_of

NAMES = ("wid02", "f1tenth3")
BEGIN, END = 0.4, 0.6  # of the time in which the truth is known
OURS = "fix"  # is in each reason of STATUS that is of fixes


def run(args: argparse.Namespace) -> list[dict[str, Any]]:
    """A row for each recording, fault and seed; `healthy` is without one."""
    rows = []
    for drive, bare in drives.each_of(args.only or NAMES, args.data, args.overrides):
        for seed in seeds_of(args):
            rows += _of_drive(drive, bare, seed, args.overrides)
    return rows


def _of_drive(
    drive: drives.Drive, bare: drives.Run, seed: int, overrides: Sequence[str]
) -> list[dict[str, Any]]:
    fixes = fixes_of_truth(drive.truth, CENTIMETRES, seed)
    begin, end = (
        int(np.interp(share, [0, 1], drive.truth.time[[0, -1]])) for share in (BEGIN, END)
    )
    since = drive.truth.time >= begin
    rows, usual = [], set[str]()
    for fault in ("healthy", *FAULTS):
        given = in_degrees(fixes)
        if fault != "healthy":
            given = with_fault(in_degrees(fixes), fault, begin, end, seed)
        found = drives.run(drive, given, overrides)
        told = [(time, why) for time, why in found.reasons if OURS in why.lower()]
        if fault == "healthy":
            usual = {why for _, why in told}
        told = [(time, why) for time, why in told if time >= begin and why not in usual]
        row: dict[str, Any] = {"recording": drive.name, "fault": fault, "seed": seed}
        for mode in ("smoothed", "causal"):
            with_fixes, without = (
                drives.error(getattr(each, mode), drive.truth, since, since)
                for each in (found, bare)
            )
            row |= {f"{mode}_m": with_fixes, f"{mode}_over": with_fixes / without}
        row["named"] = told[0][1] if told else ""
        row["after_s"] = (told[0][0] - begin) * 1e-6 if told else None
        rows.append(row)
    return rows
