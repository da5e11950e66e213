"""The Husky's own GPS, of which a minute is withheld."""

from __future__ import annotations

import argparse
from typing import Any

import drives
import numpy as np

from gprodom.fixes.record import Fixes, Frame, Quality, diagonal
from gprodom.trajectory import path_length

SECONDS = 60.0
GPS_SIGMA_M = 0.9  # of a horizontal axis, by the receiver's own word


def run(args: argparse.Namespace) -> list[dict[str, Any]]:
    """One row. The minute is that in which the robot drives farthest."""
    rows = []
    for drive, bare in drives.each_of(["husky"], args.data, args.overrides):
        time, way = drive.truth.time, path_length(drive.truth.position[:, :2], 0.5)
        later = np.interp(time + SECONDS * 1e6, time, way, right=np.nan)
        begin = int(time[np.nanargmax(later - way)])
        hidden = (time >= begin) & (time < begin + SECONDS * 1e6)
        # The truth is /fix in metres from its first.
        sigmas = np.tile([GPS_SIGMA_M, GPS_SIGMA_M, 2 * GPS_SIGMA_M], (len(time), 1))
        quality = np.full(len(time), int(Quality.SINGLE), np.int64)
        fixes = Fixes(time, Frame.SITE, drive.truth.position, diagonal(sigmas), quality)
        fixes = fixes.select(~hidden)
        helped = drives.run(drive, fixes, args.overrides)
        found = drives.compare(drive, bare, helped, hidden, ~hidden)
        row = {"recording": "husky", "withheld_s": SECONDS, "gps_sigma_m": GPS_SIGMA_M}
        row["driven_m"] = float(np.ptp(way[hidden]))
        rows.append(row | found)
    return rows
