"""``gprodom calibrate mount``: the rotation of the IMU's axes against the robot's."""

import argparse
import math
from dataclasses import asdict, dataclass

import numpy as np

from gprodom.arrays import Floats, Ints, integral
from gprodom.calibrate.fragment import Found, add_output_option, tell_found
from gprodom.calibrate.offset import BLOCKS, spread
from gprodom.config import read_lever_arm
from gprodom.console import add_json_flag
from gprodom.drive.imu_mounting import ImuMounting
from gprodom.errors import Error
from gprodom.lcm import logs
from gprodom.odometry.dead_reckoning import wheel_distance
from gprodom.odometry.estimate import read_sensors
from gprodom.options import Subparsers, add_command, add_config_options

WINDOW_S = 0.5  # over which everything is averaged
STILL_MPS = 0.02
MIN_S = 10.0  # of driving
ENOUGH_EXPLAINED = 0.1  # share of the horizontal acceleration; else more is tried
LONGER_WINDOW_S = 1.0  # for a wheel that is noisy
LATEST_S = 0.6  # by which a wheel may be late
LEAST_EXPLAINED = 0.05
MOST_YAW_SIGMA = 0.2  # rad, where it explains less than enough
ROUNDS = 10  # each a hundred times nearer than the one before
ARM_ROUNDS = 20  # each at least twice as near, where the robot moves as it turns
ARM_CLOSE = 1e-3  # rad
# rad: by the bias that an accelerometer has before it is known (0.03 m/s^2, kAccelBiasSigma), which
# tilts all parts of a drive alike.
TILT_BY_BIAS = 0.03 / 9.81

DESCRIPTION = """\
Finds imu.rpy_body_imu. Gravity gives roll and pitch. The forward acceleration (from the wheel's
speed) and the sideways one (speed times yaw rate) give the yaw. No standstill is needed. Use a
drive with starts, stops or bends, as level as possible, since the mean slope goes into the pitch.
Where they agree badly, the wheel may be noisy, or late: means over twice the time, and delays up to
0.6 s, are tried. Of an IMU beside the origin imu.lever_arm (-c, --set) must be known: what turning
adds there is taken out. Uncertainties are the spread over parts of the recording;
those of roll and pitch have the tilt by the accelerometer's bias as well.

examples:
  gprodom calibrate mount drive.lcmlog -o mount.yaml
"""


@dataclass(frozen=True)
class Mount:
    """rpy: roll, pitch, yaw of the IMU's axes in the body, rad; sigma of each. explained: share of
    the horizontal accelerations that wheel and gyro explain."""

    rpy: tuple[float, float, float]
    sigma: tuple[float, float, float]
    explained: float


def find_mount(log: logs.Log, arm: tuple[float, ...] = (0.0, 0.0, 0.0)) -> Mount:
    """Of a drive's log. arm: imu.lever_arm, m. What turning adds at the IMU looks like another yaw,
    and with a wrong yaw it is taken out wrongly. So both are corrected alternately."""
    if not any(arm):
        return _find(log)
    rpy = rpy_of(turned(windows_of(log, WINDOW_S, 0.0)).R)
    for _ in range(ARM_ROUNDS):
        found = _find({**log, "imu": ImuMounting(rpy, arm).at_origin(log["imu"])})
        moved = [math.remainder(a - b, math.tau) for a, b in zip(found.rpy, rpy, strict=True)]
        if max(map(abs, moved)) < ARM_CLOSE:
            return found
        rpy = found.rpy
    raise Error("the IMU's place hides its yaw: give a drive with more starts and stops")


def _find(log: logs.Log) -> Mount:
    windows = windows_of(log, WINDOW_S, 0.0)
    moving = np.abs(windows[:, 6]) > STILL_MPS
    if moving.sum() * WINDOW_S < MIN_S:
        raise Error(f"the robot drives for less than {MIN_S:g} s")
    found = _mount(windows)
    if found.explained < ENOUGH_EXPLAINED:
        tries = [
            _mount(windows_of(log, window_s, late_s))
            for window_s in (WINDOW_S, LONGER_WINDOW_S)
            for late_s in np.arange(0.0, LATEST_S + 0.05, 0.1)
        ]
        found = max(tries, key=lambda each: each.explained)
    doubtful = found.explained < ENOUGH_EXPLAINED and found.sigma[2] > MOST_YAW_SIGMA
    if found.explained < LEAST_EXPLAINED or doubtful:
        raise Error(
            f"wheel and gyro explain {100 * max(found.explained, 0):.0f} % of the horizontal "
            f"acceleration, and the yaw is good to {found.sigma[2]:.2f} rad: give a drive with "
            "more starts, stops and bends"
        )
    return found


def _mount(windows: Floats) -> Mount:
    found = turned(windows)
    whole = rpy_of(found.R)
    driven = np.cumsum(np.abs(windows[:, 6]) > STILL_MPS)
    # A part in which the robot stands shows no yaw, so each has as much driving in it.
    ends = np.searchsorted(driven, driven[-1] * np.arange(1, BLOCKS) / BLOCKS)
    parts = np.array([rpy_of(turned(part).R) for part in np.split(windows, ends)])
    off = (parts - whole + np.pi) % (2 * np.pi) - np.pi
    sigma = [spread(off[:, axis].tolist(), 0.0) for axis in range(3)]
    roll, pitch = (math.hypot(each, TILT_BY_BIAS) for each in sigma[:2])
    return Mount(whole, (roll, pitch, sigma[2]), found.explained)


def windows_of(log: logs.Log, window_s: float, late_s: float) -> Floats:
    """Means over windows (n, 8): force (3), rate (3), wheel speed, its change per second. late_s:
    of the wheel."""
    wheel_time, distance = wheel_distance(log)
    wheel_time = wheel_time - round(late_s * 1e6)
    imu = logs.need(log, "imu")
    first, last = max(wheel_time[0], imu["utime"][0]), min(wheel_time[-1], imu["utime"][-1])
    step = round(window_s * 1e6)
    if last - first < 10 * step:
        raise Error("IMU and wheel overlap for too short a time")
    edges = np.arange(first, last, step)
    force, rate = (
        _means(imu["utime"], imu[name], edges, window_s)
        for name in ("linear_acceleration", "angular_velocity")
    )
    speed = np.diff(np.interp(edges, wheel_time, distance)) / window_s
    return np.column_stack([force, rate, speed, np.gradient(speed, window_s)])


def _means(time: Ints, values: Floats, edges: Ints, window_s: float) -> Floats:
    seconds = (time - time[0]) * 1e-6
    summed = integral(values, seconds)
    at_edges = [np.interp((edges - time[0]) * 1e-6, seconds, column) for column in summed.T]
    return np.asarray(np.diff(np.array(at_edges), axis=1).T / window_s)


@dataclass(frozen=True)
class Turned:
    """R: R_body_imu (3, 3). wanted: (n, 2), accelerations forwards and to the left that wheel and
    gyro tell, less their means; felt: those that the accelerometer feels, with R. m/s^2."""

    R: Floats
    wanted: Floats
    felt: Floats

    @property
    def explained(self) -> float:
        """Share of what is felt."""
        return 1 - float(np.sum((self.felt - self.wanted) ** 2) / np.sum(self.felt**2))


def turned(windows: Floats) -> Turned:
    """How the IMU of windows (n, 8) of `windows_of` is turned."""
    force, rate, speed, faster = windows[:, :3], windows[:, 3:6], windows[:, 6], windows[:, 7]
    still = np.abs(speed) < STILL_MPS
    bias = np.median(rate[still], axis=0) if still.sum() >= 4 else np.zeros(3)
    gravity = force.mean(axis=0)
    for _ in range(ROUNDS):
        up = gravity / np.linalg.norm(gravity)
        level = np.eye(3)[np.argmin(np.abs(up))]
        x = np.cross(level, up) / np.linalg.norm(np.cross(level, up))
        axes = np.array([x, np.cross(up, x)])  # any two horizontal axes
        aside = speed * ((rate - bias) @ up)
        wanted = np.column_stack([faster, aside])
        wanted = wanted - wanted.mean(axis=0)
        seen = force @ axes.T - (force @ axes.T).mean(axis=0)
        cross = np.sum(wanted[:, 0] * seen[:, 1] - wanted[:, 1] * seen[:, 0])
        turn = np.arctan2(cross, np.sum(wanted * seen))
        forwards = np.cos(turn) * axes[0] + np.sin(turn) * axes[1]
        R = np.array([forwards, np.cross(up, forwards), up])
        gravity = (force - faster[:, None] * R[0] - aside[:, None] * R[1]).mean(axis=0)
    back = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    return Turned(R, wanted, seen @ back)


def rpy_of(R: Floats) -> tuple[float, float, float]:
    """Roll, pitch, yaw of Rz(yaw) Ry(pitch) Rx(roll)."""
    return (
        float(np.arctan2(R[2, 1], R[2, 2])),
        float(-np.arcsin(np.clip(R[2, 0], -1, 1))),
        float(np.arctan2(R[1, 0], R[0, 0])),
    )


def add_parser(subjects: Subparsers) -> None:
    """Adds ``calibrate mount``."""
    parser = add_command(subjects, "mount", "how the IMU is turned", DESCRIPTION, run)
    parser.operand("source", "SEQ|LOG")
    add_config_options(parser)
    add_output_option(parser)
    add_json_flag(parser)


def run(args: argparse.Namespace) -> int:
    """Runs ``calibrate mount``."""
    log = read_sensors(args, args.source, "imu", "wheel")
    mount = find_mount(log, read_lever_arm(args.configs, args.overrides, "imu.lever_arm"))
    value = "[" + ", ".join(f"{angle:.4f}" for angle in mount.rpy) + "]"
    sure = "+- " + ", ".join(f"{angle:.3f}" for angle in mount.sigma)
    sure += f"; {100 * mount.explained:.0f} % of the accelerations explained"
    return tell_found(args, [Found("imu.rpy_body_imu", value, sure)], asdict(mount))
