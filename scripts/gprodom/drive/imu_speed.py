"""The forward speed by the IMU: what it adds, over a second, to the estimate of a second before.

Integrated for longer, the errors of tilt and bias would be seen and not the slip of the wheel; over
a second they are some centimetres a second.
"""

import numpy as np

from gprodom import rotation
from gprodom.arrays import Floats, Ints, integral
from gprodom.drive.imu_mounting import ImuMounting, matrix_of
from gprodom.lcm.logs import Channel

SPAN_S = 1.0
GRAVITY = 9.81  # m/s^2


def imu_speed(imu: Channel, odometry: Channel, mounting: ImuMounting) -> tuple[Ints, Floats]:
    """Times (n,), us, of the estimate from a second after its begin on, and speeds (n,), m/s.

    odometry: of the estimate, for its speed, attitude and bias of the accelerometer.
    """
    time = odometry["utime"]
    origin = int(time[0])
    clock, stamps = (time - origin) * 1e-6, (imu["utime"] - origin) * 1e-6
    # Forwards, in body.
    force = mounting.at_origin(imu)["linear_acceleration"] @ matrix_of(mounting.rpy)[0]
    tilted = GRAVITY * rotation.to_matrix(odometry["orientation"])[:, 2, 0]
    known = np.interp(stamps, clock, tilted + odometry["accel_bias"][:, 0])
    gained = integral(force - known, stamps)
    kept = (clock >= clock[0] + SPAN_S) & (clock <= stamps[-1])
    now, before = clock[kept], clock[kept] - SPAN_S
    speed = np.interp(before, clock, odometry["velocity"][:, 0])
    speed = speed + np.interp(now, stamps, gained) - np.interp(before, stamps, gained)
    return time[kept], speed
