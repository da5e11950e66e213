"""Fixes at the begin and the end of the way."""

from __future__ import annotations

import argparse
from itertools import product
from typing import Any

import drives

from gprodom.fixes.made import CENTIMETRES, ENDS, METRES, fixes_of_truth, share_of_way, within
from program import seeds_of

NAMES = ("wid02", "wid09", "f1tenth3")
NOISES = {"3 cm": CENTIMETRES, "1 m": METRES}


def run(args: argparse.Namespace) -> list[dict[str, Any]]:
    """A row for each recording, noise and seed."""
    rows = []
    for drive, bare in drives.each_of(args.only or NAMES, args.data, args.overrides):
        fixed = within(share_of_way(drive.truth, drive.truth.time), ENDS)
        for noise, seed in product(NOISES, seeds_of(args)):
            fixes = fixes_of_truth(drive.truth, NOISES[noise], seed)
            fixes = fixes.select(within(share_of_way(drive.truth, fixes.utime), ENDS))
            helped = drives.run(drive, fixes, args.overrides)
            row = {"recording": drive.name, "noise": noise, "seed": seed, "fixes": len(fixes)}
            rows.append(row | drives.compare(drive, bare, helped, ~fixed, fixed))
    return rows
