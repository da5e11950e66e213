"""What a receiver or another program says of its position, as quality and covariance of a fix.

The ROS nodes (ros/shared/fixes.h) read messages by the same rules.
"""

import numpy as np

from gprodom.arrays import Bools, Floats, Ints
from gprodom.fixes.record import Quality, diagonal

CENTIMETRES = 0.05  # m, horizontal: ambiguities are fixed
# One standard deviation of a coordinate, horizontal and vertical, m, where nothing better is told.
UNKNOWN_SIGMA = {
    Quality.NONE: (0.0, 0.0),
    Quality.SINGLE: (5.0, 10.0),
    Quality.FLOAT: (1.0, 2.0),
    Quality.FIXED: (0.05, 0.1),
    Quality.SURVEYED: (0.05, 0.05),
}


def _from_zero(names: str) -> dict[int, Quality]:
    """The qualities of those names by the codes 0, 1, 2 and so on."""
    return {code: Quality[name] for code, name in enumerate(names.split())}


# Codes of others -> ours. NMEA GGA: 1 GPS, 2 differential, 3 PPS, 4 RTK fixed, 5 RTK float, 6 dead
# reckoning, which is no position from outside. RTKLIB: 1 fixed, 2 float, 3 SBAS, 4 differential,
# 5 single, 6 PPP.
CODES: dict[str, dict[int, Quality]] = {
    "gprodom": {int(quality): quality for quality in Quality},
    "nmea": _from_zero("NONE SINGLE SINGLE SINGLE FIXED FLOAT NONE"),
    "rtklib": _from_zero("NONE FIXED FLOAT SINGLE SINGLE SINGLE FLOAT"),
}


def known(covariance: Floats) -> Bools:
    """Which of the covariances (n, 3, 3), m^2, say anything."""
    variances = np.diagonal(covariance, axis1=1, axis2=2)
    return np.asarray(np.isfinite(covariance).all(axis=(1, 2)) & (variances > 0).all(axis=1))


def conservative(quality: Ints) -> Floats:
    """Covariances (n, 3, 3) where none are told."""
    sigmas = np.array([UNKNOWN_SIGMA[Quality(q)] for q in quality.tolist()]).reshape(-1, 2)
    return diagonal(sigmas[:, [0, 0, 1]])


def horizontal_sigma(covariance: Floats) -> Floats:
    """Of the worse of the first two axes, m."""
    variances = np.diagonal(covariance, axis1=1, axis2=2)[:, :2]
    return np.asarray(np.sqrt(np.maximum(variances, 0).max(axis=1)))


def navsat_quality(status: Ints, covariance: Floats, told: Bools) -> Ints:
    """Of NavSatFix's status. GBAS stands for carrier phases: fixed where the covariance is of
    centimetres, else float."""
    centimetres = told & (horizontal_sigma(covariance) <= CENTIMETRES)
    carrier = np.where(centimetres, Quality.FIXED, Quality.FLOAT)
    quality = np.where(status >= 2, carrier, Quality.SINGLE)
    return np.where(status < 0, Quality.NONE, quality).astype(np.int64)


def pose_quality(covariance: Floats, told: Bools) -> Ints:
    """Of another program's pose: as good as its covariance."""
    centimetres = told & (horizontal_sigma(covariance) <= CENTIMETRES)
    return np.where(centimetres, Quality.FIXED, Quality.FLOAT).astype(np.int64)
