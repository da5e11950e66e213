"""Simulated data as a recording, with nothing lost to decimal text."""

import numpy as np

from gprodom.arrays import Floats
from gprodom.config import STANDARD, Channels
from gprodom.convert.cmu import Recording
from gprodom.convert.sampling import SAMPLE_INTERVAL
from gprodom.convert.streams import streams
from gprodom.convert.wheels import pair_stream
from gprodom.lcm.log_writer import Stream
from gprodom.simulate.sequence import Simulated


def as_recording(simulated: Simulated) -> Recording:
    """The result of converting the written sequence, apart from rounding."""
    imu = simulated.imu
    return Recording(
        imu_utime=simulated.imu_utime,
        acceleration=imu.acceleration,
        angular_velocity=imu.angular_velocity,
        orientation=imu.orientation,
        has_orientation=np.ones(len(simulated.imu_utime), bool),
        gyro_first=False,
        wheel_utime=simulated.wheel_utime,
        ticks=simulated.wheel.ticks,
        metres_per_tick=simulated.spec.wheel.quantum,
        gpr_utime=simulated.gpr_utime,
        traces=simulated.traces,
        more_antennas=simulated.more_antennas,
        truth_utime=simulated.station_utime,
        truth=simulated.station,
        out_of_order={},
        sample_interval=simulated.sample_interval or SAMPLE_INTERVAL,
    )


def side_distances(simulated: Simulated) -> Floats:
    """What left and right wheels report at the wheel's times (n, 2), m."""
    assert simulated.pair is not None and simulated.spec.pair is not None
    sides = np.column_stack([simulated.pair.left, simulated.pair.right])
    return np.asarray(sides * simulated.spec.pair.quantum)


def log_streams(simulated: Simulated, channels: Channels = STANDARD) -> list[Stream]:
    """The messages of a log: those of the recording, with left and right wheels where there are."""
    recording = as_recording(simulated)
    recorded = streams(recording, recording.sample_interval, channels)
    if simulated.pair is None or simulated.spec.pair is None:
        return recorded
    sides = pair_stream(channels.wheels, simulated.wheel_utime, *side_distances(simulated).T)
    return [sides if stream.channel == channels.wheel else stream for stream in recorded]
