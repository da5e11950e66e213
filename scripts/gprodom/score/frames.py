"""Where the frame of a published path begins.

A drive that starts with ground of an earlier run publishes in the frame of its own start until the
radar has located it in the earlier map, and from then on in the frame of that map. After a reset
all frames begin anew. Poses of two frames have no path, error or covariance in common, so that the
last frame is scored.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from gprodom.console import warn
from gprodom.lcm import logs
from gprodom.score.jumps import Jump
from gprodom.trajectory import Trajectory

# A correction comes into force with the next pose, twice a second at the slowest; STATUS tells once
# a second, of all before it.
SLACK_US = 1_000_000


@dataclass(frozen=True)
class FrameStart:
    """The last frame begins `utime` (us), after `driven_m` (m) in others, because the robot was
    `located` in an earlier map, or by a `reset`."""

    utime: int
    driven_m: float
    why: Literal["located", "reset"]


def frame_start(
    odometry: logs.Channel, status: logs.Channel | None, jumps: list[Jump]
) -> FrameStart | None:
    """None where all is in one frame.

    odometry: as published in `odom`. status: None where the log has none, and for poses in `odom`,
    which locating does not touch. jumps: of `map`, by the corrections.
    """
    order = np.argsort(odometry["utime"], kind="stable")
    time, distance = odometry["utime"][order], odometry["distance"][order]
    steps = np.diff(distance)  # of an unsigned distance: it falls by a reset alone
    driven = np.concatenate([[0.0], np.cumsum(np.maximum(steps, 0))])
    begins: list[tuple[int, Literal["located", "reset"]]] = [
        (int(time[i + 1]), "reset") for i in np.flatnonzero(steps < 0)
    ]
    if status is not None:
        begins += [(utime, "located") for utime in _located(status, jumps)]
    if not begins:
        return None
    utime, why = max(begins)
    before = max(int(np.searchsorted(time, utime)) - 1, 0)
    return FrameStart(utime, float(driven[before]), why)


def _located(status: logs.Channel, jumps: list[Jump]) -> list[int]:
    """Times at which a track that had been searching was located: of the largest jump of `map`
    about the first STATUS that says so."""
    found = []
    searching_until: int | None = None
    for one in status["messages"]:
        values = dict(zip(one.names, one.values, strict=True))
        if "map.sigma_m" in values:  # located; it stays there where the robot is lost later
            if searching_until is not None:
                near = [j for j in jumps if searching_until <= j.utime <= one.utime + SLACK_US]
                found.append(max(near, key=lambda jump: jump.metres).utime if near else one.utime)
            searching_until = None
        elif "map.located" in values:
            searching_until = int(one.utime)
    return found


def in_last_frame(path: Trajectory, start: FrameStart | None) -> Trajectory:
    """The part of a path that is in one frame with its end."""
    return path if start is None else path.select(path.time >= start.utime)


def warn_of_frames(path: Trajectory, start: FrameStart | None) -> None:
    """Says what is left out."""
    if start is None:
        return
    what = "located in an earlier map" if start.why == "located" else "reset"
    seconds = (start.utime - int(path.time[0])) * 1e-6
    warn(
        f"{what} {seconds:.1f} s after the first pose, {start.driven_m:.1f} m driven: the path "
        "before is in another frame and is left out"
        + ("; --frame odom takes all of it, without the map" if start.why == "located" else "")
    )
