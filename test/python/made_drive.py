"""A made-up log of a drive whose troubles are known, for tests of what shows a drive."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from gprodom.lcm import EventLog
from gprodom.lcm.constants import flag
from gprodom.lcm.messages import message

START_US = 1_700_000_000_000_000
SECONDS, STANDS_S = 120, 5
SPEED, RADIUS = 0.5, 5.0  # m/s; m, of the circle that it drives
SILENT_S = (60.0, 63.0)  # without a pose
SLIPS_S = ((20.0, 24.0), (40.0, 41.5))  # the wheel spins
DEGRADED_S = (80, 90)  # STATUS: no data of the radar


def along(t: float) -> float:
    """Distance driven (m)."""
    return SPEED * max(0.0, t - STANDS_S)


def spread(t: float) -> np.ndarray:
    """Covariance of x and y (m^2): an ellipse that grows, and lies askew."""
    return 1e-4 * (1 + t) * np.array([[1.0, 1.0], [1.0, 4.0]])


def write_drive(path: Path, seconds: int = SECONDS, sensors: bool = True) -> None:
    """Poses at 20 Hz, IMU at 100 Hz, wheel and traces at 10 Hz, as a recording of gprodomd has
    them; without `sensors` as the output of a replay."""
    events: list[tuple[int, str, bytes]] = []
    for tick in range(100 * seconds):
        t = tick / 100
        if tick % 5 == 0 and not SILENT_S[0] < t < SILENT_S[1]:
            events += [(_stamp(t), *_pose(t, frame)) for frame in ("odom", "map")]
        if tick % 100 == 0:
            events.append((_stamp(t), "STATUS", _status(t)))
        if sensors:
            events.append((_stamp(t), "IMU", _imu(t)))
            if tick % 10 == 0:
                events += [(_stamp(t), "WHEEL", _wheel(t)), (_stamp(t), "GPR_TRACE", _trace(t))]
    for then, now in ((20, 100), (30, 110)):
        events.append((_stamp(now), "GPR_DISPLACEMENT", _revisit(then, now)))
        events.append((_stamp(now), "CORRECTION", _correction(now)))
    log = EventLog(str(path), "w")
    for stamp, channel, data in sorted(events, key=lambda event: event[0]):
        log.write_event(stamp, channel, data)
    log.close()


def _stamp(t: float) -> int:
    return START_US + round(1e6 * t)


def _pose(t: float, frame: str) -> tuple[str, bytes]:
    pose = message("odometry_t")()
    turned = along(t) / RADIUS
    pose.utime, pose.frame = _stamp(t), frame
    pose.position = [RADIUS * np.sin(turned), RADIUS * (1 - np.cos(turned)), 0.0]
    pose.orientation = [np.cos(turned / 2), 0.0, 0.0, np.sin(turned / 2)]
    pose.velocity = [SPEED if t > STANDS_S else 0.0, 0.0, 0.0]
    covariance = np.diag([1e-6] * 5 + [1e-5])
    covariance[:2, :2] = spread(t)
    pose.pose_covariance = covariance.ravel().tolist()
    pose.wheel_scale, pose.wheel_scale_sigma = 1.01, 0.002
    pose.distance = along(t)
    pose.flags = flag("STANDING") if t <= STANDS_S else 0
    if any(begin <= t < end for begin, end in SLIPS_S):
        pose.flags |= flag("SLIPPING") | flag("WHEEL_FAST")
    return ("ODOMETRY" if frame == "odom" else "ODOMETRY_MAP"), pose.encode()


def _status(t: float) -> bytes:
    status = message("status_t")()
    degraded = DEGRADED_S[0] <= t < DEGRADED_S[1]
    status.utime, status.health = _stamp(t), int(degraded)
    # The figure in it changes every second.
    status.reasons = [f"GPR_TRACE: no data for {t:.1f} s or more"] if degraded else []
    status.reasons += ["map: searching for earlier ground"] if t >= 85 else []
    status.num_reasons = len(status.reasons)
    counted = 2.0 * (t >= 30) + 1.0 * (t >= 50)
    status.names = ["states", "GPR_TRACE: trace with a spike"]
    status.values = [t, counted]
    status.num_values = 2
    return bytes(status.encode())


def _imu(t: float) -> bytes:
    imu = message("imu_t")()
    imu.utime = _stamp(t)
    imu.linear_acceleration = [0.0, 0.0, 9.81]
    imu.angular_velocity = [0.0, 0.0, SPEED / RADIUS if t > STANDS_S else 0.0]
    return bytes(imu.encode())


def _wheel(t: float) -> bytes:
    wheel = message("wheel_t")()
    wheel.utime, wheel.metres_per_tick = _stamp(t), 0.001
    wheel.ticks = round(1000 * along(t))
    return bytes(wheel.encode())


def _trace(t: float) -> bytes:
    trace = message("gpr_trace_t")()
    trace.utime, trace.seq, trace.sample_interval = _stamp(t), round(10 * t), 2e-10
    depth = np.arange(101)
    ground = 1000 * np.sin(0.3 * depth + 3 * along(t)) * np.exp(-depth / 40)
    trace.samples = np.rint(ground).astype(int).tolist()
    trace.num_samples = len(trace.samples)
    return bytes(trace.encode())


def _revisit(then: float, now: float) -> bytes:
    sent = message("displacement_t")()
    sent.utime, sent.utime_from, sent.utime_to = _stamp(now), _stamp(then), _stamp(now)
    sent.source, sent.kind, sent.valid = "revisit", 2, True
    return bytes(sent.encode())


def _correction(now: float) -> bytes:
    sent = message("correction_t")()
    sent.utime, sent.orientation = _stamp(now), [1.0, 0.0, 0.0, 0.0]
    sent.position = [0.001 * now, 0.0, 0.0]
    return bytes(sent.encode())
