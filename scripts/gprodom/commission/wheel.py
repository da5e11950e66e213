"""The wheel: its scale by accelerations, by a measured stretch or by a truth; the track of two."""

import math

import numpy as np

from gprodom.arrays import Floats
from gprodom.calibrate.mount import WINDOW_S, turned, windows_of
from gprodom.calibrate.offset import BLOCKS
from gprodom.calibrate.wheel import fit_wheel, make_windows
from gprodom.commission.parameter import CIRCLES, STARTS, STRAIGHT, Parameter
from gprodom.commission.sensors import STRAIGHT_RAD, heading_at_wheel, moves
from gprodom.doctor.finding import SIGMAS, Log
from gprodom.doctor.motion import size_is_wrong, size_of
from gprodom.errors import Error
from gprodom.odometry.dead_reckoning import wheel_distance
from gprodom.trajectory import Trajectory

TAPE_M = 0.01  # standard deviation of a taped distance between two marks, each by eye
ROLLING = 0.005  # m/sqrt(m): the error of a wheel without slip (wheel.noise)
# Of the longest move: a stretch that is driven back again has its length, but for slip and units.
NEARLY = 0.8
STILL = 1e-4  # of all that the wheel rolls: less is rest, whatever a tick is said to be long
TURN_S = 2.0  # stretches for the track: delays of a tenth of a second hardly count in them
ENOUGH_TURN = 2 * math.pi  # rad, turned altogether, to both sides
# Relative, by which accelerations are off alike in all of a drive: the wheel's are differences of
# means over `WINDOW_S`, which makes short starts and stops weaker.
SMOOTHED = 0.1
LARGEST_SIGMA = 0.1  # of the track, relative; less sure than that, a tape is better


def scale_by_accelerations(log: Log) -> Parameter:
    """Reported over true distance, good to some per cent: it shows a wrong unit."""
    name = "wheel scale, by accelerations"
    try:
        windows = windows_of(log, WINDOW_S, 0.0)
    except Error as error:
        return Parameter(name, remark=str(error), manoeuvre=STARTS)
    slope, sigma = size_of(turned(windows))
    if slope < SIGMAS * sigma:
        return Parameter(name, remark="hardly any acceleration is felt", manoeuvre=STARTS)
    scale = 1 / slope
    wide = scale * math.hypot(sigma / slope, SMOOTHED)
    wrong = size_is_wrong(slope, sigma)
    settings = (f"wheel.scale={scale:.4g}", f"wheel.scale_sigma={wide:.2g}") if wrong else ()
    remark = "a wrong metres_per_tick: correct it in the driver" if wrong else "no unit is wrong"
    return Parameter(name, "", (scale,), (wide,), settings, remark, STRAIGHT if wrong else "")


def scale_by_stretch(log: Log, stretch_m: float, before: float) -> Parameter:
    """From the longest straight move from rest to rest, which was measured by tape. before: scale
    that the log's distances are already divided by."""
    name = "wheel scale, by the stretch"
    time, distance = wheel_distance(log)
    heading = heading_at_wheel(log)
    middle = 0.5 * (heading[1:] + heading[:-1])
    steps = np.diff(distance)[:, None] * np.column_stack([np.cos(middle), np.sin(middle)])
    way = np.vstack([np.zeros(2), np.cumsum(steps, axis=0)])
    still = STILL * float(np.abs(np.diff(distance)).sum())
    straight = [
        (a, b)
        for a, b in moves(log, still)
        if np.abs(heading[a : b + 1] - np.median(heading[a : b + 1])).max() < STRAIGHT_RAD
    ]
    if not straight:
        return Parameter(
            name, remark="no straight move from a standstill to a standstill", manoeuvre=STRAIGHT
        )
    chords = np.array([np.linalg.norm(way[b] - way[a]) for a, b in straight])
    chosen = int(np.argmax(chords > NEARLY * chords.max()))
    begin, end = straight[chosen]
    scale = before * float(chords[chosen]) / stretch_m
    sigma = scale * math.hypot(TAPE_M, ROLLING * math.sqrt(stretch_m)) / stretch_m
    since = (time[begin] - time[0]) * 1e-6
    remark = f"of {chords[chosen] * before:.2f} m that the wheel told, from {since:.0f} s on"
    if distance[end] < distance[begin]:
        remark += (
            "; the wheel counted down: if that was forwards, correct its sign in the driver and "
            "record again"
        )
    settings = (f"wheel.scale={scale:.5f}", f"wheel.scale_sigma={sigma:.2g}")
    return Parameter(name, "", (scale,), (sigma,), settings, remark)


def scale_by_truth(log: Log, truth: Trajectory, before: float) -> Parameter:
    """As `gprodom calibrate wheel`."""
    name = "wheel scale, by the truth"
    try:
        found = fit_wheel(make_windows(log, truth))
    except Error as error:
        return Parameter(name, remark=str(error), manoeuvre=STRAIGHT)
    scale, sigma = before * found.scale, before * max(found.scale_sigma, 1e-4)
    settings = (f"wheel.scale={scale:.5f}", f"wheel.scale_sigma={sigma:.2g}")
    return Parameter(name, "", (scale,), (sigma,), settings, f"{found.windows} windows")


def track(log: Log, drive: str) -> Parameter:
    """The effective distance between left and right wheels. drive: wheel.drive."""
    name = "track"
    if "wheels" not in log:
        return Parameter(name, remark="one wheel: there is none")
    pair = log["wheels"]
    time, middle = wheel_distance(log)
    apart = np.subtract(pair["right_ticks"], pair["left_ticks"]) * pair["metres_per_tick"]
    edges = np.arange(time[0], time[-1], round(TURN_S * 1e6))
    columns = [
        np.diff(np.interp(edges, time, each)) for each in (heading_at_wheel(log), middle, apart)
    ]
    rows = np.column_stack(columns)
    if np.abs(rows[:, 0]).sum() < ENOUGH_TURN:
        return Parameter(name, remark="too few bends", manoeuvre=CIRCLES)
    value, sigma = _fit_track(rows)
    if not 0 < sigma < LARGEST_SIGMA * value:
        return Parameter(
            name, "m", (value,), (sigma,), remark="too uncertain to be used", manoeuvre=CIRCLES
        )
    if drive in ("differential", "ackermann"):
        return Parameter(name, "m", (value,), (sigma,), (f"wheel.track={value:.4f}",))
    remark = "the effective one: wheel.track takes that by tape, of which it is 1.6 to 2 times"
    if drive == "single":
        remark = (
            "not used as long as wheel.drive is single: say --set wheel.drive=differential, "
            "skid_steer or ackermann"
        )
    return Parameter(name, "m", (value,), (sigma,), remark=remark)


def _fit_track(rows: Floats) -> tuple[float, float]:
    """Track and its standard deviation by jackknife, m. rows (n, 3): turn, way, right less left;
    the difference of the radii is fitted beside it."""

    def solve(part: Floats) -> float:
        return float(np.linalg.lstsq(part[:, :2], part[:, 2], rcond=None)[0][0])

    number = np.arange(len(rows)) * BLOCKS // len(rows)
    left_out = [solve(rows[number != i]) for i in range(BLOCKS)]
    return solve(rows), float(np.std(left_out) * math.sqrt(BLOCKS - 1))
