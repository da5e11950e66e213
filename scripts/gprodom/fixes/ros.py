"""NavSatFix and PoseWithCovarianceStamped as fixes."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from gprodom import rotation
from gprodom.arrays import Ints
from gprodom.console import warn
from gprodom.fixes import trust
from gprodom.fixes.record import Fixes, Frame, Quality

KINDS = ("sensor_msgs/msg/NavSatFix", "geometry_msgs/msg/PoseWithCovarianceStamped")
_WIDEST_HEADING = np.pi / 2  # rad; a sigma from which on a pose tells no heading


def read_fix(message: Any, kind: str) -> tuple[Any, ...]:
    """Position (3), covariance (9), status, whether the covariance is told, heading, its sigma."""
    if kind.endswith("NavSatFix"):
        return (
            (message.latitude, message.longitude, message.altitude),
            tuple(message.position_covariance),
            message.status.status,
            message.position_covariance_type > 0,
            np.nan,
            np.nan,
        )
    pose, covariance = message.pose.pose, np.asarray(message.pose.covariance).reshape(6, 6)
    p, q = pose.position, pose.orientation
    orientation = np.array([q.w, q.x, q.y, q.z])
    unit = abs(np.linalg.norm(orientation) - 1) < 0.01
    sigma = float(np.sqrt(max(covariance[5, 5], 0.0)))
    told = unit and 0 < sigma < _WIDEST_HEADING
    heading = rotation.yaw_of(orientation)
    return (
        (p.x, p.y, p.z),
        tuple(covariance[:3, :3].ravel()),
        0,
        True,
        heading if told else np.nan,
        sigma if told else np.nan,
    )


def fixes_of(
    topic: str,
    kind: str,
    time: Ints,
    values: Sequence[tuple[Any, ...]],
    antenna: int,
    quality: Quality | None = None,
) -> Fixes:
    """Of what `read_fix` gave. quality: of all that have a position, in place of what the messages
    say. What is not told is replaced by a conservative value, and that is told."""
    position, flat, status, told, heading, heading_sigma = (
        np.array(column, np.float64) for column in zip(*values, strict=True)
    )
    covariance = flat.reshape(-1, 3, 3)
    sure = (told > 0) & trust.known(covariance)
    geodetic = kind.endswith("NavSatFix")
    if geodetic:
        qualities = trust.navsat_quality(status.astype(np.int64), covariance, sure)
    else:
        qualities = trust.pose_quality(covariance, sure)
    nowhere = ~np.isfinite(position).all(axis=1)
    qualities[nowhere] = Quality.NONE
    position[qualities == Quality.NONE] = 0.0
    sure &= qualities != Quality.NONE
    if quality is not None:
        qualities[qualities != Quality.NONE] = quality
    covariance[~sure] = trust.conservative(qualities)[~sure]
    _tell(topic, qualities, sure)
    frame = Frame.GEODETIC if geodetic else Frame.SITE
    return Fixes(time, frame, position, covariance, qualities, antenna, heading, heading_sigma)


def _tell(topic: str, qualities: Ints, sure: Any) -> None:
    for each in Quality:
        count = int(np.count_nonzero((qualities == each) & ~sure))
        if count and each is not Quality.NONE:
            horizontal, vertical = trust.UNKNOWN_SIGMA[each]
            warn(
                f"{topic}: {count} of {len(qualities)} fixes do not tell their covariance: "
                f"{horizontal:g} m is taken for each horizontal axis and {vertical:g} m for the "
                f"vertical one (quality {each.name.lower()})"
            )
