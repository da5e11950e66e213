"""A made-up log of a drive whose troubles are known, for tests of what shows a drive."""

from pathlib import Path

import numpy as np

from gprodom.lcm.constants import flag
from packets import correction, packet, status, write_events

START_US = 1_700_000_000_000_000
SECONDS, STANDS_S = 120, 5
SPEED, RADIUS = 0.5, 5.0  # m/s; m, of the circle that it drives
SILENT_S = (60.0, 63.0)  # without a pose
SLIPS_S = ((20.0, 24.0), (40.0, 41.5))  # the wheel spins
DEGRADED_S = (80, 90)  # STATUS: no data of the radar


def along(t: float) -> float:
    """Distance driven (m)."""
    return SPEED * max(0.0, t - STANDS_S)


def place(t: float) -> list[float]:
    """x and y, of the circle to the left."""
    turned = along(t) / RADIUS
    return [RADIUS * np.sin(turned), RADIUS * (1 - np.cos(turned))]


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
    write_events(path, events)


def _stamp(t: float) -> int:
    return START_US + round(1e6 * t)


def _pose(t: float, frame: str) -> tuple[str, bytes]:
    turned = along(t) / RADIUS
    covariance = np.diag([1e-6] * 5 + [1e-5])
    covariance[:2, :2] = spread(t)
    flags = flag("STANDING") if t <= STANDS_S else 0
    if any(begin <= t < end for begin, end in SLIPS_S):
        flags |= flag("SLIPPING") | flag("WHEEL_FAST")
    pose = packet(
        "odometry_t",
        utime=_stamp(t),
        frame=frame,
        position=[*place(t), 0.0],
        orientation=[np.cos(turned / 2), 0.0, 0.0, np.sin(turned / 2)],
        velocity=[SPEED if t > STANDS_S else 0.0, 0.0, 0.0],
        pose_covariance=covariance.ravel().tolist(),
        wheel_scale=1.01,
        wheel_scale_sigma=0.002,
        distance=along(t),
        flags=flags,
    )
    return ("ODOMETRY" if frame == "odom" else "ODOMETRY_MAP"), pose


def _status(t: float) -> bytes:
    degraded = DEGRADED_S[0] <= t < DEGRADED_S[1]
    # The figure in it changes every second.
    reasons = [f"GPR_TRACE: no data for {t:.1f} s or more"] if degraded else []
    reasons += ["map: searching for earlier ground"] if t >= 85 else []
    counted = 2.0 * (t >= 30) + 1.0 * (t >= 50)
    values = {"states": t, "GPR_TRACE: trace with a spike": counted}
    return status(_stamp(t), values, int(degraded), reasons)


def _imu(t: float) -> bytes:
    rate = [0.0, 0.0, SPEED / RADIUS if t > STANDS_S else 0.0]
    force = [0.0, 0.0, 9.81]
    return packet("imu_t", utime=_stamp(t), linear_acceleration=force, angular_velocity=rate)


def _wheel(t: float) -> bytes:
    ticks = round(1000 * along(t))
    return packet("wheel_t", utime=_stamp(t), ticks=ticks, metres_per_tick=0.001)


def _trace(t: float) -> bytes:
    depth = np.arange(101)
    ground = 1000 * np.sin(0.3 * depth + 3 * along(t)) * np.exp(-depth / 40)
    samples = np.rint(ground).astype(int).tolist()
    count = {"seq": round(10 * t), "num_samples": len(samples)}
    return packet("gpr_trace_t", utime=_stamp(t), sample_interval=2e-10, samples=samples, **count)


def _revisit(then: float, now: float) -> bytes:
    times = {"utime": _stamp(now), "utime_from": _stamp(then), "utime_to": _stamp(now)}
    return packet("displacement_t", **times, source="revisit", kind=2, valid=True)


def _correction(now: float) -> bytes:
    return correction(_stamp(now), 0.001 * now)
