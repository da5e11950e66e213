#!/usr/bin/env python3
"""A network live beside the daemon: how late its answers are, and whether live equals replay.

LOG is played at real time to gprodomd and, beside it, `gprodom infer DIR`, in a network of their
own (scripts/live). What was said and heard is recorded; of that record the inputs, the network's
answers among them, are replayed. Printed are the answers, the milliseconds from a message to its
answer, the poses compared, and the largest distance of ODOMETRY between both. Exit code 1 where
that is over a centimetre or the 99th percentile of the answers is over half of time.reorder_window.

    bench/learned_live.py networks LOG.lcmlog --method learned_sequential
"""

from __future__ import annotations

import json
import os
import shlex
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from gprodom.config import default_config
from gprodom.errors import Error
from gprodom.lcm import logs
from gprodom.learned.model import NETWORKS
from gprodom.odometry.replay import run_replay
from live_against_replay import LIMIT_M, LIVE, positions
from program import exit_with, parser_of, print_figures, table_of

REORDER_MS = 350.0  # time.reorder_window


def measure(networks: Path, log: Path, method: str, folder: Path) -> dict[str, Any]:
    """One log live with the network, and replayed."""
    live, replayed, said = (folder / name for name in ("live.lcmlog", "replay.lcmlog", "said.json"))
    infer = [sys.executable, "-m", "gprodom", "infer", str(networks.resolve())]
    infer += ["--method", method, "--json"]
    beside = f"{shlex.join(infer)} > {shlex.quote(str(said))}"
    command = [str(LIVE), str(default_config()), str(log), str(live), "1"]
    ran = subprocess.run(
        command, capture_output=True, text=True, env={**os.environ, "GPRODOM_BESIDE": beside}
    )
    if ran.returncode != 0 or not said.is_file():
        raise Error(f"{log.name}: scripts/live: {ran.stderr.strip()}")
    run_replay(live, replayed)
    live_times, live_m = positions(live)
    replay_times, replay_m = positions(replayed)
    _, i, j = np.intersect1d(live_times, replay_times, return_indices=True)
    apart = np.linalg.norm(live_m[i] - replay_m[j], axis=1)
    heard = logs.read(live, ["GPR_DISPLACEMENT_IN"]).get("GPR_DISPLACEMENT_IN")
    return {
        "log": log.name,
        "method": method,
        **json.loads(said.read_text()),
        "recorded": 0 if heard is None else len(heard["utime"]),
        "compared": len(i),
        "max_apart_m": float(apart.max()),
    }


def main() -> int:
    """Runs the command line."""
    parser = parser_of(__doc__)
    parser.add_argument("networks", type=Path, metavar="DIR", help="of gprodom learn")
    parser.add_argument("log", type=Path, metavar="LOG.lcmlog")
    parser.add_argument("--method", choices=NETWORKS, default=NETWORKS[0])
    args = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="gprodom-") as folder:
        found = measure(args.networks, args.log, args.method, Path(folder))
    print_figures(args, found, table_of([found]))
    late = found["p99_ms"] is None or found["p99_ms"] > REORDER_MS / 2
    return int(late or found["max_apart_m"] > LIMIT_M)


if __name__ == "__main__":
    exit_with(main)
