"""IMU and wheel against each other: axes, signs, sizes, counters."""

import math
from collections.abc import Iterator

import numpy as np

from gprodom.arrays import Floats
from gprodom.calibrate.mount import (
    STILL_MPS,
    WINDOW_S,
    Mount,
    Turned,
    find_mount,
    turned,
    windows_of,
)
from gprodom.calibrate.offset import BLOCKS
from gprodom.convert.plausible import longest_constant
from gprodom.doctor.finding import SIGMAS, Finding, Log, seconds_of
from gprodom.errors import Error
from gprodom.odometry.dead_reckoning import MIN_STANDSTILL_S, standstill, wheel_distance

# rad. An IMU that is turned by more than this gives a twentieth of a turn's force along the track;
# ground on which a robot drives is less steep in the mean.
TURNED = math.radians(20)
# Of the wheel's changes of speed over the accelerometer's: slipping robots, and cars with slack,
# show 0.3 to 1.3 (convert/plausible.py); a wrong unit or tick size is off by 4 or more.
SIZE = 3.0
FASTEST_CHANGE = 50.0  # m/s^2: five times gravity, which no wheel on the ground follows
JUMP_M = 0.3  # a counter that starts anew; below, noise and slip
AGREED = 2.0  # standard errors of the mean of parts, beside SIGMAS of all of it
STUCK_S = 1.0  # twenty samples or more (stamps.py) of six values with noise
MOUNT = "`gprodom calibrate mount LOG`, which finds imu.rpy_body_imu"


def check_counters(log: Log) -> Iterator[Finding]:
    """Steps that no wheel makes: a counter that begins anew, or has overflown."""
    time, distance = wheel_distance(log)
    seconds = seconds_of(time)
    steps, spans = np.diff(distance), np.maximum(np.diff(seconds), 1e-6)
    if len(steps) < 3:
        return
    speeds = steps / spans
    expected = spans * np.concatenate([[np.median(speeds)], speeds[:-1]])
    odd = np.abs(steps - expected) > np.maximum(JUMP_M, FASTEST_CHANGE * spans**2)
    if odd.any():
        where = int(np.argmax(odd))
        yield Finding(
            "counter",
            f"wheel: it jumps by {steps[where]:.3g} m, {seconds[where]:.1f} s after its first "
            "message: its counter began anew or has overflown",
            "carry the count on in the driver (`gprodom convert tables` does), as int64",
        )


def check_scale(log: Log) -> Iterator[Finding]:
    """At rest: what the estimator takes for a scale of the accelerometer, not for a bias."""
    try:
        from gprodom._core import accel_scale_at_rest
    except ModuleNotFoundError:  # the package alone, without the estimator
        return
    imu = log["imu"]
    begin, end = standstill(*wheel_distance(log))
    rests = (imu["utime"] >= begin) & (imu["utime"] <= end)
    if (end - begin) * 1e-6 < MIN_STANDSTILL_S or not rests.any():
        return
    force = float(np.linalg.norm(imu["linear_acceleration"][rests].mean(axis=0)))
    scale = accel_scale_at_rest(force)
    if scale != 1.0:
        yield Finding(
            "acceleration",
            f"IMU: at rest it measures {force:.2f} m/s^2, {100 * scale:.0f} % of gravity: the "
            "estimator takes that as its scale",
            "its range setting, or its unit in the driver",
        )


def check_stuck(log: Log) -> Iterator[Finding]:
    """Noise and the drive change the last bits of a sensor that measures; at rest a coarse one may
    stay the same."""
    imu = log["imu"]
    time, distance = wheel_distance(log)
    around = 500_000 * np.array([[-1], [1]])
    moved = np.abs(np.diff(np.interp(imu["utime"] + around, time, distance), axis=0)[0])
    drives = moved > STILL_MPS
    if drives.sum() < 2:
        return
    both = np.column_stack([imu["linear_acceleration"], imu["angular_velocity"]])
    constant = longest_constant(imu["utime"][drives], both[drives])
    if constant > STUCK_S:
        yield Finding(
            "stuck",
            f"IMU: it repeats its values for {constant:.1f} s of driving to the last bit",
            "look at the sensor and the driver; cut the recording there",
        )


def mount_of(log: Log, arm: tuple[float, ...]) -> Mount | None:
    """How the IMU is turned, if the drive shows it. arm: imu.lever_arm, m."""
    try:
        return find_mount(log, arm)
    except Error:
        return None


def check_axes(log: Log, rpy: tuple[float, ...], mount: Mount | None) -> Iterator[Finding]:
    """How the IMU is turned, whether its gyro turns as it feels, and how far the wheel drives, by
    accelerations at the origin. rpy: imu.rpy_body_imu, rad; mount: as the drive shows it."""
    try:
        windows = windows_of(log, WINDOW_S, 0.0)
    except Error:
        return
    force = windows[:, :3]
    up = force.mean(axis=0) / np.linalg.norm(force.mean(axis=0))
    roll, pitch, yaw = rpy
    # Up, in the IMU's axes, by its mounting.
    stated = [-math.sin(pitch), math.sin(roll) * math.cos(pitch), math.cos(roll) * math.cos(pitch)]
    off = math.acos(float(np.clip(up @ stated, -1, 1)))
    if off > TURNED:
        axis = "xyz"[int(np.argmax(np.abs(up)))]
        sign = "-" if up["xyz".index(axis)] < 0 else ""
        yield Finding(
            "axes",
            f"IMU: up is its {sign}{axis} axis, {math.degrees(off):.0f} degrees from where the "
            "configuration has it",
            MOUNT,
        )
    turn = turned(windows)
    if _gyro_is_reversed(windows, turn):
        yield Finding(
            "gyro sign",
            "IMU: in bends the robot feels a force to the side that its gyro turns away from",
            "correct the sign of the gyro's axes in the driver",
        )
        return
    yield from _size(turn)
    if mount is None:
        return
    aside = math.remainder(mount.rpy[2] - yaw, 2 * math.pi)
    if off <= TURNED and abs(aside) > TURNED + SIGMAS * mount.sigma[2]:
        behind = abs(aside) > math.pi / 2
        yield Finding(
            "axes",
            f"IMU: turned by {math.degrees(aside):.0f} +- {math.degrees(mount.sigma[2]):.0f} "
            "degrees about up from where the configuration has it"
            + (", or the wheel counts backwards" if behind else ""),
            MOUNT + (", or the wheel's sign in the driver" if behind else ""),
        )


def _slope(turn: Turned) -> float:
    """What is felt over what is wanted."""
    return float(np.sum(turn.wanted * turn.felt) / (np.sum(turn.wanted**2) + 1e-300))


def _left(turn: Turned) -> Floats:
    """(n,): squares of what is felt beyond what is wanted, whatever the wheel's size."""
    return np.asarray(np.sum((turn.felt - _slope(turn) * turn.wanted) ** 2, axis=1))


def _gyro_is_reversed(windows: Floats, turn: Turned) -> bool:
    """By the likelihoods of both signs, if forces that neither tells were noise; and since they are
    not (a robot that skids turns about another place), parts of the drive must agree."""
    reversed_ = windows.copy()
    reversed_[:, 3:6] *= -1
    usual, other = _left(turn), _left(turned(reversed_))
    gain = 0.5 * len(windows) * math.log((usual.sum() + 1e-9) / (other.sum() + 1e-9))
    parts = np.array([part.sum() for part in np.array_split(usual - other, BLOCKS)])
    sigma = float(parts.std(ddof=1)) / math.sqrt(BLOCKS)
    return gain > SIGMAS**2 / 2 and float(parts.mean()) > AGREED * sigma


def size_of(turn: Turned) -> tuple[float, float]:
    """What the accelerometer feels over the wheel's accelerations, forwards and in bends, and its
    standard deviation."""
    sigma = math.sqrt(float(_left(turn).mean()) / 2 / (float(np.sum(turn.wanted**2)) + 1e-300))
    return _slope(turn), sigma


def size_is_wrong(slope: float, sigma: float) -> bool:
    """Whether a unit is wrong, and not the ground."""
    large, small = slope - SIGMAS * sigma, slope + SIGMAS * sigma
    return slope > SIGMAS * sigma and (large > SIZE or small < 1 / SIZE)


def _size(turn: Turned) -> Iterator[Finding]:
    slope, sigma = size_of(turn)
    if size_is_wrong(slope, sigma):
        yield Finding(
            "tick size",
            f"wheel: its accelerations are {1 / slope:.2g} of what the accelerometer feels",
            "metres_per_tick in the driver: drive a measured way, `gprodom calibrate wheel`; of "
            "tables in counts, `gprodom convert tables --wheel-counts --counts-per-metre`",
        )


def check_sides(log: Log) -> Iterator[Finding]:
    """Left and right wheels against the gyro."""
    if "wheels" not in log:
        return
    windows = windows_of(log, WINDOW_S, 0.0)
    wheels = log["wheels"]
    apart = np.subtract(wheels["right_ticks"], wheels["left_ticks"]).astype(np.float64)
    first = max(int(wheels["utime"][0]), int(log["imu"]["utime"][0]))
    edges = first + round(WINDOW_S * 1e6) * np.arange(len(windows) + 1)
    turned = np.diff(np.interp(edges, wheels["utime"], apart))
    up = windows[:, :3].mean(axis=0)
    rate = windows[:, 3:6] @ (up / np.linalg.norm(up))
    link = float(np.corrcoef(turned, rate)[0, 1]) if np.ptp(turned) > 0 else 0.0
    if link < -SIGMAS / math.sqrt(len(windows)):
        yield Finding(
            "sides",
            f"wheels: by them the robot turns to the other side than by the gyro (correlation "
            f"{link:.2f})",
            "swap left and right in the driver (or the gyro's sign)",
        )
