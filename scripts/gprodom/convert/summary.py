"""Summary of a converted recording: counts, rates, gaps."""

from typing import Any

import numpy as np

from gprodom.arrays import Ints
from gprodom.console import format_table
from gprodom.convert.cmu import Recording, radar_name

# What is printed of `describe_times`, and how it is headed.
TIME_FACTS = {
    "count": "count",
    "rate_hz": "rate Hz",
    "gaps": "gaps",
    "longest_interval_s": "longest s",
    "equal_times": "equal",
    "out_of_order": "out of order",
}
_GAP_RATIO = 5.0  # times the median interval, from which an interval counts as a gap


def describe_times(utime: Ints, out_of_order: int) -> dict[str, Any]:
    """Count, rate (Hz), gaps and span of one sensor's stamps (n,), us, ascending."""
    steps = np.diff(utime) * 1e-6
    median = float(np.median(steps)) if len(steps) else 0.0
    longest = int(np.argmax(steps)) if len(steps) else 0
    return {
        "count": len(utime),
        "rate_hz": 1 / median if median > 0 else None,
        "gaps": int(np.count_nonzero(steps > _GAP_RATIO * median)),
        "longest_interval_s": float(steps[longest]) if len(steps) else None,
        "longest_interval_utime": int(utime[longest]) if len(steps) else None,
        "equal_times": int(np.count_nonzero(steps == 0)),
        "out_of_order": out_of_order,
        "first_utime": int(utime[0]) if len(utime) else None,
        "last_utime": int(utime[-1]) if len(utime) else None,
    }


def summarise(recording: Recording, sample_interval: float) -> dict[str, Any]:
    """The figures of ``gprodom convert cmu --json``."""
    times = {
        "imu": recording.imu_utime,
        "wheel": recording.wheel_utime,
        "gpr": recording.gpr_utime,
        "truth": recording.truth_utime,
        **{radar_name(id_): of.utime for id_, of in recording.more_antennas.items()},
    }
    everything = np.concatenate(list(times.values()))
    travelled = int(np.abs(np.diff(recording.ticks)).sum()) * recording.metres_per_tick
    return {
        "duration_s": float(everything.max() - everything.min()) * 1e-6,
        "sensors": {
            name: describe_times(utime, recording.out_of_order[name])
            for name, utime in times.items()
        },
        "wheel_distance_m": travelled,
        "metres_per_tick": recording.metres_per_tick,
        "samples_per_trace": recording.traces.shape[1],
        "sample_interval_s": sample_interval,
        "imu_columns": "gyro first" if recording.gyro_first else "accelerometer first",
        "orientations": int(recording.has_orientation.sum()),
    }


def as_text(summary: dict[str, Any]) -> str:
    """The summary for people."""
    header = ["sensor", *TIME_FACTS.values()]
    rows = [
        [name, *(sensor[fact] for fact in TIME_FACTS)]
        for name, sensor in summary["sensors"].items()
    ]
    samples = summary["samples_per_trace"]
    window_ns = (samples - 1) * summary["sample_interval_s"] * 1e9
    radar = f"radar {samples} samples, {window_ns:.1f} ns" if samples else "no radar"
    return "\n".join(
        [
            format_table(header, rows),
            f"duration {summary['duration_s']:.3f} s, wheel {summary['wheel_distance_m']:.3f} m "
            f"in ticks of {summary['metres_per_tick']:.9g} m",
            f"{radar}; IMU columns: {summary['imu_columns']}",
        ]
    )
