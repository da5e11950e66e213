"""Plain dead reckoning: distance along the track, and gyro yaw less its bias.

Logs are as `gprodom.lcm.logs.read_roles` gives them.
"""

from collections.abc import Iterator

import numpy as np

from gprodom import rotation
from gprodom.arrays import Floats, integral
from gprodom.errors import Error
from gprodom.lcm import logs
from gprodom.odometry.causal_yaw import CausalYaw, causal_yaw
from gprodom.trajectory import Times, Trajectory

Span = tuple[int, int]  # microseconds

MOVED_M = 1e-3  # when the wheel has turned this far, the first standstill has ended
MIN_STANDSTILL_S = 0.5
IMU_FIELDS = ("linear_acceleration", "angular_velocity")
SETTLED_S = 1.0  # of a standstill on the way, at either end: the robot may still roll or rock


def yaw_from_gyro(imu_time: Times, acceleration: Floats, gyro: Floats, still: Span) -> Floats:
    """Yaw (n,), rad, 0 at the first sample: angular rate about gravity, less its bias.

    imu_time (n,) microseconds; acceleration (n, 3) m/s^2 and gyro (n, 3) rad/s in the IMU's axes,
    at whatever rotation it is mounted. Gravity and bias are means over the standstill `still`
    (microseconds). The floor must be so level that gravity keeps its direction in the robot.
    """
    seconds = (imu_time - imu_time[0]) * 1e-6
    during = (imu_time >= still[0]) & (imu_time <= still[1])
    if not during.any() or np.ptp(seconds[during]) < MIN_STANDSTILL_S:
        raise Error(
            f"the robot does not stand for {MIN_STANDSTILL_S:g} s at the start, nor for "
            f"{MIN_STANDSTILL_S + 2 * SETTLED_S:g} s on the way: no gyro bias, so no dead reckoning"
        )
    up = acceleration[during].mean(axis=0)
    up /= np.linalg.norm(up)
    return integral((gyro - gyro[during].mean(axis=0)) @ up, seconds)


def first_motion(wheel_time: Times, distance: Floats) -> int:
    """Time (microseconds) of the last wheel reading before the wheel has moved `MOVED_M`."""
    moving = np.abs(distance - distance[0]) > MOVED_M
    return int(
        wheel_time[-1] if not moving.any() else wheel_time[max(int(np.argmax(moving)) - 1, 0)]
    )


def standstill(wheel_time: Times, distance: Floats) -> Span:
    """The standstill at the start; if the robot moves from the start, the longest one later.

    Start and end (microseconds); equal if there is none.
    """
    first = first_motion(wheel_time, distance)
    if (first - wheel_time[0]) * 1e-6 >= MIN_STANDSTILL_S:
        return int(wheel_time[0]), first
    # A stretch in which the wheel stays within MOVED_M of where it was at its start.
    best, start = (0, 0), 0
    for end in range(1, len(distance)):
        if abs(distance[end] - distance[start]) > MOVED_M:
            start = end
        elif wheel_time[end] - wheel_time[start] > best[1] - best[0]:
            best = int(wheel_time[start]), int(wheel_time[end])
    settled = round(SETTLED_S * 1e6)
    if best[1] - best[0] <= 2 * settled:
        return best[0], best[0]
    return best[0] + settled, best[1] - settled


def stays(distance: Floats, still_m: float) -> Iterator[tuple[int, int]]:
    """First and last row of each stretch in which the wheel is within `still_m` of its begin."""
    start = 0
    for i in range(1, len(distance) + 1):
        if i == len(distance) or not abs(distance[i] - distance[start]) < still_m:
            yield start, i - 1
            start = i


def integrate(time: Times, distance: Floats, yaw_time: Times, yaw: Floats) -> Trajectory:
    """Trajectory at `time` (m,) from signed cumulative distance (m,) and yaw (n,) at `yaw_time`.

    Each step has the direction of the yaw at its middle. Starts at the origin, with yaw 0 at
    time[0].
    """
    origin = time[0]
    stamps, clock = (time - origin) * 1e-6, (yaw_time - origin) * 1e-6
    heading = np.interp(stamps, clock, yaw)
    middle = np.interp(0.5 * (stamps[1:] + stamps[:-1]), clock, yaw) - heading[0]
    step = np.diff(distance)
    position = np.zeros((time.size, 3))
    position[1:, 0] = np.cumsum(step * np.cos(middle))
    position[1:, 1] = np.cumsum(step * np.sin(middle))
    return Trajectory(time, position, rotation.from_yaw(heading - heading[0]))


def wheel_distance(log: logs.Log) -> tuple[Times, Floats]:
    """Times (n,) and signed cumulative wheel distance (n,), metres, of a log's wheel.

    With left and right wheels it is their mean, as in the estimator.
    """
    if "wheels" in log:
        pair = log["wheels"]
        mean = 0.5 * (pair["left_ticks"] + pair["right_ticks"]) * pair["metres_per_tick"]
        return pair["utime"], np.asarray(mean, dtype=float)
    wheel = logs.need(log, "wheel")
    return wheel["utime"], np.asarray(wheel["ticks"] * wheel["metres_per_tick"], dtype=float)


def has_wheel(log: logs.Log) -> bool:
    """Whether the log has a wheel, for `wheel_distance`."""
    return "wheel" in log or "wheels" in log


def gyro_yaw(log: logs.Log) -> tuple[Times, Floats]:
    """Times (n,) and causal yaw (n,), rad, of a log's IMU (`causal_yaw`)."""
    imu = logs.need(log, "imu")
    time, acceleration, rate = (imu[name] for name in ("utime", *IMU_FIELDS))
    return time, causal_yaw(time, acceleration, rate, *wheel_distance(log))


def gyro_yaw_of(log: logs.Log, still: Span) -> tuple[Times, Floats]:
    """Times (n,) and yaw (n,), rad, with the bias of a given standstill (`yaw_from_gyro`);
    without one, gravity is the mean over the whole log and the bias is not removed, which is good
    enough for some seconds."""
    imu = logs.need(log, "imu")
    time, acceleration, rate = (imu[name] for name in ("utime", *IMU_FIELDS))
    if still[1] - still[0] >= MIN_STANDSTILL_S * 1e6:
        return time, yaw_from_gyro(time, acceleration, rate, still)
    up = acceleration.mean(axis=0)
    return time, integral(rate @ (up / np.linalg.norm(up)), (time - time[:1]) * 1e-6)


def wheel_and_gyro(log: logs.Log) -> Trajectory:
    """The method `wheel`: wheel distance with gyro yaw, at the wheel's stamps."""
    return integrate(*wheel_distance(log), *gyro_yaw(log))


class Reckoner:
    """`wheel_and_gyro` of a log that comes piece by piece."""

    def __init__(self) -> None:
        self._yaw = CausalYaw()
        none = np.zeros(0, np.int64)
        self._heading: tuple[Times, Floats] = (none, np.zeros(0))
        self._wheel: tuple[Times, Floats] = (none, np.zeros(0))
        self._pose: Trajectory | None = None  # told last

    def add(self, log: logs.Log, is_all: bool = False) -> Trajectory | None:
        """The way from the pose told last on, as far as IMU and wheel show it; None: no further.

        log: what came since; stamps must go on from those before. is_all: nothing more comes.
        """
        none = np.zeros(0, np.int64)
        wheel: tuple[Times, Floats] = none, np.zeros(0)
        if has_wheel(log):
            wheel = wheel_distance(log)
        imu = log.get("imu", {"utime": none, **dict.fromkeys(IMU_FIELDS, np.zeros((0, 3)))})
        acceleration, gyro = (imu[name] for name in IMU_FIELDS)
        told = self._yaw.add(imu["utime"], acceleration, gyro, *wheel, is_all)
        self._heading = _joined(self._heading, told)
        self._wheel = _joined(self._wheel, wheel)
        if not len(self._heading[0]):
            return None
        known = len(self._wheel[0])
        if not is_all:
            known = int(np.searchsorted(self._wheel[0], self._heading[0][-1], side="right"))
        if known < 2:
            return None
        time, distance = self._wheel[0][:known], self._wheel[1][:known]
        way = integrate(time, distance, *self._heading)
        if self._pose is not None:
            assert self._pose.orientation is not None
            matrix = rotation.to_matrix(self._pose.orientation)[0]
            way = way.transformed(matrix, self._pose.position[0])
        self._pose = way.select(np.array([len(way) - 1]))
        self._wheel = (self._wheel[0][known - 1 :], self._wheel[1][known - 1 :])
        first = max(int(np.searchsorted(self._heading[0], time[-1], side="right")) - 1, 0)
        self._heading = (self._heading[0][first:], self._heading[1][first:])
        return way


def _joined(before: tuple[Times, Floats], new: tuple[Times, Floats]) -> tuple[Times, Floats]:
    return np.concatenate([before[0], new[0]]), np.concatenate([before[1], new[1]])
