"""``gprodom calibrate time``: time offsets of IMU and radar against the wheel."""

import argparse
import sys
from dataclasses import asdict
from typing import Any

import numpy as np

from gprodom.arrays import Floats
from gprodom.calibrate.fragment import Found, add_output_option, tell_found
from gprodom.calibrate.offset import BLOCKS, REACH_S, Offset, refine, spread
from gprodom.calibrate.radar_timing import find_radar_offset
from gprodom.config import read_antennas
from gprodom.errors import Error
from gprodom.lcm import logs
from gprodom.lcm.antennas import apart, choose, counts
from gprodom.odometry.dead_reckoning import wheel_distance
from gprodom.odometry.estimate import read_sensors
from gprodom.options import Subparsers, add_command

GRID_S = 0.01
SMOOTH_S = 0.35  # window of the polynomial that takes acceleration off the wheel

DESCRIPTION = """\
Finds the time offset of the IMU against the wheel and, if the recording has traces, of the radar
against the wheel. At each of many lags, the wheel's acceleration is regressed on the three axes of
the accelerometer, and the change from trace to trace on the wheel's speed. The result is the lag
with the best fit. Use a drive with many starts and stops. With imu.time_offset and gpr.time_offset
the sensors agree with the wheel; the uncertainty is the spread over parts of the recording.

Of several antennas each is compared, by gpr.time_offsets: those that gpr.antennas has, or all of
the recording. With --antenna that one alone is, and gpr.time_offset is that of all.

examples:
  gprodom calibrate time drive.lcmlog -o time.yaml
  gprodom calibrate time pair.lcmlog --antenna 1
"""


def find_offset(log: logs.Log) -> Offset:
    """Of a drive's log."""
    wheel, force = _accelerations(log)
    whole, explained = _best_lag(wheel, force)
    if explained < 0.1:
        raise Error(
            f"the accelerometer explains {100 * explained:.0f} % of the wheel's acceleration: give "
            "a drive with more starts and stops"
        )
    parts = [
        _best_lag(a, b)[0]
        for a, b in zip(np.array_split(wheel, BLOCKS), np.array_split(force, BLOCKS), strict=True)
        if np.std(a) > 0.3 * np.std(wheel)
    ]
    return Offset(-whole, max(spread(parts, whole), GRID_S / 10), explained)


def _accelerations(log: logs.Log) -> tuple[Floats, Floats]:
    """The wheel's (n,) and the accelerometer's (n, 3), m/s^2, on one grid, smoothed alike."""
    from scipy.signal import savgol_filter

    time, distance = wheel_distance(log)
    imu = logs.need(log, "imu")
    first, last = max(time[0], imu["utime"][0]), min(time[-1], imu["utime"][-1])
    if last - first < 10_000_000:
        raise Error("IMU and wheel overlap for less than 10 s")
    grid = np.arange(first, last, round(GRID_S * 1e6))
    length = 2 * round(SMOOTH_S / GRID_S / 2) + 1
    way = np.interp(grid, time, distance)
    wheel = savgol_filter(way, length, 3, deriv=2, delta=GRID_S)
    # The same weights on acceleration: its second integral goes through the same filter.
    force = np.column_stack(
        [
            savgol_filter(
                _twice_integrated(np.interp(grid, imu["utime"], axis)), length, 3, deriv=2
            )
            for axis in imu["linear_acceleration"].T
        ]
    )
    return np.asarray(wheel), force


def _twice_integrated(values: Floats) -> Floats:
    """Values whose second difference about each place is `values`; the step of the grid is 1."""
    whole = np.cumsum(np.cumsum(values - values.mean()))
    return np.concatenate([[0.0], whole[:-1]])


def _best_lag(wheel: Floats, force: Floats) -> tuple[float, float]:
    """Seconds by which the accelerometer's stamps are late, and the share it explains then."""
    reach = round(REACH_S / GRID_S)
    middle = slice(reach, len(wheel) - reach)
    target = wheel[middle] - wheel[middle].mean()
    shares = []
    for lag in range(-reach, reach + 1):
        axes = force[reach + lag : len(force) - reach + lag]
        axes = axes - axes.mean(axis=0)
        weights = np.linalg.lstsq(axes, target, rcond=None)[0]
        shares.append(1 - float(np.sum((target - axes @ weights) ** 2) / np.sum(target**2)))
    best, share = refine(shares)
    return (best - reach) * GRID_S, share


def add_parser(subjects: Subparsers) -> None:
    """Adds ``calibrate time``."""
    parser = add_command(subjects, "time", "times between IMU, radar and wheel", DESCRIPTION, run)
    parser.operand("source", "SEQ|LOG")
    parser.option("--antenna ID", int, "whose traces (see above)")
    add_output_option(parser)
    parser.common_options()


def _apart(args: argparse.Namespace, radar: logs.Channel) -> dict[int, logs.Channel]:
    """The traces of each antenna that is compared."""
    if args.antenna is not None:
        return {args.antenna: choose(radar, args.antenna)}
    heard = apart(radar)
    placed = read_antennas(args.configs, args.overrides)
    return {each: heard[each] for each in heard if each in placed} or heard


def _radar_offsets(log: logs.Log, antennas: dict[int, logs.Channel]) -> dict[int, Offset]:
    """By antenna_id; without one whose traces show none, which is told."""
    offsets = {}
    for antenna, traces in antennas.items():
        try:
            offsets[antenna] = find_radar_offset({**log, "gpr_trace": traces})
        except Error as error:  # what the others said holds all the same
            which = f"antenna {antenna}" if len(antennas) > 1 else "the radar"
            print(f"gprodom: no offset of {which}: {error}", file=sys.stderr)
    return offsets


def _sureness(offset: Offset) -> str:
    return f"+- {offset.sigma_s:.4f} s; {100 * offset.explained:.0f} % explained"


def _of_radar(offsets: dict[int, Offset], each: bool, several: bool) -> list[Found]:
    """each: every antenna has its own. several: the recording has more than one."""
    if not each:
        return [
            Found(
                "gpr.time_offset",
                f"{offset.offset_s:.4f}",
                _sureness(offset) + (f", by antenna {antenna}" if several else ""),
                offset.significant,
            )
            for antenna, offset in offsets.items()
        ]
    found = []
    for significant in (True, False):
        some = {a: offset for a, offset in offsets.items() if offset.significant == significant}
        values = ", ".join(f"{a}: {offset.offset_s:.4f}" for a, offset in some.items())
        sure = ", ".join(f"antenna {a} {_sureness(offset)}" for a, offset in some.items())
        if some:
            found.append(Found("gpr.time_offsets", f"{{{values}}}", sure, significant))
    return found


def run(args: argparse.Namespace) -> int:
    """Runs ``calibrate time``."""
    log = read_sensors(args, args.source, "imu", "wheel", "gpr_trace")
    imu = find_offset(log)
    if args.antenna is not None and "gpr_trace" not in log:
        raise Error(f"--antenna {args.antenna}: the recording has no traces")
    antennas = _apart(args, log["gpr_trace"]) if "gpr_trace" in log else {}
    several = "gpr_trace" in log and len(counts(log["gpr_trace"])) > 1
    offsets = _radar_offsets(log, antennas)
    found = [
        Found("imu.time_offset", f"{imu.offset_s:.4f}", _sureness(imu), imu.significant),
        *_of_radar(offsets, len(antennas) > 1, several),
    ]
    told: dict[str, Any] = {"imu": asdict(imu)}
    if offsets:
        told["gpr"] = asdict(next(iter(offsets.values())))
    if len(antennas) > 1:
        told["antennas"] = {str(each): asdict(offset) for each, offset in offsets.items()}
    return tell_found(args, found, told)
