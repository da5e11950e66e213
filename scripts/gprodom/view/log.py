"""A drive from a log as a Rerun recording."""

import numpy as np

from gprodom.arrays import Ints
from gprodom.drive.imu_mounting import ImuMounting
from gprodom.drive.imu_speed import imu_speed
from gprodom.drive.log import Drive
from gprodom.drive.radargram import along_way, equalised, of_one_antenna
from gprodom.errors import Error
from gprodom.lcm.constants import flag, health
from gprodom.odometry.dead_reckoning import has_wheel
from gprodom.plot.log import radar_speed, wheel_speed
from gprodom.plot.revisits import find_revisits
from gprodom.trajectory import Trajectory, interpolate, thin
from gprodom.view.ground import AlongWay, ByTime, as_bytes
from gprodom.view.record import ON, Recorder

MOST_PIECES = 600  # of a path, and of the rings of 95 %: what a viewer draws at once without delay
MOST_POINTS = 8000  # of a path: each is a line to draw
ARROW = 0.06  # of the way's extent
LEAST_PERIOD_S = 1e-3  # of the radargram by time: a radar takes some ten traces a second
MOST_GAPS = 20  # columns of the radargram by time for each trace
MOST_ARCS = 150  # above the radargram: more are one blot
FLAG_LANES = {
    "standing": "STANDING",
    "slipping": "SLIPPING",
    "radar missing": "NO_RADAR",
    "wheel missing": "NO_WHEEL",
}
CURVE_US = 100_000  # between points of a curve
WAY_COLUMNS = 1600  # of the radargram along the way


def log_drive(recorder: Recorder, drive: Drive, mounting: ImuMounting) -> float:
    """Logs all of it; returns the columns of the radargram along the way."""
    piece_us = max(500_000, int(1e6 * drive.seconds / MOST_PIECES))
    point_us = max(CURVE_US, int(1e6 * drive.seconds / MOST_POINTS))
    path = thin(drive.path, CURVE_US)
    drawn: dict[str, Trajectory | None] = {"map": path, "odom": drive.odom_in_map}
    drawn |= {"wheel and gyro": drive.dead_reckoning, "truth": drive.aligned_truth}
    for name, each in drawn.items():
        if each is not None:
            recorder.path(name, thin(each, point_us), piece_us)
    recorder.arrow(ARROW * float(np.max(np.ptp(path.position[:, :2], axis=0))))
    recorder.robot(path)
    recorder.sigmas(path)
    _log_speeds(recorder, drive)
    if "imu" in drive.sensors:
        told = imu_speed(drive.sensors["imu"], drive.log["odometry"], mounting)
        rows = _every(told[0], CURVE_US) if len(told[0]) else np.zeros(0, int)
        recorder.scalars("/speed/IMU", told[0][rows], told[1][rows])
    _log_states(recorder, drive)
    _log_told(recorder, drive)
    _log_links(recorder, drive, piece_us)
    return _log_ground(recorder, drive)


def _log_speeds(recorder: Recorder, drive: Drive) -> None:
    odometry = drive.log["odometry"]
    rows = _every(odometry["utime"], CURVE_US)
    recorder.scalars("/speed/estimate", odometry["utime"][rows], odometry["velocity"][rows, 0])
    if has_wheel(drive.sensors):
        wheel = wheel_speed(drive.sensors)
        assert wheel is not None
        rows = _every(wheel[0], CURVE_US)
        recorder.scalars("/speed/wheel", wheel[0][rows], wheel[1][rows])
    if "displacement" in drive.log:
        recorder.scalars("/speed/radar", *radar_speed(drive.log["displacement"]))


def _every(utime: Ints, period_us: int) -> Ints:
    return np.append(np.flatnonzero(np.diff(utime // period_us)), len(utime) - 1)


def _log_states(recorder: Recorder, drive: Drive) -> None:
    odometry = drive.log["odometry"]
    utime, flags = odometry["utime"], odometry["flags"]
    if "status" in drive.log:
        messages = drive.log["status"]["messages"]
        values = [health(int(status.health)) for status in messages]
        recorder.state("health", drive.log["status"]["utime"], values)
    for name, bit in FLAG_LANES.items():
        on = (flags & flag(bit)) != 0
        if not on.any():  # no lane for what did not happen
            continue
        recorder.state(name, utime, [ON if each else "" for each in on])


def _log_told(recorder: Recorder, drive: Drive) -> None:
    """Each reason when it is first given, and again after it was gone."""
    if "status" not in drive.log:
        return
    told: set[str] = set()
    for status in drive.log["status"]["messages"]:
        told = recorder.reasons(status, health(int(status.health)), told)


def _log_links(recorder: Recorder, drive: Drive, piece_us: int) -> None:
    if "displacement" not in drive.log:
        return
    path = drive.path
    found = find_revisits(drive.log).within(path)
    there, here = (interpolate(path, each).position for each in (found.start, found.end))
    recorder.links(found.end, there, here, piece_us)


def _log_ground(recorder: Recorder, drive: Drive) -> float:
    """The radargram by time and along the way; the columns of the latter."""
    if "gpr_trace" not in drive.sensors:
        return 0.0
    radar, odometry = drive.sensors["gpr_trace"], drive.log["odometry"]
    driven = np.maximum.accumulate(odometry["distance"])
    try:
        image = along_way(radar, odometry["utime"], driven, WAY_COLUMNS)
    except Error:
        return 0.0
    way = AlongWay(recorder, image.length_m / WAY_COLUMNS)
    way.whole(as_bytes(image.echoes))
    way.depth_labels(image.span_ns)
    way.metres(image.length_m)
    rows = _every(odometry["utime"], CURVE_US)
    way.here(odometry["utime"][rows], driven[rows] - driven[0])
    if "displacement" in drive.log:
        found = find_revisits(drive.log).within(drive.odom)
        clock = drive.clock(odometry["utime"])
        then, now = (
            np.interp(drive.clock(each), clock, driven) - driven[0]
            for each in (found.start, found.end)
        )
        shown = slice(None, None, 1 + len(then) // MOST_ARCS)
        way.links(found.end[shown], then[shown], now[shown])
    _log_by_time(recorder, drive, image.span_ns)
    return float(WAY_COLUMNS)


def _log_by_time(recorder: Recorder, drive: Drive, span_ns: tuple[float, float]) -> None:
    stamps, traces = of_one_antenna(drive.sensors["gpr_trace"])
    if len(stamps) < 2:
        return
    period = max(float(np.median(np.diff(stamps))) * 1e-6, LEAST_PERIOD_S)
    origin = int(stamps.min())
    column = np.rint((stamps - origin) * 1e-6 / period).astype(int)
    if column.max() > MOST_GAPS * len(stamps):  # stamps that a clock has thrown far apart
        return
    echoes = np.full((traces.shape[1], int(column.max()) + 1), np.nan, np.float32)
    echoes[:, column] = equalised(traces)
    strip = ByTime(recorder, 1 / period)
    strip.whole(as_bytes(echoes))
    strip.depth_labels(span_ns)
    utime = drive.log["odometry"]["utime"]
    rows = _every(utime, CURVE_US)
    strip.now(utime[rows], (utime[rows] - origin) * 1e-6)
