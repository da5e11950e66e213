#!/usr/bin/env python3
"""Does `gprodom commission` find the constants of a robot, and how sure is it of them?

Robots are simulated: number i from seed i alone. One wheel, a cart, a rover, a skid steer and a car
take turns; mounting of the IMU, unit of the wheel's ticks, track, clocks and place of the antenna
are drawn. Each makes the drive that the command asks for, its straight piece measured by tape, on
ground of scatterers. For each constant: how many robots showed it, the mean and largest error over
the standard deviation that was told, and its root mean square, which is 1 where that is right; then
the processor time of the command, and the error of `imu_wheel` after it over that of `wheel` (both
plus 15 mm; `wheel` with the unit put right and no more), and whether it is at most 1.2 of that and
15 mm.

With --recordings the same on recordings of real robots (recordings.py), with what a tape measures
as it is in their table; their truth scores and is not fitted.

    bench/commission.py [--robots N] [--first SEED] [--json]
    bench/commission.py --recordings ../shared/data/robots [--only NAME]... [--json]
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from estimates import planar_figures
from gprodom import rotation
from gprodom.config import STANDARD
from gprodom.errors import Error
from gprodom.files import temporary_folder
from gprodom.lcm import logs, wire
from gprodom.lcm.log_writer import Stream, write_log
from gprodom.lcm.messages import by_fingerprint
from gprodom.odometry.dead_reckoning import wheel_and_gyro
from gprodom.odometry.estimate import estimate
from gprodom.odometry.methods import find_method
from gprodom.random_streams import stream
from gprodom.score.sources import read_truth
from gprodom.simulate.drives import guided_drive
from gprodom.simulate.ground import GroundSpec
from gprodom.simulate.imu import rotation_from_rpy
from gprodom.simulate.recording import log_streams
from gprodom.simulate.robot import KINDS, of_kind, robot
from gprodom.simulate.sequence import Simulated, Spec, simulate
from processes import children_seconds
from program import command, exit_with, one_by_one, parser_of, print_figures, table_of
from recordings import Recording, chosen, convert
from robots import UNDECIDED_M

ROBOTS = ("", "cart", "rover", "skid_steer", "car")  # one wheel, then pairs
SLOW_CAR = 2.0  # m/s: a car on a yard
TAPE_SIGMA_M = 0.01
UNITS = (0.2, 5.0)  # of metres_per_tick: times too long
CLOCK_S = 0.2  # by which stamps of a sensor are off, to either side
ARM_M = (0.8, 0.4)  # within which the antenna is, forwards and to the left
IMU_ARM_M = (0.6, 0.3, 0.5)  # within which the IMU of every other robot is; the others' is at 0


@dataclass(frozen=True)
class Robot:
    """A log of the guided drive, what is true, and what its owner says."""

    log: Path
    truth: dict[str, np.ndarray]
    stretch_m: float
    settings: tuple[str, ...]
    unit: float  # by which its ticks are said to be too long


def make(seed: int, folder: Path, radar: bool = True) -> Robot:
    """The robot of a seed. radar: with traces, which take most of the time."""
    draw = stream(seed, "commission")
    kind = ROBOTS[seed % len(ROBOTS)]
    speed = min(KINDS[kind].speed if kind else 0.6, SLOW_CAR) * draw.uniform(0.7, 1.0)
    arm = (draw.uniform(-ARM_M[0], ARM_M[0]), draw.uniform(-ARM_M[1], ARM_M[1]))
    rpy = tuple(draw.uniform(-np.pi, np.pi, 3) * (1, 0.4, 1))
    spec: Spec = robot(guided_drive(speed, seed), GroundSpec() if radar else None, antenna=arm)
    settings: tuple[str, ...] = ()
    if kind:
        spec = of_kind(kind, "floor", spec)
        assert spec.pair is not None
        track = draw.uniform(0.6, 1.4) * spec.pair.track
        spec = replace(spec, pair=replace(spec.pair, track=track))
        settings = (f"wheel.drive={KINDS[kind].drive}", f"wheel.track={track:.2f}")
    # From a stream of its own, so that all else of a robot is as without an arm.
    place = stream(seed, "imu place").uniform(-1, 1, 3) * IMU_ARM_M * (seed % 2)
    spec = replace(
        spec,
        imu=replace(
            spec.imu,
            rpy_body_imu=(rpy[0], rpy[1], rpy[2]),
            lever_arm=(float(place[0]), float(place[1]), float(place[2])),
        ),
    )
    simulated = simulate(spec, seed)
    late = {"imu": draw.uniform(-CLOCK_S, CLOCK_S), "gpr_trace": draw.uniform(-CLOCK_S, CLOCK_S)}
    unit = float(np.exp(draw.uniform(*np.log(UNITS)))) if draw.uniform() < 0.5 else 1.0
    log = folder / f"robot-{seed}.lcmlog"
    write_log(log, _disguised(simulated, late, unit))
    stretch_m = _stretch(simulated) + TAPE_SIGMA_M * draw.standard_normal()
    return Robot(log, _true(simulated, late, unit, arm), stretch_m, settings, unit)


def _disguised(simulated: Simulated, late: dict[str, float], unit: float) -> list[Stream]:
    """Its messages, with stamps that are late (s) and ticks that are said to be longer."""
    roles = {name: role for role, name in STANDARD.of("imu", "wheel", "gpr_trace").items()}
    changed = []
    for each in log_streams(simulated):
        role = roles.get(each.channel, "")
        kind = by_fingerprint()[each.payloads[0][:8]]
        fields = wire.decode(kind, each.payloads, each.channel)
        if role in ("wheel", "wheels"):
            fields["metres_per_tick"] = fields["metres_per_tick"] * unit
        shift = round(late.get(role, 0.0) * 1e6)
        fields["utime"] = fields["utime"] + shift
        payloads = wire.encode(kind, fields, len(each.utime))
        changed.append(Stream(each.channel, each.utime + shift, payloads))
    return changed


def _stretch(simulated: Simulated) -> float:
    """The first move, m."""
    begin, end = simulated.drive.standstills()[:2]
    motion = simulated.drive.at(np.array([begin[2], end[1]]))
    return float(np.hypot(np.diff(motion.x), np.diff(motion.y))[0])


def _true(
    simulated: Simulated, late: dict[str, float], unit: float, arm: tuple[float, float]
) -> dict[str, np.ndarray]:
    spec = simulated.spec
    scale = unit * float(simulated.wheel.scale[0])
    true = {
        "time offset of the IMU": np.array([-late["imu"]]),
        "wheel scale, by accelerations": np.array([scale]),
        "wheel scale, by the stretch": np.array([scale]),
        "mounting of the IMU": np.array(spec.imu.rpy_body_imu),
        "lever arm of the IMU": np.array(spec.imu.lever_arm[:2]),
        "noise of the gyro": np.array([spec.imu.gyro_noise_density]),
        "noise of the accelerometer": np.array([spec.imu.accel_noise_density]),
        "time offset of the radar": np.array([-late["gpr_trace"]]),
        "antenna to the left": np.array([arm[1]]),
    }
    if simulated.pair is not None and spec.pair is not None:
        if spec.pair.held or spec.pair.late:
            wheel_late = spec.pair.late + spec.pair.held
            true["time offset of the IMU"] = true["time offset of the IMU"] + wheel_late
            true["time offset of the radar"] = true["time offset of the radar"] + wheel_late
        true["track"] = np.array([simulated.pair.track])
    if spec.imu.accel_idle:  # an engine's shaking is no white noise
        del true["noise of the gyro"], true["noise of the accelerometer"]
    return true


def commission(log: Path, more: Sequence[str], folder: Path) -> tuple[dict[str, Any], float]:
    """What the command prints with --json, and its processor time, s."""
    began = time.process_time() + children_seconds()
    outputs = ("-o", folder / "found.yaml", "--page", folder / "found.html")
    told = command("commission", log, *outputs, "--json", *more)
    return json.loads(told), time.process_time() + children_seconds() - began


def deviations(told: dict[str, Any], true: dict[str, np.ndarray]) -> dict[str, list[float]]:
    """By constant: error over its standard deviation, of each number."""
    found = {}
    for each in told["parameters"]:
        name = each["name"]
        if name not in true or not each["value"]:
            continue
        value, sigma = np.array(each["value"]), np.array(each["sigma"])
        error = value - true[name]
        if name == "mounting of the IMU":  # as turns about the body's axes
            turned_by = rotation_from_rpy(tuple(value)) @ rotation_from_rpy(tuple(true[name])).T
            error = rotation.to_vector(rotation.from_matrix(turned_by))
        found[name] = (error / sigma).tolist()
    return found


def errors_after(log: Path, folder: Path, unit: float = 1.0) -> dict[str, Any]:
    """RMS errors, m, against the log's positions: of `wheel`, with the unit of its ticks put right,
    and of `imu_wheel` with the configuration that was found, from the start of that on."""
    truth = read_truth(log, frame=None).trajectory
    sensors = logs.read_roles(log, STANDARD.of("imu", "wheel"))
    wheel = sensors["wheels" if "wheels" in sensors else "wheel"]
    wheel["metres_per_tick"] = wheel["metres_per_tick"] / unit
    method, configs = find_method("imu_wheel"), (folder / "found.yaml",)
    try:
        found = estimate(log, method, configs, (), folder / "out.lcmlog").trajectory
    except Error as error:
        return {"error": str(error)}
    rest = truth.select(truth.time >= found.time[0])
    paths = (wheel_and_gyro(sensors), found)
    reckoned, after = (planar_figures(path, rest).ate_rmse_m for path in paths)
    over = (after + UNDECIDED_M) / (reckoned + UNDECIDED_M)
    allowed = after <= 1.2 * reckoned + UNDECIDED_M
    return {"wheel_m": reckoned, "after_m": after, "over": over, "allowed": allowed}


def one(seed: int, folder: Path, radar: bool = True) -> dict[str, Any]:
    """Of a simulated robot."""
    made = make(seed, folder, radar)
    more = [f"--set={setting}" for setting in made.settings]
    told, seconds = commission(made.log, [f"--stretch={made.stretch_m:.4f}", *more], folder)
    row = {"name": f"{seed} {ROBOTS[seed % len(ROBOTS)] or 'one wheel'}", "seconds": seconds}
    row |= {"deviations": deviations(told, made.truth), **shown(told)}
    return row | errors_after(made.log, folder, made.unit)


def real(name: str, recording: Recording, data: Path, folder: Path) -> dict[str, Any]:
    """Of a recording, likewise."""
    log = folder / "in.lcmlog"
    convert(recording, data, log)
    told, seconds = commission(log, [f"--set={setting}" for setting in recording.settings], folder)
    row = {"name": name, "seconds": seconds, "deviations": {}, **shown(told)}
    row["settings"] = told["settings"]
    return row | (errors_after(log, folder) if recording.points else {})


def shown(told: dict[str, Any]) -> dict[str, list[str]]:
    """Constants without a value, and what the doctor finds."""
    return {
        "missing": [each["name"] for each in told["parameters"] if not each["value"]],
        "findings": [each["code"] for each in told["findings"]],
    }


def summary(rows: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """By constant, over all robots."""
    names = dict.fromkeys(name for row in rows for name in row["deviations"])
    found = []
    for name in names:
        values = np.array([v for row in rows for v in row["deviations"].get(name, [])])
        found.append({
            "constant": name,
            "shown": sum(name in row["deviations"] for row in rows),
            "mean": float(values.mean()),
            "rms": float(np.sqrt(np.mean(values**2))),
            "largest": float(np.abs(values).max()),
        })  # fmt: skip
    return found


def main() -> None:
    """Measures and prints."""
    parser = parser_of(__doc__)
    parser.add_argument("--robots", type=int, default=50, metavar="N")
    parser.add_argument("--first", type=int, default=0, metavar="SEED")
    parser.add_argument("--no-radar", action="store_true", help="robots without a radar")
    parser.add_argument("--recordings", type=Path, metavar="DIR")
    parser.add_argument("--only", action="append", default=[], metavar="NAME")
    args = parser.parse_args()
    rows: list[dict[str, Any]] = []
    todo: dict[str, Callable[[Path], dict[str, Any]]] = {}
    if args.recordings is None:
        for seed in range(args.first, args.first + args.robots):
            todo[str(seed)] = partial(one, seed, radar=not args.no_radar)
    else:
        for name, recording in chosen(args.recordings, args.only).items():
            todo[name] = partial(real, name, recording, args.recordings)
    for name, work in one_by_one("robots", list(todo.items())):
        with temporary_folder() as folder:
            try:
                rows.append(work(folder))
            except Error as error:
                rows.append({"name": name, "deviations": {}, "error": str(error)})
    constants = summary(rows)
    keys = ("name", "seconds", "wheel_m", "after_m", "over", "allowed", "missing", "findings")
    lines = [{key: row.get(key) for key in (*keys, "error")} for row in rows]
    text = f"{table_of(lines)}\n{table_of(constants)}"
    print_figures(args, {"robots": rows, "constants": constants}, text)


if __name__ == "__main__":
    exit_with(main)
