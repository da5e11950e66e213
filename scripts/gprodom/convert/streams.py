"""The sensors' LCM messages, in the form of our logs, and those of a recording."""

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from gprodom.arrays import Floats, Ints
from gprodom.config import STANDARD, TRUTH_CHANNEL, Channels
from gprodom.convert.cmu import VOLTS_PER_COUNT, Recording, Traces
from gprodom.lcm.log_writer import Stream, encoded


def imu_stream(
    channel: str,
    time: Ints,
    acceleration: Floats,
    rate: Floats,
    known: npt.ArrayLike = False,
    orientation: npt.ArrayLike = (0.0, 0.0, 0.0, 0.0),
) -> Stream:
    """IMU messages from (n, 3) m/s^2 and (n, 3) rad/s; orientation (n, 4) w x y z where `known`."""
    return encoded(
        channel,
        "imu_t",
        time,
        linear_acceleration=acceleration,
        angular_velocity=rate,
        has_orientation=known,
        orientation=orientation,
    )


def gpr_stream(
    channel: str,
    time: Ints,
    traces: Floats,
    sample_interval: npt.ArrayLike,
    time_zero: npt.ArrayLike,
    volts_per_count: npt.ArrayLike = 0.0,
    antenna_id: int = 0,
) -> Stream:
    """An antenna's radar messages from traces (n, samples), counts; the other values (n,) or one
    for all, s and V.
    """
    stream = encoded(
        channel,
        "gpr_trace_t",
        time,
        seq=np.arange(len(time)),
        antenna_id=antenna_id,
        sample_interval=sample_interval,
        time_zero=time_zero,
        volts_per_count=volts_per_count,
        samples=np.rint(traces).astype(np.int32),
    )
    return replace(stream, antenna_id=antenna_id)


def truth_stream(time: Ints, position: Floats) -> Stream:
    """Truth messages from positions (n, 3), m."""
    return encoded(TRUTH_CHANNEL, "position_truth_t", time, position=position)


def streams(of: Recording, sample_interval: float, channels: Channels = STANDARD) -> list[Stream]:
    """The recording's messages, in the order they have at equal times."""
    moved: dict[str, npt.ArrayLike] = {"ticks": of.ticks, "metres_per_tick": of.metres_per_tick}
    motion = of.acceleration, of.angular_velocity, of.has_orientation, of.orientation
    antennas = {0: Traces(of.gpr_utime, of.traces), **of.more_antennas}
    facts = sample_interval, 0.0, VOLTS_PER_COUNT
    made = [
        imu_stream(channels.imu, of.imu_utime, *motion),
        encoded(channels.wheel, "wheel_t", of.wheel_utime, **moved),
        *(
            gpr_stream(channels.gpr_trace, radar.utime, radar.counts, *facts, id_)
            for id_, radar in antennas.items()
        ),
        truth_stream(of.truth_utime, of.truth),
    ]
    return [stream for stream in made if len(stream.utime)]
