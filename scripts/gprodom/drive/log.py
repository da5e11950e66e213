"""One drive: what the estimator published, and what the sensors said."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from gprodom import rotation
from gprodom.arrays import Floats, Ints
from gprodom.config import TRUTH_CHANNEL, Channels
from gprodom.errors import Error
from gprodom.files import temporary_folder
from gprodom.lcm import logs
from gprodom.odometry.dead_reckoning import has_wheel, wheel_and_gyro
from gprodom.odometry.estimate import as_log
from gprodom.score.align import FIRST_M, fit
from gprodom.score.associate import associate
from gprodom.score.frames import FrameStart, frame_start
from gprodom.score.jumps import Jump, find_jumps
from gprodom.score.sources import odometry
from gprodom.trajectory import Trajectory, interpolate, joined, without_repeats

POSES_US = 50_000  # between poses that are kept: a robot moves some centimetres
PUBLISHED = ("odometry", "odometry_map", "correction", "displacement", "status")
SENSORS = ("imu", "wheel", "wheels", "gpr_trace")


@dataclass(frozen=True)
class Drive:
    """A log of the estimator, and the sensors' data where there are any.

    name: of the drive. log, sensors: channels by role (`gprodom.config.Channels`); `log` has
    odometry. truth: positions in a frame of their own, or None.
    """

    name: str
    log: logs.Log
    sensors: logs.Log
    truth: Trajectory | None = None

    @cached_property
    def odom(self) -> Trajectory:
        """The path in `odom`, which is smooth and drifts."""
        return odometry(self.log["odometry"])

    @cached_property
    def jumps(self) -> list[Jump]:
        """Steps of the pose in `map` by corrections."""
        return find_jumps(self.log.get("correction"), self.odom)

    @property
    def steps(self) -> list[Jump]:
        """The jumps in the last frame, without that which located the robot in it."""
        return [jump for jump in self.jumps if self.frame is None or jump.utime > self.frame.utime]

    @cached_property
    def frame(self) -> FrameStart | None:
        """Where the last frame begins; None: all of the path is in one."""
        return frame_start(self.log["odometry"], self.log.get("status"), self.jumps)

    @cached_property
    def path(self) -> Trajectory:
        """The path in `map` as published (in `odom` where there is no map), in its last frame.

        What was driven before the robot was located in an earlier map is carried into that map by
        the correction that located it; what was driven before a reset is left out.
        """
        published = self.log.get("odometry_map")
        path = self.odom if published is None else odometry(published)
        if self.frame is None:
            return path
        after = path.select(path.time >= self.frame.utime)
        corrections = self.log.get("correction")
        if self.frame.why == "reset" or corrections is None or not len(after):
            return after if len(after) else path
        row = int(np.argmin(np.abs(corrections["utime"] - self.frame.utime)))
        before = self.odom.select(self.odom.time < after.time[0])
        turn = rotation.to_matrix(corrections["orientation"][row : row + 1])[0]
        return joined([before.transformed(turn, corrections["position"][row]), after])

    @cached_property
    def odom_in_map(self) -> Trajectory:
        """The path in `odom`, of the last frame, moved to begin where that in `map` does."""
        odom = self.odom.select(self.odom.time >= self.path.time[0])
        return _placed(odom, odom.select(np.array([0])), self.path)

    @cached_property
    def dead_reckoning(self) -> Trajectory | None:
        """Wheel and gyro alone, from where the path begins; None where it cannot be had."""
        if not has_wheel(self.sensors) or "imu" not in self.sensors:
            return None
        try:
            reckoned = without_repeats(wheel_and_gyro(self.sensors))
        except Error:  # no standstill, so no bias of the gyro
            return None
        begin = np.clip(self.path.time[:1], reckoned.time[0], reckoned.time[-1])
        moved = _placed(reckoned, interpolate(reckoned, begin), self.path)
        return moved.select(moved.time >= begin[0])

    @cached_property
    def aligned_truth(self) -> Trajectory | None:
        """The truth moved onto the path (rotation and translation in the plane)."""
        if self.truth is None:
            return None
        try:
            there = fit(associate(self.path, self.truth), "se2", FIRST_M)
        except Error:  # of another time, or it does not move
            return None
        return there.inverse().apply(self.truth)

    @property
    def origin(self) -> int:
        """The first pose's time (us), from which seconds are counted."""
        return int(self.log["odometry"]["utime"][0])

    @property
    def seconds(self) -> float:
        """From the first pose to the last."""
        return float(self.log["odometry"]["utime"][-1] - self.origin) * 1e-6

    def clock(self, utime: Ints) -> Floats:
        """Seconds after the first pose."""
        return np.asarray((np.asarray(utime) - self.origin) * 1e-6)


def turned_onto(here: Trajectory, there: Trajectory) -> tuple[Floats, Floats]:
    """Rotation (3, 3), in the plane, and translation (3) that bring the first pose of `here` to
    that of `there`."""
    assert here.orientation is not None and there.orientation is not None
    turn = rotation.yaw_of(there.orientation[:1]) - rotation.yaw_of(here.orientation[:1])
    matrix = rotation.yaw_matrix(float(turn[0]))
    return matrix, there.position[0] - matrix @ here.position[0]


def _placed(way: Trajectory, here: Trajectory, path: Trajectory) -> Trajectory:
    """`way` moved in the plane, so that its pose `here` comes to the begin of `path`."""
    return way.transformed(*turned_onto(here, path))


def read_drive(
    path: Path, channels: Channels, sensors: Path | None = None, roles: Sequence[str] = SENSORS
) -> Drive:
    """A log of gprodom-replay, or a recording of gprodomd.

    sensors: the log or sequence with the sensors' data, where `path` has none. roles: which of them
    are read.
    """
    thinned = dict.fromkeys(("odometry", "odometry_map"), POSES_US)
    names = channels.of(*PUBLISHED)
    in_one = {**names, **_sensors(channels, roles)} if sensors is None else names
    log = logs.read_roles(path, in_one, thinned)
    if "odometry" not in log:
        raise Error(
            f"{path}: holds no {channels.odometry} messages; expected a log of the estimator, as "
            f"gprodom-replay -c CONFIG {path} -o OUT.lcmlog makes one"
        )
    if sensors is None:
        found = {role: log.pop(role) for role in set(log) - set(names)}
    else:
        with temporary_folder() as folder:
            source = as_log(sensors, folder, channels=channels)
            found = logs.read_roles(source, _sensors(channels, roles))
    truth = found.pop("truth", None)
    points = None if truth is None else Trajectory(truth["utime"], truth["position"])
    return Drive(path.stem, log, found, None if points is None else without_repeats(points))


def _sensors(channels: Channels, roles: Sequence[str]) -> dict[str, str]:
    return {**channels.of(*roles), "truth": TRUTH_CHANNEL}
