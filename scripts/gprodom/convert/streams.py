"""A recording's LCM messages, in the form of our logs."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from gprodom.arrays import Ints
from gprodom.config import STANDARD, TRUTH_CHANNEL, Channels
from gprodom.convert.cmu import VOLTS_PER_COUNT, Recording, Traces
from gprodom.lcm.log_writer import Stream
from gprodom.lcm.wire import encode

Fields = dict[str, npt.ArrayLike]


def streams(
    recording: Recording, sample_interval: float, channels: Channels = STANDARD
) -> list[Stream]:
    """The recording's messages, in the order they have at equal times."""
    imu: Fields = {
        "linear_acceleration": recording.acceleration,
        "angular_velocity": recording.angular_velocity,
        "has_orientation": recording.has_orientation,
        "orientation": recording.orientation,
    }
    wheel: Fields = {
        "ticks": recording.ticks,
        "metres_per_tick": recording.metres_per_tick,
    }
    truth: Fields = {"position": recording.truth}
    antennas = {0: Traces(recording.gpr_utime, recording.traces), **recording.more_antennas}
    radar = [(of.utime, _traces(id_, of, sample_interval)) for id_, of in antennas.items()]
    sources: list[tuple[str, str, Ints, Fields]] = [
        (channels.imu, "imu_t", recording.imu_utime, imu),
        (channels.wheel, "wheel_t", recording.wheel_utime, wheel),
        *((channels.gpr_trace, "gpr_trace_t", utime, fields) for utime, fields in radar),
        (TRUTH_CHANNEL, "position_truth_t", recording.truth_utime, truth),
    ]
    return [
        Stream(channel, utime, encode(name, {"utime": utime, **fields}, len(utime)))
        for channel, name, utime, fields in sources
        if len(utime)
    ]


def _traces(antenna_id: int, traces: Traces, sample_interval: float) -> Fields:
    return {
        "seq": np.arange(len(traces.utime)),
        "antenna_id": antenna_id,
        "sample_interval": sample_interval,
        "time_zero": 0.0,
        "volts_per_count": VOLTS_PER_COUNT,
        "samples": traces.counts,
    }
