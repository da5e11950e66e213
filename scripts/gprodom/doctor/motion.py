"""IMU and wheel against each other: axes, signs, sizes, counters."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from gprodom.arrays import Floats
from gprodom.calibrate.mount import WINDOW_S, Turned, find_mount, turned, windows_of
from gprodom.convert.plausible import longest_constant
from gprodom.doctor.finding import SIGMAS, Finding, Log, seconds_of
from gprodom.errors import Error
from gprodom.odometry.dead_reckoning import wheel_distance

# rad. An IMU that is turned by more than this gives a twentieth of a turn's force along the track;
# ground on which a robot drives is less steep in the mean.
TURNED = math.radians(20)
# Of the wheel's changes of speed over the accelerometer's: slipping robots, and cars with slack,
# show 0.3 to 1.3 (convert/plausible.py); a wrong unit or tick size is off by 4 or more.
SIZE = 3.0
FASTEST_CHANGE = 50.0  # m/s^2: five times gravity, which no wheel on the ground follows
JUMP_M = 0.3  # a counter that starts anew; below, noise and slip
STUCK_S = 1.0  # twenty samples or more (stamps.py) of six values with noise
MOUNT = "`gprodom calibrate mount LOG`, which finds imu.rpy_body_imu"


def check_counters(log: Log) -> Iterator[Finding]:
    """Steps that no wheel makes: a counter that begins anew, or has overflown."""
    time, distance = wheel_distance(log)
    seconds = seconds_of(time)
    steps, spans = np.diff(distance), np.maximum(np.diff(seconds), 1e-6)
    if len(steps) < 3:
        return
    before = np.concatenate([[np.median(steps)], steps[:-1]])
    odd = np.abs(steps - before) > np.maximum(JUMP_M, FASTEST_CHANGE * spans**2)
    if odd.any():
        where = int(np.argmax(odd))
        yield Finding(
            "counter",
            f"wheel: it jumps by {steps[where]:.3g} m, {seconds[where]:.1f} s after its first "
            "message: its counter began anew or has overflown",
            "carry the count on in the driver (`gprodom convert tables` does), as int64",
        )


def check_stuck(log: Log) -> Iterator[Finding]:
    """Noise changes the last bits of a sensor that measures."""
    imu = log["imu"]
    both = np.column_stack([imu["linear_acceleration"], imu["angular_velocity"]])
    constant = longest_constant(imu["utime"], both)
    if constant > STUCK_S:
        yield Finding(
            "stuck",
            f"IMU: it repeats its values for {constant:.1f} s to the last bit, noise included",
            "look at the sensor and the driver; cut the recording there",
        )


def check_axes(log: Log, rpy: tuple[float, float, float]) -> Iterator[Finding]:
    """How the IMU is turned, whether its gyro turns as it feels, and how far the wheel drives. rpy:
    imu.rpy_body_imu, rad."""
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
    try:
        mount = find_mount(log)
    except Error:  # the drive does not show it
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


def _share(turn: Turned) -> float:
    """Of what is felt, explained by what is wanted times any number."""
    both = float(np.sum(turn.wanted * turn.felt))
    return both**2 / float(np.sum(turn.wanted**2) * np.sum(turn.felt**2) + 1e-300)


def _gyro_is_reversed(windows: Floats, turn: Turned) -> bool:
    """By the likelihoods of both signs; accelerations of windows are normal."""
    reversed_ = windows.copy()
    reversed_[:, 3:6] *= -1
    usual, other = _share(turn), _share(turned(reversed_))
    gain = len(windows) * math.log((1 - usual + 1e-9) / (1 - other + 1e-9))
    return gain > SIGMAS**2 / 2


def _size(turn: Turned) -> Iterator[Finding]:
    """Changes of speed by the wheel over those by the accelerometer."""
    wheel, felt = turn.wanted[:, 0], turn.felt[:, 0]
    slope = float(wheel @ felt / (wheel @ wheel + 1e-300))
    left = felt - slope * wheel
    sigma = math.sqrt(float(left @ left) / len(left) / (float(wheel @ wheel) + 1e-300))
    large, small = slope - SIGMAS * sigma, slope + SIGMAS * sigma
    if slope > SIGMAS * sigma and (large > SIZE or small < 1 / SIZE):
        yield Finding(
            "tick size",
            f"wheel: its changes of speed are {1 / slope:.2g} of what the accelerometer feels",
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
