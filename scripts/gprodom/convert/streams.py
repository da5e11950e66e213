"""A recording's LCM messages, in the form of our logs."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from gprodom.config import STANDARD, TRUTH_CHANNEL, Channels
from gprodom.convert.cmu import VOLTS_PER_COUNT, Recording
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
    gpr: Fields = {
        "seq": np.arange(len(recording.gpr_utime)),
        "antenna_id": 0,
        "sample_interval": sample_interval,
        "time_zero": 0.0,
        "volts_per_count": VOLTS_PER_COUNT,
        "samples": recording.traces,
    }
    return [
        Stream(channel, utime, encode(name, {"utime": utime, **fields}, len(utime)))
        for channel, name, utime, fields in (
            (channels.imu, "imu_t", recording.imu_utime, imu),
            (channels.wheel, "wheel_t", recording.wheel_utime, wheel),
            (channels.gpr_trace, "gpr_trace_t", recording.gpr_utime, gpr),
            (
                TRUTH_CHANNEL,
                "position_truth_t",
                recording.truth_utime,
                {"position": recording.truth},
            ),
        )
        if len(utime)
    ]
