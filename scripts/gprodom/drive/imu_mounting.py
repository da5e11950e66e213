"""How and where the IMU is mounted, and what it would measure at the robot's origin."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import gaussian_filter1d

from gprodom import rotation
from gprodom.arrays import Floats
from gprodom.config import Configs, read_imu_mounting, read_lever_arm
from gprodom.lcm.logs import Channel

# Standard deviation of the weights of the gyro's filter. As the estimator's, it is short enough for
# turns and long enough for noise; but as all is recorded, it is not late.
SMOOTH_S = 0.05
SHORTEST_S = 1e-3

matrix_of = rotation.from_rpy  # R_body_imu of `imu.rpy_body_imu`


@dataclass(frozen=True)
class ImuMounting:
    """rpy: imu.rpy_body_imu, rad. arm: imu.lever_arm, m in body."""

    rpy: tuple[float, ...] = (0.0, 0.0, 0.0)
    arm: tuple[float, ...] = (0.0, 0.0, 0.0)

    def at_origin(self, imu: Channel) -> Channel:
        """With the accelerations, in the IMU's axes still, that it would measure at the origin."""
        if not any(self.arm) or len(imu["utime"]) < 2:
            return imu
        seconds = (imu["utime"] - imu["utime"][0]) * 1e-6
        rate = smoothed(imu["angular_velocity"], seconds)
        step = np.maximum(np.gradient(seconds), SHORTEST_S)
        added = rotation.added_by_turning(rate, step, np.array(self.arm) @ matrix_of(self.rpy))
        return {**imu, "linear_acceleration": imu["linear_acceleration"] - added}


def read_mounting(configs: Configs = (), overrides: Sequence[str] = ()) -> ImuMounting:
    """As it is configured."""
    rpy = read_imu_mounting(configs, overrides)
    return ImuMounting(rpy, read_lever_arm(configs, overrides, "imu.lever_arm"))


def smoothed(rate: Floats, seconds: Floats) -> Floats:
    """Rates (n, 3) at `seconds` (n,), without most of the noise of single samples."""
    step = max(float(np.median(np.diff(seconds))), SHORTEST_S)
    return np.asarray(gaussian_filter1d(rate, SMOOTH_S / step, axis=0))
