"""The radar: band, gain, trace rate against speed, and the antenna's lever arm."""

import math
from typing import Any

import numpy as np

from gprodom.arrays import Floats, Ints
from gprodom.calibrate.offset import BLOCKS
from gprodom.calibrate.radar_timing import trace_changes
from gprodom.commission.parameter import CIRCLES, STRAIGHT, Parameter, listed
from gprodom.convert.survey_files import mean_frequency
from gprodom.doctor.finding import Log
from gprodom.doctor.radar import OUTSIDE, by_distance
from gprodom.drive.radargram import of_one_antenna
from gprodom.errors import Error
from gprodom.odometry.dead_reckoning import gyro_yaw_of, standstill, wheel_and_gyro, wheel_distance

LOOKED_AT = 2000  # traces, evenly chosen
ABOVE_NOISE = 2.0  # of an echo over the noise, both RMS; below, the envelope is the noise's
FAST = 90  # percentile of the speeds on the move
SLOW = 0.3  # of the usual speed: slower intervals show noise more than motion
# Relative, of the antenna's speed over the robot's, that bends must make at an arm of a metre: the
# ground changes the measured speed by some tenths from place to place.
ENOUGH_BEND = 0.1
GROUPS = 20  # of the jackknife
CELL_M = 1.0  # of ground that an antenna sees at once, to its sides and ahead
LARGEST_SIGMA_M = 0.15  # of an arm that is of use
CLEARLY = 3.0  # standard deviations off the configured arm
SMOOTH_S = 0.5  # in which a robot hardly changes its turn: the gyro of two traces shows vibration
FARTHEST_M = 3.0  # arms that are tried


def usable_traces(log: Log) -> Floats:
    """(n, samples), without empty ones and those cut off."""
    from gprodom.gpr import check_traces

    _, traces = of_one_antenna(log["gpr_trace"])
    traces = np.asarray(traces, np.float64)
    good = traces[check_traces(traces.astype(np.float32)) == 0]
    if len(good) < BLOCKS * 2:
        raise Error("hardly a trace can be used (`gprodom doctor`)")
    return np.asarray(good[:: max(1, len(good) // LOOKED_AT)])


def band(traces: Floats, sample_interval: float, configured: tuple[float, float]) -> Parameter:
    """Mean frequency of the echoes, and the band that belongs to it, Hz."""
    whole = mean_frequency(traces, sample_interval)
    parts = [mean_frequency(part, sample_interval) for part in np.array_split(traces, BLOCKS)]
    sigma = float(np.std(parts) / math.sqrt(BLOCKS))
    low, high = configured
    fits = low / OUTSIDE < whole < high * OUTSIDE
    settings = (
        ()
        if fits
        else (f"gpr.filter.band_low={whole / 2:.3g}", f"gpr.filter.band_high={whole * 2:.3g}")
    )
    remark = (
        "in the configured band"
        if fits
        else "outside of the configured band: half to twice of it is written; see that the "
        "sample_interval of the driver is right"
    )
    return Parameter("mean frequency of the echoes", "Hz", (whole,), (sigma,), settings, remark)


def gain(traces: Floats) -> Parameter:
    """How fast echoes grow weaker, per sample, down to the noise."""
    name = "decay of the echoes"

    def slope(part: Floats) -> tuple[float, int]:
        echoes = part - part.mean(axis=0)
        rms = np.sqrt(np.mean(echoes**2, axis=0))
        # Neighbouring traces show the same ground: their difference is noise, and some echo.
        noise = float(np.sqrt(np.mean(np.diff(part, axis=0) ** 2, axis=0) / 2).min())
        begin = int(np.argmax(rms))
        under = np.flatnonzero(rms[begin:] < ABOVE_NOISE * noise)
        end = begin + (int(under[0]) if len(under) else len(rms) - begin)
        if end - begin < 10:
            raise Error("the echoes end within ten samples of their strongest")
        return float(-np.polyfit(np.arange(begin, end), np.log(rms[begin:end]), 1)[0]), end

    try:
        whole, end = slope(traces)
        parts = [slope(part)[0] for part in np.array_split(traces, BLOCKS)]
    except Error as error:
        return Parameter(name, remark=str(error))
    sigma = float(np.std(parts) / math.sqrt(BLOCKS))
    remark = f"echoes reach sample {end} of {traces.shape[1]}"
    if whole > CLEARLY * sigma:
        remark += (
            f"; for the paper's methods gpr.filter.gain_rate={whole:.3f} and "
            f"gain_flat_after={end}, which the motion front end does not need"
        )
    return Parameter(name, "1/sample", (whole,), (sigma,), (), remark)


def trace_rate(log: Log, frequency: float, wave_speed: float) -> Parameter:
    """The fastest speed at which traces are a quarter of a wavelength apart."""
    utime = log["gpr_trace"]["utime"]
    time, distance = wheel_distance(log)
    steps = np.diff(utime) * 1e-6
    speed = np.abs(np.diff(np.interp(utime, time, distance))) / np.maximum(steps, 1e-6)
    rate = 1 / max(float(np.median(steps)), 1e-6)
    limit = rate * wave_speed / max(frequency, 1.0) / 4
    moving = speed[speed > 0.1 * speed.max()]
    driven = float(np.percentile(moving, FAST)) if len(moving) else 0.0
    remark = f"{rate:.3g} traces a second; driven at up to {driven:.2f} m/s"
    settings: tuple[str, ...] = ()
    if by_distance(log):
        remark += "; triggered by the wheel: no standstill and no slip is seen"
        settings = ("gpr.trigger=distance",)
    elif driven > limit:
        remark += ": too fast; drive slower, or set the radar to more traces a second"
    return Parameter("fastest speed for the trace rate", "m/s", (limit,), (), settings, remark)


def lever_arm(log: Log, configured: tuple[float, ...], fastest: float) -> Parameter:
    """How far the antenna is to the left, m, from the speed with which traces change in bends.

    At a turn rate w an antenna at (x, y) moves with (v - w y, w x): faster in bends to the one side
    than in those to the other, by y; x is that of `configured`. fastest: speed of `trace_rate`;
    traces that are further apart than at half of it change hardly more with the way.
    """
    name = "antenna to the left"
    if by_distance(log):
        return Parameter(name, remark="traces triggered by the wheel do not show it; use a tape")
    try:
        told, speed, turn, group = _speeds(log, fastest / 2)
    except Error as error:
        return Parameter(name, remark=str(error), manoeuvre=CIRCLES)
    if float(np.std(turn / speed)) < ENOUGH_BEND:
        remark = f"too few bends at less than {fastest / 2:.2f} m/s"
        return Parameter(name, remark=remark, manoeuvre=CIRCLES)
    x = configured[0]
    y = _solve(told, speed, turn, x)
    kept = [group != i for i in range(GROUPS)]
    left_out = [_solve(told[rows], speed[rows], turn[rows], x) for rows in kept]
    sigma = float(np.std(left_out) * math.sqrt(GROUPS - 1))
    if sigma > LARGEST_SIGMA_M:
        remark = "too uncertain to be used; use a tape"
        return Parameter(name, "m", (y,), (sigma,), (), remark, CIRCLES)
    if abs(y - configured[1]) < CLEARLY * sigma:
        remark = "not different from what is configured; a tape is better"
        return Parameter(name, "m", (y,), (sigma,), (), remark)
    setting = f"gpr.lever_arm={listed((x, y, configured[2]), 3)}"
    return Parameter(name, "m", (y,), (sigma,), (setting,), "check it with a tape, which is better")


def _speeds(log: Log, fastest: float) -> tuple[Floats, Floats, Floats, Ints]:
    """For intervals between traces on the move (n,) each: root of their change per second, speed by
    wheel (m/s) and rate of turn (rad/s) over `SMOOTH_S` about them, and the group of the ground."""
    start, end, change = trace_changes(log["gpr_trace"])
    time, distance = wheel_distance(log)
    imu_time, yaw = gyro_yaw_of(log, standstill(time, distance))
    middle = 0.5 * (start + end)
    ends = middle + 0.5 * SMOOTH_S * np.array([[-1.0], [1.0]])
    speed, turn = (
        np.diff(np.interp(ends, stamps * 1e-6, along), axis=0)[0] / SMOOTH_S
        for stamps, along in ((time, distance), (imu_time, yaw))
    )
    pace = np.abs(speed)
    usual = float(np.median(pace[pace > 0.1 * pace.max()])) if np.any(pace > 0) else 0.0
    usual = min(usual, fastest)
    on_the_move = (pace > SLOW * usual) & (pace < fastest) & (change > 0) & (usual > 0)
    if on_the_move.sum() < 20 * GROUPS:
        raise Error(f"too few traces at less than {fastest:.2f} m/s")
    told = np.sqrt(change) / (end - start)
    cell = _cells(log, middle[on_the_move])
    return told[on_the_move], speed[on_the_move], turn[on_the_move], cell % GROUPS


def _cells(log: Log, seconds: Floats) -> Ints:
    """Number of the square of ground (`CELL_M`) at each time, by wheel and gyro: what changes from
    trace to trace there is the same in each lap, and no news."""
    way = wheel_and_gyro(log)
    at = [np.interp(seconds, way.time * 1e-6, axis) for axis in way.position[:, :2].T]
    squares = np.floor(np.column_stack(at) / CELL_M).astype(np.int64)
    return np.asarray(np.unique(squares, axis=0, return_inverse=True)[1]).ravel()


def _solve(told: Floats, speed: Floats, turn: Floats, x: float) -> float:
    """y, m, by robust least squares of logarithms. The change grows with a power of the way, which
    is found with it."""
    from scipy.optimize import least_squares

    seen = np.log(told)

    def residuals(at: Any) -> Floats:
        moved = np.hypot(speed - at[0] * turn, x * turn)
        off = seen - at[1] * np.log(np.maximum(moved, 1e-6))
        return np.asarray(off - np.median(off))

    found = least_squares(
        residuals,
        np.array([0.0, 1.0]),
        bounds=([-FARTHEST_M, 0.1], [FARTHEST_M, 2.0]),
        loss="soft_l1",
        f_scale=0.5,
    )
    return float(found.x[0])


def no_radar() -> Parameter:
    """Of a recording without traces."""
    return Parameter("radar", remark="no traces in the recording", manoeuvre=STRAIGHT)
