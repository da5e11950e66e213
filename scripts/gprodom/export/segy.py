"""Radar traces with the estimate's coordinates as SEG-Y, by segyio.

SEG-Y was made for seismics: its sample interval is a 16-bit whole number of microseconds, its
coordinates are 32-bit whole numbers with a scalar. As is usual for radar the interval stands in
picoseconds, here rounded, and exactly in the text header; coordinates are centimetres, scalar -100.
The number of a trace within its record is the antenna_id.
"""

from pathlib import Path

import numpy as np

from gprodom.arrays import Ints
from gprodom.errors import Error, need_module
from gprodom.export.paths import moment
from gprodom.files import replacing
from gprodom.trajectory import Trajectory

_MOST_PS = 32_767


def write_segy(
    path: Path, poses: Trajectory, traces: Ints, sample_interval: float, antennas: Ints
) -> None:
    """traces: (n, samples) int32, counts, taken at `poses` (n) by `antennas` (n). sample_interval:
    s."""
    segyio = need_module("segyio", "export", "python3-segyio")
    picoseconds = round(sample_interval * 1e12)
    if not 0 < picoseconds <= _MOST_PS:
        raise Error(f"SEG-Y: a sample interval of {sample_interval:g} s: at most {_MOST_PS} ps fit")
    centimetres = np.rint(poses.position * 100)
    if np.abs(centimetres).max() >= 2**31:
        raise Error("SEG-Y: positions beyond 21,000 km do not fit")
    spec = segyio.spec()
    spec.format, spec.samples, spec.tracecount = 2, list(range(traces.shape[1])), len(traces)
    field = segyio.TraceField
    with replacing(path) as part, segyio.create(str(part), spec) as file:
        file.text[0] = segyio.tools.create_text_header(
            {
                1: "GPR traces, positions by gprodom",
                2: f"sample interval {sample_interval!r} s; headers: ps, rounded",
                3: "coordinates: cm (scalar -100), x y of the estimate's frame",
                4: "bytes 13-16: antenna_id, whose place the coordinates are",
            }
        )
        file.bin[segyio.BinField.Interval] = picoseconds
        places = centimetres.astype(np.int64).tolist()
        for i, (time, place, antenna) in enumerate(
            zip(poses.time.tolist(), places, antennas.tolist(), strict=True)
        ):
            when = moment(time)
            file.header[i] = {
                field.TRACE_SEQUENCE_FILE: i + 1,
                field.TraceNumber: antenna,
                field.SourceGroupScalar: -100,
                field.ElevationScalar: -100,
                field.SourceX: place[0],
                field.SourceY: place[1],
                field.GroupX: place[0],
                field.GroupY: place[1],
                field.CDP_X: place[0],
                field.CDP_Y: place[1],
                field.ReceiverGroupElevation: place[2],
                field.CoordinateUnits: 1,
                field.TRACE_SAMPLE_COUNT: traces.shape[1],
                field.TRACE_SAMPLE_INTERVAL: picoseconds,
                field.YearDataRecorded: when.year,
                field.DayOfYear: when.timetuple().tm_yday,
                field.HourOfDay: when.hour,
                field.MinuteOfHour: when.minute,
                field.SecondOfMinute: when.second,
            }
            file.trace[i] = np.ascontiguousarray(traces[i], np.int32)
