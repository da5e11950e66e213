#!/usr/bin/env python3
"""The map of before, or the new one, is there and loads, whatever happens to the estimator.

A short simulated drive leaves a map. Then the robot drives on over other ground, with savings every
fifth of a second of data, and at a random moment, --moments times each:

  kill     the program is killed (SIGKILL)
  disk     from a random write on, for a random number of them, the disk is full (ENOSPC)
  format   the radar sends traces of another length, for a while or for good
  cut      the power fails: the system calls up to that moment are replayed, and what was not
           synchronised to disk by then is lost, or a part of it (power_cuts.py)

After each, ground.map is read as the next run does: it must be sound, have all ground of before,
and nothing must have been set aside. Exit code 1 where one is not. Needs strace. Exceptions and
reloads: map_restarts.py.

    bench/map_faults.py --moments 200 --json
"""

from __future__ import annotations

import argparse
import random
import shutil
import subprocess
import sys
import time
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

import power_cuts
from gprodom import Odometry
from gprodom.errors import Error
from gprodom.files import temporary_folder
from gprodom.map.ground import read_map
from gprodom.random_streams import stream
from gprodom.simulate.recording import as_recording
from gprodom.simulate.routes import make_route
from gprodom.simulate.sequence import Spec, simulate
from program import exit_with, parser_of, print_figures, table_of

CHECKOUT = Path(__file__).resolve().parents[1]
DRIVE_M = 14.0
LATER_NS = 10**12  # the second drive begins so much later
SAVE_PERIOD_S = 0.02  # newest ground every 0.2 s, the whole of it every 6 s
SHORTER = 150  # samples of a trace of the other setting
OF_TIMES = {
    "imu_time": ("acceleration", "angular_velocity"),
    "wheel_time": ("wheel_distance",),
    "gpr_time": ("traces",),
}
BLOCKED = ["strace", "-f", "-qq", "-o", "/dev/null", "-e", "trace=write,writev"]


def pieces(told: dict[str, Any], edges: list[int]) -> list[dict[str, Any]]:
    """The messages of a drive, split at stamps (ns)."""
    found = []
    for since, until in zip([0, *edges], [*edges, 2**62], strict=True):
        piece = dict(told)
        for time_name, names in OF_TIMES.items():
            part = slice(*np.searchsorted(told[time_name], [since, until]))
            for name in (time_name, *names):
                piece[name] = told[name][part]
        found.append(piece)
    return found


def drive(messages: Path, state: Path, edges: list[int]) -> None:
    """A drive through an estimator. edges: stamps between which traces are shorter, if any."""
    told = {
        name: value if value.ndim else float(value) for name, value in np.load(messages).items()
    }
    settings = [f"state.directory={state}", f"state.save_period={SAVE_PERIOD_S}"]
    estimator = Odometry(set=settings)
    for number, piece in enumerate(pieces(told, edges)):
        if number == 1:
            piece["traces"] = piece["traces"][:, :SHORTER]
        estimator.run(**piece)


@dataclass(frozen=True)
class Ground:
    """What every moment begins with: the messages of the second drive, the folder that the first
    has left, how long its map is, and how long the second drive takes (s)."""

    messages: Path
    state: Path
    length_m: float
    drive_s: float

    def command(self, state: Path, edges: list[int] | None = None) -> list[str]:
        """The second drive as a process."""
        again = [sys.executable, __file__, "--drive", str(self.messages), str(state)]
        return [*again, *map(str, edges or [])]


def prepared(folder: Path) -> Ground:
    """Makes the drives and the map."""
    state = folder / "state"
    state.mkdir()
    for seed, name in ((1, "before"), (2, "after")):
        route = make_route("loop", DRIVE_M, 0.7, 3.0, stream(seed, "route"))
        told = as_recording(simulate(Spec(route, station=None), seed)).messages()
        for time_name in OF_TIMES:
            told[time_name] = told[time_name] + LATER_NS * seed
        np.savez(folder / f"{name}.npz", **told)
    drive(folder / "before.npz", state, [])
    ground = Ground(folder / "after.npz", state, read_map(state / "ground.map").length_m, 0.0)
    begun = time.monotonic()
    shutil.copytree(state, folder / "clean")
    subprocess.run(ground.command(folder / "clean"), check=True)
    took = time.monotonic() - begun
    assert read_map(folder / "clean" / "ground.map").length_m > ground.length_m + 3.0
    return Ground(ground.messages, state, ground.length_m, took)


def fault_of(state: Path, length_m: float) -> str:
    """What is wrong with the map in a folder; empty: nothing."""
    if not (state / "ground.map").is_file():
        return "there is no ground.map"
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            found = read_map(state / "ground.map").length_m
    except Exception as error:  # whatever it is, it is the finding
        return f"ground.map: {error}"
    kept = [path.name for path in state.glob("*.kept-*")]
    if kept:
        return f"set aside: {', '.join(kept)}"
    return "" if found >= length_m - 1e-6 else f"{found:.1f} m of {length_m:.1f} m are left"


def kill(ground: Ground, state: Path, chance: random.Random) -> str:
    """SIGKILL at any time of the drive."""
    with subprocess.Popen(ground.command(state)) as process:
        time.sleep(chance.uniform(0.0, ground.drive_s))
        process.kill()
    return fault_of(state, ground.length_m)


def full_disk(ground: Ground, state: Path, chance: random.Random) -> str:
    """No write succeeds for a while."""
    first = chance.randint(1, 400)
    when = f"{first}..{first + chance.randint(0, 400)}"
    block = [*BLOCKED, "-e", f"inject=write,writev:error=ENOSPC:when={when}"]
    subprocess.run([*block, *ground.command(state)], stderr=subprocess.DEVNULL, check=False)
    return fault_of(state, ground.length_m)


def changed_format(ground: Ground, state: Path, chance: random.Random) -> str:
    """Traces of another length: one, some, or all to the end."""
    times = np.load(ground.messages)["gpr_time"]
    first = chance.randrange(len(times))
    length = chance.choice([1, chance.randint(2, 100), len(times)])
    edges = [int(times[first]), int(times[min(first + length, len(times) - 1)]) + 1]
    subprocess.run(ground.command(state, edges), check=True)
    return fault_of(state, ground.length_m)


def power_cut(ground: Ground, state: Path, chance: random.Random) -> str:
    """The files as they are when the power is back."""
    folder = ground.messages.parent / "recorded"
    if not folder.exists():
        shutil.copytree(ground.state, folder)
        RECORDED.extend(power_cuts.record(ground.command(folder), folder, folder.parent / "calls"))
    before = {path.name: path.read_bytes() for path in ground.state.iterdir()}
    at = chance.randint(0, len(RECORDED))
    shutil.rmtree(state)
    state.mkdir()
    for name, data in power_cuts.cut(before, RECORDED, at, folder, chance).items():
        (state / name).write_bytes(data)
    return fault_of(state, ground.length_m)


RECORDED: list[power_cuts.Call] = []
FAULTS: dict[str, Callable[[Ground, Path, random.Random], str]] = {
    "kill": kill,
    "disk": full_disk,
    "format": changed_format,
    "cut": power_cut,
}


def measure(name: str, ground: Ground, moments: int, seed: int) -> dict[str, Any]:
    """A fault at so many moments."""
    chance = random.Random(f"{name} {seed}")
    faults = []
    for moment in range(moments):
        with temporary_folder() as folder:
            state = folder / "state"
            shutil.copytree(ground.state, state)
            said = FAULTS[name](ground, state, chance)
        if said:
            faults.append(f"moment {moment}: {said}")
    return {"fault": name, "moments": moments, "kept": moments - len(faults), "lost": faults}


def main() -> int:
    """Runs the command line."""
    parser = parser_of(__doc__)
    parser.add_argument("--moments", type=int, default=200, metavar="N", help="default: 200")
    parser.add_argument("--only", nargs="+", choices=FAULTS, default=list(FAULTS), metavar="FAULT")
    parser.add_argument("--seed", type=int, default=1, help="of the moments (default: 1)")
    parser.add_argument("--drive", nargs="+", metavar="ARG", help=argparse.SUPPRESS)
    args = parser.parse_args()
    if args.drive:
        messages, state, *edges = args.drive
        drive(Path(messages), Path(state), [int(edge) for edge in edges])
        return 0
    if not shutil.which("strace"):
        raise Error("needs strace (debian/control names it)")
    with temporary_folder() as folder:
        ground = prepared(folder)
        found = [measure(name, ground, args.moments, args.seed) for name in args.only]
    print_figures(args, {"faults": found}, table_of(found))
    return 1 if any(each["lost"] for each in found) else 0


if __name__ == "__main__":
    exit_with(main)
