#!/usr/bin/env python3
"""The fixed-lag window against one solution over all data: what marginalising costs.

At ten instants of each sequence the newest state's position (3-D) from the window is compared with
that of the batch solution over the data up to then, over the same factors, every row quadratic.

    bench/window_against_batch.py SEQ...
    bench/window_against_batch.py SEQ... --set smoother.lag=10 --json
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import numpy as np

import gprodom
from gprodom.console import Progress, add_json_flag, format_table, print_json
from gprodom.convert.cmu import Recording, read_recording
from gprodom.errors import Error
from gprodom.score.record import sequence_name

# Revisits are in the solution over all data alone.
QUADRATIC = ["wheel.robust_threshold=0", "graph.enabled=false"]
INSTANTS = 10


def difference(recording: Recording, until: int, overrides: list[str]) -> float:
    """Metres between the two at `until` (us)."""
    odometry = gprodom.Odometry(set=[*QUADRATIC, *overrides])
    odometry.record()
    odometry.run(**recording.messages(until=until))
    newest = [solution["position"][-1] for solution in (odometry.recorded(), odometry.smoothed())]
    return float(np.linalg.norm(newest[0] - newest[1]))


def main() -> int:
    """Runs the command line."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("sequences", nargs="+", type=Path, metavar="SEQ")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", dest="overrides")
    add_json_flag(parser)
    args = parser.parse_args()
    results = []
    try:
        with Progress("instants", float(INSTANTS * len(args.sequences))) as progress:
            for sequence in args.sequences:
                recording = read_recording(sequence)
                ends = np.linspace(*recording.imu_utime[[0, -1]], INSTANTS + 1)[1:]
                found = []
                for until in ends.astype(np.int64):
                    found.append(difference(recording, int(until), args.overrides))
                    progress.advance()
                results.append({"sequence": sequence_name(sequence), "metres": found})
    except Error as error:
        print(f"window_against_batch: error: {error}", file=sys.stderr)
        return 1
    if args.json:
        print_json(results)
        return 0
    rows: list[list[object]] = []
    for result in results:
        centimetres = 100 * np.sort(result["metres"])
        rows.append([result["sequence"], *(float(cm) for cm in centimetres[-1:-4:-1])])
    print(format_table(["sequence", "worst (cm)", "second", "third"], rows))
    return 0


if __name__ == "__main__":
    sys.exit(main())
