"""Simulated data as a recording, with nothing lost to decimal text."""

from __future__ import annotations

import numpy as np

from gprodom.convert.cmu import Recording
from gprodom.convert.sampling import SAMPLE_INTERVAL
from gprodom.simulate.sequence import Simulated


def as_recording(simulated: Simulated) -> Recording:
    """What converting the written sequence would give, but for rounding."""
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
        truth_utime=simulated.station_utime,
        truth=simulated.station,
        out_of_order={},
        sample_interval=simulated.sample_interval or SAMPLE_INTERVAL,
    )
