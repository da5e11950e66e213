#!/usr/bin/env python3
"""Simulated sequences beside real pieces: are they alike where it matters to an estimator?

    radar   distance over which traces (less the line's mean) decorrelate to 0.5; middle frequency
            and -6 dB band of the spectrum after the direct wave; strength of the late part
    IMU     noise density at rest and moving (median of the spectrum over 3 to 14 Hz), by axis kind,
            and what moving adds for each m/s
    wheel   smallest step, rate, and how rough the speed is: RMS of its second difference over steps
            of 0.2 s while driving, relative to the speed

Real pieces: the Seal Beach lines and the dune (other antennas than the simulated 500 MHz), the CMU
wheel file C.0, the husky bag (30 Hz, outdoors).

    bench/realism.py ../shared/data
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gprodom.convert.bag import Topics, read_streams
from gprodom.convert.quantum import find_quantum
from gprodom.convert.source import File
from gprodom.convert.survey_files import read_line
from gprodom.convert.table import parse
from gprodom.ground.survey import find_survey, shipped
from gprodom.lcm.wire import decode
from gprodom.simulate import make_route, simulate, stream
from gprodom.simulate.robot import robot
from program import exit_with, parser_of, print_figures, table_of

Array = NDArray[np.float64]
HUSKY = Topics("/imu/data", "/husky_velocity_controller/odom", truth="/fix")


def radar(traces: Array, spacing: float, interval: float) -> dict[str, float]:
    """Figures of a line of traces (n, samples)."""
    direct = int(np.argmax(np.abs(traces.mean(axis=0))))
    late = traces[:, direct + round(4e-9 / interval) :].astype(float)
    late = late - late.mean(axis=0)
    unit = late / np.maximum(np.linalg.norm(late, axis=1, keepdims=True), 1e-9)
    lags = np.arange(1, min(len(late) // 4, 200))
    alike = np.array([np.mean(np.sum(unit[lag:] * unit[:-lag], axis=1)) for lag in lags])
    # From the whole down through 0.5, between lags.
    curve = np.concatenate([[1.0], alike])
    below = int(np.argmax(curve < 0.5)) if (curve < 0.5).any() else len(curve) - 1
    part = (curve[below - 1] - 0.5) / max(curve[below - 1] - curve[below], 1e-9)
    power = np.mean(np.abs(np.fft.rfft(late * np.hanning(late.shape[1]), axis=1)) ** 2, axis=0)
    frequency = np.fft.rfftfreq(late.shape[1], interval)
    strong = frequency[power > power.max() / 4]
    middle = float(np.sum(frequency * power) / np.sum(power))
    return {
        "decorrelates over (m)": (below - 1 + part) * spacing,
        "in wavelengths (at 0.1 m/ns)": (below - 1 + part) * spacing * middle / 1e8,
        "middle frequency (MHz)": middle / 1e6,
        "band / middle": float(np.ptp(strong)) / middle,
        "late over direct (dB)": 20 * float(np.log10(late.std() / np.abs(traces).max())),
    }


def imu(rate: float, force: Array, gyro: Array, speed: Array) -> dict[str, float]:
    """Figures of samples (n, 3), with the speed (n,) at each."""
    figures = {}
    still, moving = np.abs(speed) < 0.01, np.abs(speed) > 0.3
    for name, values in (("accelerometer", force), ("gyro", gyro)):
        rest, driven = density(values, still, rate), density(values, moving, rate)
        typical = float(np.median(np.abs(speed[moving])))
        figures[f"{name} at rest (/√Hz)"] = rest
        figures[f"{name} moving (/√Hz)"] = driven
        figures[f"{name} added per m/s"] = float(np.sqrt(max(driven**2 - rest**2, 0))) / typical
    return figures


def density(values: Array, during: NDArray[np.bool_], rate: float) -> float:
    """Median amplitude density over 3 to 14 Hz, root mean square over axes, of whole seconds."""
    length = int(2 * rate)
    edges = np.flatnonzero(np.diff(np.concatenate([[0], during.astype(int), [0]])))
    spectra = []
    for start, end in zip(edges[::2], edges[1::2], strict=True):
        for at in range(start, end - length + 1, length):
            part = values[at : at + length]
            part = (part - part.mean(axis=0)) * np.hanning(length)[:, None]
            spectra.append(np.abs(np.fft.rfft(part, axis=0)) ** 2 * 2 / (rate * length * 0.375))
    if not spectra:
        return float("nan")
    frequency = np.fft.rfftfreq(length, 1 / rate)
    band = (frequency > 3) & (frequency < 14)
    return float(np.sqrt(np.median(np.mean(spectra, axis=0)[band].mean(axis=1))))


def wheel(time: Array, distance: Array, quantum: float) -> dict[str, float]:
    """Figures of a cumulative distance (n,), m, at the times (n,), s."""
    grid = np.arange(time[0], time[-1], 0.2)
    speed = np.diff(np.interp(grid, time, distance)) / 0.2
    steady = np.abs(speed) > 0.1
    both = steady[2:] & steady[1:-1] & steady[:-2]
    rough = np.diff(speed, 2)[both] / np.abs(speed[1:-1][both])
    return {
        "smallest step (mm)": 1e3 * quantum,
        "rate (Hz)": 1 / float(np.median(np.diff(time))),
        "speed, median driving (m/s)": float(np.median(np.abs(speed[steady]))),
        "roughness of speed (%)": 100 * float(np.sqrt(np.mean(rough**2))),
        "standing (% of time)": 100 * float(np.mean(np.abs(speed) < 0.005)),
    }


def simulated_drive() -> Any:
    """A drive of the robot that `gprodom simulate` drives, without radar."""
    route = make_route("stops", 60.0, 0.6, 30.0, stream(1, "route"))
    return simulate(robot(route, None), 1)


def real_husky(bag: Path) -> dict[str, float]:
    """IMU figures of the bag."""
    found = {s.channel: s for s in read_streams(bag, HUSKY)}
    values = decode("imu_t", found["IMU"].payloads, str(bag))
    turns = decode("wheel_t", found["WHEEL"].payloads, str(bag))
    time, at = values["utime"] * 1e-6, turns["utime"] * 1e-6
    way = turns["ticks"] * turns["metres_per_tick"]
    speed = np.interp(time, 0.5 * (at[1:] + at[:-1]), np.diff(way) / np.diff(at))
    rate = 1 / float(np.median(np.diff(time)))
    return imu(rate, values["linear_acceleration"], values["angular_velocity"], speed)


def compare(data: Path) -> dict[str, dict[str, dict[str, float]]]:
    """Figures by kind, piece and name."""
    ground: dict[str, dict[str, float]] = {}
    for name in shipped():
        survey = find_survey(name)
        ground[f"simulated {name}"] = radar(survey.lines[0], survey.spacing, survey.sample_interval)
    for number in (1, 10, 20):
        with np.load(data / "real_ground/seal_beach" / f"line_{number:02d}.npz") as line:
            figures = radar(line["traces"], float(line["spacing"]), float(line["sample_interval"]))
            ground[f"real beach {number}"] = figures
    dune = read_line(data / "real_ground/dune/DuneData.DZT")
    ground["real dune"] = radar(dune.traces, dune.spacing, dune.sample_interval)
    drive = simulated_drive()
    speed = drive.motion_at(drive.imu_utime).v
    turn = np.zeros((len(speed), 3))
    turn[:, 2] = drive.motion_at(drive.imu_utime).yaw_rate
    shaken = imu(
        drive.spec.imu.rate, drive.imu.acceleration, drive.imu.angular_velocity - turn, speed
    )
    inertial = {"simulated": shaken, "real husky": real_husky(data / "robots/husky.bag")}
    file = data / "cmu_real/we_odom_meas.csv"
    table = parse(File(str(file), file.read_bytes()), (2,), "time, distance")
    quantum = find_quantum(table.values[:, 0], table.decimals) or float("nan")
    ticks = drive.wheel.ticks * drive.spec.wheel.quantum
    odometer = {
        "simulated": wheel(drive.wheel_utime * 1e-6, ticks, drive.spec.wheel.quantum),
        "real CMU C.0": wheel(table.utime * 1e-6, table.values[:, 0], quantum),
    }
    return {"radar": ground, "IMU": inertial, "wheel": odometer}


def main() -> None:
    """Compares and prints."""
    parser = parser_of(__doc__)
    parser.add_argument("data", type=Path, help="folder of the real pieces")
    args = parser.parse_args()
    found = compare(args.data)
    tables = [
        table_of([{kind: piece} | figures for piece, figures in pieces.items()])
        for kind, pieces in found.items()
    ]
    print_figures(args, found, "\n\n".join(tables))


if __name__ == "__main__":
    exit_with(main)
