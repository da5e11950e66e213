#!/usr/bin/env python3
"""Is a robot located on real ground in the map of another line or another day?

Robot, IMU and wheel are simulated, the ground is real (data/README.md of the shared data).

    beach    the map is of Seal Beach line n, the drive goes to and fro on line n + 1, 20 cm aside.
             Its travel times are stretched by a percentage and its traces filtered to another
             pulse: a stand-in for another day and another radar, made by computing. Once without a
             prior, once told where it begins (0.5 m)
    field    the map is of a line driven there, the drive comes back on it, and goes there again
    strangers  the drive is on another line of the field, 60 cm away or more, with travel times
             as they are: to be located there is false

    located          somewhere in the map; right: within half a metre at the end
    along the track  error against the poses of the map's own drive while located rightly, RMS; on
                     the beach less its mean in each drive, as the lines begin up to 25 cm apart

    bench/real_another_day.py ../shared/data
    bench/real_another_day.py ../shared/data --lines 2 --strangers 2 --change 0 --json
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise, product
from pathlib import Path
from typing import Any

import numpy as np

import gprodom
from gprodom.arrays import Floats
from gprodom.files import temporary_folder
from gprodom.ground.survey import to_counts
from gprodom.simulate import Simulated, Spec, simulate, stream
from gprodom.simulate import radar as radar_of
from gprodom.simulate.drive import Bend, DriveSpec, Move, Stop, Track
from gprodom.simulate.radar import RadarSpec
from gprodom.simulate.recording import as_recording
from program import exit_with, one_by_one, parser_of, print_rows
from relocation import Visit, visited

TOLD_SIGMA = 0.5  # m
SPEED = 0.5  # m/s
FINER = 8  # samples made of one, to take traces at other times
PULSE_CENTRE, PULSE_WIDTH, PULSE_TURN = 0.85, 0.5, 0.7  # of the centre frequency; rad
FARTHEST, NEAREST = 40, 3  # lines of the field between a map and a stranger


@dataclass(frozen=True)
class Line:
    """Traces (n, samples), counts, every `spacing` m of real ground."""

    traces: Floats
    spacing: float
    sample_interval: float  # s

    @property
    def length(self) -> float:
        """m."""
        return (len(self.traces) - 1) * self.spacing


def read_beach(folder: Path, number: int) -> Line:
    """A Seal Beach line; its few glitches are cut."""
    with np.load(folder / "real_ground" / "seal_beach" / f"line_{number:02d}.npz") as data:
        traces = data["traces"].astype(float)
        most = np.quantile(np.abs(traces), 0.9999)
        counts = to_counts(np.clip(traces, -most, most)).astype(float)
        return Line(counts, float(data["spacing"]), float(data["sample_interval"]))


def read_field(folder: Path) -> list[Line]:
    """The parallel lines, 20 cm apart."""
    with np.load(folder / "real_ground" / "field" / "lines.npz") as data:
        counts = to_counts(data["traces"].astype(float)).astype(float)
        return [Line(one, float(data["spacing"]), float(data["sample_interval"])) for one in counts]


def another_day(line: Line, percent: float) -> Line:
    """Travel times from the direct wave on longer by `percent`, and another pulse."""
    samples = line.traces.shape[1]
    spectrum = np.fft.rfft(line.traces, 2 * samples, axis=1)
    frequency = np.arange(samples + 1)
    power = np.sum(np.abs(spectrum) ** 2, axis=0)
    centre = np.sum(frequency * power) / np.sum(power)
    off = (frequency / centre - PULSE_CENTRE) / PULSE_WIDTH
    spectrum *= np.exp(-0.5 * off**2 + 1j * PULSE_TURN)
    fine = FINER * np.fft.irfft(spectrum, 2 * samples * FINER, axis=1)
    direct = float(np.argmax(np.abs(line.traces.mean(axis=0))))
    at = np.arange(samples, dtype=float)
    later = at > direct
    at[later] = direct + (at[later] - direct) / (1 + percent / 100)
    place = np.minimum(at, samples - 1) * FINER
    traces = np.array([np.interp(place, np.arange(fine.shape[1]), one) for one in fine])
    return replace(line, traces=traces)


def drive(line: Line, back: bool, legs: int, seed: int) -> tuple[Simulated, Floats]:
    """Along the line, from its far end if `back`, and returning at its end. Returns the place on
    the line, m, at each time of the truth, too."""
    length = line.length - 0.1
    moves = [s for i in range(legs) for s in (Move((-1) ** i * length, SPEED), Stop(2.0))]
    radar = RadarSpec()
    spec = Spec(
        DriveSpec(Track((Bend(length),)), (Stop(4.0), *moves)),
        radar=radar, ground=None, station=None,
    )  # fmt: skip
    run = simulate(spec, seed)
    utime = np.arange(run.truth_utime[0], run.truth_utime[-1], int(1e6 / radar.rate))

    def place(times: Any) -> Floats:
        along = np.interp(times, run.truth_utime, run.truth.s)
        return np.clip(length - along if back else along, 0.0, line.length)

    number = place(utime) / line.spacing
    first = np.minimum(number.astype(int), len(line.traces) - 2)
    part = (number - first)[:, None]
    clean = (1 - part) * line.traces[first] + part * line.traces[first + 1]
    time = (utime - utime[0]) * 1e-6
    traces = radar_of.measure(clean, time, line.sample_interval, radar, stream(seed, "radar"))
    run = replace(run, gpr_utime=utime, traces=traces, sample_interval=line.sample_interval)
    return run, place(run.truth_utime)


@dataclass(frozen=True)
class Known:
    """The map of a line: where it has each place on the line."""

    path: Path
    place: Floats  # m along the line
    position: Floats  # (n, 2), m, in map


def save_map(line: Line, seed: int, where: Path) -> Known:
    """Of the line driven there."""
    run, place = drive(line, False, 1, seed)
    estimator = gprodom.Odometry()
    pose = estimator.run(**as_recording(run).messages()).odometry_map
    estimator.reset()
    estimator.save_map(str(where))
    at = np.interp(pose["time"] // 1000, run.truth_utime, place)
    return Known(where, at, pose["position"][:, :2])


def visit(line: Line, back: bool, seed: int, known: Known, told: bool = False) -> Visit:
    """Drives on a line with the map. told: about where it begins."""
    run, there = drive(line, back, 3 - back, seed)
    estimator = gprodom.Odometry()
    estimator.load_map(str(known.path))
    if told:
        estimator.locate_at(0.0, 0.0, 0.0, TOLD_SIGMA)
    outputs = estimator.run(**as_recording(run).messages())
    pose = outputs.odometry_map
    place = np.interp(pose["time"] // 1000, run.truth_utime, there)
    right = np.column_stack([np.interp(place, known.place, axis) for axis in known.position.T])
    off = pose["position"][:, :2] - right
    return visited(run, outputs, off, off[:, 0])


def summarise(name: str, found: list[Visit]) -> dict[str, Any]:
    """The figures of one kind of drive: of strangers none is right; lines of the beach do not begin
    at the same place."""
    known = "strangers" not in name
    right = [one for one in found if one.right]
    less_mean = "beach" in name
    off = [np.array(one.along_m) - less_mean * np.mean(one.along_m) for one in right if one.along_m]
    after = [one.located_after_m for one in right if one.located_after_m is not None]
    located = sum(one.located for one in found)
    return {
        "drives": name,
        "number": len(found),
        "located": located,
        "right": len(right) if known else None,
        "false": located - (len(right) if known else 0),
        "located_after_m": float(np.median(after)) if after else None,
        "along_cm_rms": 100 * float(np.sqrt(np.mean(np.concatenate(off) ** 2))) if off else None,
    }


def main() -> None:
    """Runs the command line."""
    parser = parser_of(__doc__)
    parser.add_argument("data", type=Path, help="folder of the shared data")
    parser.add_argument("--lines", type=int, default=46, help="of each kind at most (all)")
    parser.add_argument("--strangers", type=int, default=100, help="default: %(default)s")
    parser.add_argument(
        "--change", type=float, nargs="+", default=[0.0, 10.0, -10.0],
        metavar="PERCENT", help="of travel times, on the beach (0 10 -10)",
    )  # fmt: skip
    args = parser.parse_args()
    beach = [read_beach(args.data, number) for number in range(1, 21)][: args.lines + 1]
    field = read_field(args.data)
    return_to = field[: args.lines]
    strangers = [
        (i % len(field), (i + NEAREST + (7 * i) % (FARTHEST - NEAREST)) % len(field))
        for i in range(args.strangers)
    ]
    strangers = [(a, b if abs(a - b) >= NEAREST else (a + NEAREST) % 46) for a, b in strangers]
    found: dict[str, list[Visit]] = {}
    with temporary_folder() as folder:
        where = folder / "line.map"
        for number, (line, beside) in one_by_one("beach", list(enumerate(pairwise(beach)))):
            known = save_map(line, number, where)
            for percent, told in product(args.change, (False, True)):
                name = f"beach, 20 cm aside, {percent:+g} %" + (", told" if told else "")
                again = another_day(beside, percent)
                found.setdefault(name, []).append(visit(again, False, 100 + number, known, told))
        found["field, there and back"] = [
            visit(line, True, 300 + number, save_map(line, 200 + number, where))
            for number, line in one_by_one("field", list(enumerate(return_to)))
        ]
        found["field, strangers"] = [
            visit(field[b], bool(number % 2), 600 + number, save_map(field[a], 400 + number, where))
            for number, (a, b) in one_by_one("strangers", list(enumerate(strangers)))
        ]
    print_rows(args, [summarise(name, each) for name, each in found.items()])


if __name__ == "__main__":
    exit_with(main)
