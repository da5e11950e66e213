"""A thing that is wrong with a recording, and the evidence that all checks share."""

from dataclasses import dataclass

import numpy as np

from gprodom.arrays import Floats, Ints
from gprodom.lcm import logs

# Standard deviations by which a measured value must be beyond a bound. Some thirty checks of a
# recording are wrong by chance once in 10^5 recordings.
SIGMAS = 5.0

Log = logs.Log  # by role: imu, wheel, wheels, gpr_trace

NAMES = {"imu": "IMU", "wheel": "wheel", "wheels": "wheels", "gpr_trace": "radar"}


@dataclass(frozen=True)
class Finding:
    """code: of the kind of damage, for programs. what: is wrong, with figures. mend: the setting or
    command that does."""

    code: str
    what: str
    mend: str


def seconds_of(utime: Ints) -> Floats:
    """Since the first, s."""
    return np.asarray((utime - utime[0]) * 1e-6)
