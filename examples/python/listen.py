#!/usr/bin/env python3
"""Prints the robot's position as gprodomd estimates it: listen.py [COUNT [URL]]

COUNT messages of the channel ODOMETRY_MAP (0: without end), from LCM at URL.
"""

from __future__ import annotations

import math
import sys

from gprodom.lcm import DEFAULT_URL, LCM
from gprodom.lcm.messages import message

odometry_t = message("odometry_t")


def show(channel: str, data: bytes) -> None:
    """Position in `frame` (m), heading (deg), and the standard deviation of the position (m)."""
    m = odometry_t.decode(data)
    w, x, y, z = m.orientation
    yaw = math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
    sigma = math.sqrt(m.pose_covariance[0] + m.pose_covariance[7])
    print(
        f"{m.utime} {m.frame} {m.position[0]:.3f} {m.position[1]:.3f} "
        f"{math.degrees(yaw):.1f} +-{sigma:.3f}",
        flush=True,
    )


def main(count: int = 0, url: str = DEFAULT_URL) -> None:
    """Listens."""
    lcm = LCM(url)
    lcm.subscribe("ODOMETRY_MAP", show)
    handled = 0
    while count == 0 or handled < count:
        lcm.handle()
        handled += 1


if __name__ == "__main__":
    main(*(convert(text) for convert, text in zip((int, str), sys.argv[1:], strict=False)))
