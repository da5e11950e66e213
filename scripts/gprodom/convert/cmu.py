"""A CMU-GPR sequence as arrays.

The dataset's files, its readme and its own tools disagree in places; what holds here is found from
the data: header wording is not relied on, the accelerometer is the triad that shows gravity, the
last four IMU columns are an orientation where they have unit norm.

Rows whose time goes back (the recorder wrote from several threads) are sorted into place, rows of
equal time are kept in file order, and both are counted: an estimator wants its data in order of
time, and dropping them would hide what the recording holds.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from gprodom.arrays import Bools, Floats, Ints
from gprodom.console import Progress
from gprodom.convert.plausible import GRAVITY, GRAVITY_TOLERANCE
from gprodom.convert.quantum import find_quantum
from gprodom.convert.sampling import SAMPLE_INTERVAL, find_sample_interval
from gprodom.convert.source import GPR, IMU, RADAR_FACTS, TRUTH, WHEEL, File, antenna_of, read_files
from gprodom.convert.table import Table, parse
from gprodom.errors import Error

VOLTS_PER_COUNT = 0.05 / 32767
FALLBACK_QUANTUM = 1e-6  # m per tick where the wheel's values lie on no grid

_UNIT_NORM_TOLERANCE = 0.01


@dataclass(frozen=True)
class Traces:
    """Radar traces of one antenna. Times as in `Recording`."""

    utime: Ints  # (g,)
    counts: Ints  # (g, samples)


@dataclass(frozen=True)
class Recording:
    """One sequence. Times: int64 microseconds since 1970, ascending."""

    imu_utime: Ints  # (i,)
    acceleration: Floats  # (i, 3), m/s^2, specific force
    angular_velocity: Floats  # (i, 3), rad/s
    orientation: Floats  # (i, 4), w x y z
    has_orientation: Bools  # (i,)
    gyro_first: bool  # the file had the angular rate before the acceleration
    wheel_utime: Ints  # (w,)
    ticks: Ints  # (w,)
    metres_per_tick: float
    gpr_utime: Ints  # (g,)
    traces: Ints  # (g, samples), counts, of antenna 0; g = 0 where the sequence has no radar
    truth_utime: Ints  # (t,)
    truth: Floats  # (t, 3), m, in the instrument's frame; t = 0 where there is none
    out_of_order: dict[str, int]  # rows sorted into place, by sensor
    sample_interval: float = SAMPLE_INTERVAL  # s, of the radar; see `find_sample_interval`
    more_antennas: dict[int, Traces] = field(default_factory=dict)  # by antenna_id, from 1 on

    def messages(self, since: int = 0, until: int = 2**63 - 1) -> dict[str, Any]:
        """Arguments of `gprodom.Odometry.run`, of the messages with since < time <= until (us), the
        traces of all antennas by time."""

        def part(time: Ints) -> slice:
            return slice(*np.searchsorted(time, [since, until], side="right"))

        imu, wheel, gpr = (part(t) for t in (self.imu_utime, self.wheel_utime, self.gpr_utime))
        found = {
            "imu_time": self.imu_utime[imu] * 1000,
            "acceleration": self.acceleration[imu],
            "angular_velocity": self.angular_velocity[imu],
            "wheel_time": self.wheel_utime[wheel] * 1000,
            "wheel_distance": self.ticks[wheel] * self.metres_per_tick,
            "gpr_time": self.gpr_utime[gpr] * 1000,
            "traces": self.traces[gpr],
            "sample_interval": self.sample_interval,
        }
        if not self.more_antennas:
            return found
        radar = {0: Traces(self.gpr_utime, self.traces), **self.more_antennas}
        parts = {
            id_: (of.utime[part(of.utime)], of.counts[part(of.utime)]) for id_, of in radar.items()
        }
        if len({of.counts.shape[1] for of in radar.values()}) > 1:
            raise Error("antennas with traces of different lengths: convert the recording to a log")
        time = np.concatenate([utime for utime, _ in parts.values()])
        order = np.argsort(time, kind="stable")
        ids = np.repeat(list(parts), [len(utime) for utime, _ in parts.values()])
        traces = np.concatenate([counts for _, counts in parts.values()])
        together = {"gpr_time": time * 1000, "traces": traces, "gpr_antenna": ids}
        return found | {name: values[order] for name, values in together.items()}


def radar_name(antenna_id: int) -> str:
    """The name of a further antenna's radar among the sensors."""
    return f"gpr {antenna_id}"


def read_recording(sequence: Path) -> Recording:
    """Reads a sequence, a directory or a zip. Raises `Error` with file and line."""
    files = read_files(sequence)
    wheels = [files[name] for name in WHEEL if name in files]
    if len(wheels) > 1:
        raise Error(f"{sequence}: expected one wheel file, got both {' and '.join(WHEEL)}")
    missing = [name for name in (IMU, GPR) if name not in files] + ([] if wheels else [WHEEL[0]])
    if missing:
        raise Error(f"{sequence}: incomplete sequence, missing {', '.join(missing)}")
    more = {id_: file for name, file in files.items() if (id_ := antenna_of(name)) is not None}
    read = [files[IMU], files[GPR], wheels[0], *more.values()]
    read += [files[TRUTH]] if TRUTH in files else []
    with Progress("reading", sum(len(file.data) for file in read)) as progress:

        def counted(parse_file: Callable[[File], Table], file: File) -> Table:
            table = parse_file(file)
            progress.advance(len(file.data))
            return table

        imu = counted(_parse_imu, files[IMU])
        wheel = counted(_parse_wheel, wheels[0])
        truth = counted(parse_truth, files[TRUTH]) if TRUTH in files else _NO_TRUTH
        gpr = counted(_parse_gpr, files[GPR])
        antennas = {id_: counted(_parse_gpr, file) for id_, file in sorted(more.items())}
    acceleration, rate, gyro_first = _find_gravity(imu.values, files[IMU].label)
    orientation = (
        imu.values[:, 6:10] if imu.values.shape[1] >= 10 else np.zeros((len(imu.utime), 4))
    )
    norm = np.linalg.norm(orientation, axis=1)
    quantum = find_quantum(wheel.values[:, 0], wheel.decimals) or FALLBACK_QUANTUM
    tables = {"imu": imu, "wheel": wheel, "gpr": gpr, "truth": truth}
    tables |= {radar_name(id_): table for id_, table in antennas.items()}
    return Recording(
        imu_utime=imu.utime,
        acceleration=acceleration,
        angular_velocity=rate,
        orientation=orientation,
        has_orientation=np.abs(norm - 1) < _UNIT_NORM_TOLERANCE,
        gyro_first=gyro_first,
        wheel_utime=wheel.utime,
        ticks=np.rint(wheel.values[:, 0] / quantum).astype(np.int64),
        metres_per_tick=quantum,
        gpr_utime=gpr.utime,
        traces=gpr.values.astype(np.int32),
        truth_utime=truth.utime,
        truth=truth.values,
        out_of_order={name: table.out_of_order for name, table in tables.items()},
        sample_interval=find_sample_interval(sequence, files.get(RADAR_FACTS)),
        more_antennas={
            id_: Traces(table.utime, table.values.astype(np.int32))
            for id_, table in antennas.items()
        },
    )


_NO_TRUTH = Table(np.zeros(0, np.int64), np.zeros((0, 3)), 0, 0)
_NO_RADAR = Table(np.zeros(0, np.int64), np.zeros((0, 0)), 0, 0)


def _parse_imu(file: File) -> Table:
    what = "time, acceleration and angular rate, orientation w x y z"
    return _not_empty(parse(file, (11, 7), what), file)


def _parse_wheel(file: File) -> Table:
    return _not_empty(parse(file, (2,), "time, distance"), file)


def _parse_gpr(file: File) -> Table:
    """Traces; none where the file is only a header, as of a drive simulated without radar."""
    table = parse(file, range(9, 100_000), "time, samples", integers=True)
    return table if len(table.utime) else _NO_RADAR


def parse_truth(file: File) -> Table:
    """The total station's positions; (0, 3) values where the file is empty or only a header."""
    table = parse(file, (4,), "time, x, y, z")
    return table if len(table.utime) else _NO_TRUTH


def _not_empty(table: Table, file: File) -> Table:
    if not len(table.utime):
        raise Error(f"{file.label}: expected rows of data, got none")
    return table


def _find_gravity(values: Floats, label: str) -> tuple[Floats, Floats, bool]:
    """Acceleration and angular rate (n, 3), and whether the angular rate stands first."""
    triads = values[:, 0:3], values[:, 3:6]
    norms = [float(np.median(np.linalg.norm(triad, axis=1))) for triad in triads]
    shows = [abs(norm - GRAVITY) < GRAVITY_TOLERANCE for norm in norms]
    if shows[0] == shows[1]:
        raise Error(
            f"{label}: expected one of columns 2-4 and 5-7 to show gravity (norm near "
            f"{GRAVITY} m/s^2), got median norms {norms[0]:.3g} and {norms[1]:.3g}"
        )
    gyro_first = shows[1]
    return triads[gyro_first], triads[not gyro_first], gyro_first
