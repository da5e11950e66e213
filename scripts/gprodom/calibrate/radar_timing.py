"""Time offset of the radar against the wheel, from the speed that the decay of similarity shows."""

import numpy as np

from gprodom.arrays import Floats
from gprodom.calibrate.offset import BLOCKS, REACH_S, Offset, refine, spread
from gprodom.errors import Error
from gprodom.lcm import logs
from gprodom.odometry.dead_reckoning import wheel_distance

LAG_S = 0.005  # between lags that are tried
FLOOR = 0.05  # of the usual speed: slower counts as standing
MAX_GAP = 3.0  # usual intervals between traces; a longer one is left out
QUIET = 10  # percentile of the changes between traces that is their noise


def find_radar_offset(log: logs.Log) -> Offset:
    """The offset to be added to the stamps of the traces so that they agree with the wheel's.

    Let q be the energy of the difference of two neighbouring traces over their own energy, without
    changes of gain and time zero, less the noise: sqrt(q) is proportional to the distance between
    them. Its logarithm is compared with that of the distance that the wheel rolled in the same
    interval, at each of many lags. The lag with the best fit of a line is the offset. The error is
    relative, so with the logarithm it is the same at all speeds, and starts and stops become
    sharp. All speeds below `FLOOR` of the usual speed count as standstill.
    """
    start, end, change = trace_changes(logs.need(log, "gpr_trace"))
    utime, distance = wheel_distance(log)
    time = utime * 1e-6
    path = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(distance)))])
    inside = (start > time[0] + REACH_S) & (end < time[-1] - REACH_S)
    start, end, change = start[inside], end[inside], change[inside]
    if len(start) < 2 or end[-1] - start[0] < 10.0:
        raise Error("radar and wheel overlap for less than 10 s")

    lags = np.arange(-REACH_S, REACH_S + LAG_S / 2, LAG_S)
    speeds = np.stack(
        [(np.interp(end + lag, time, path) - np.interp(start + lag, time, path)) for lag in lags]
    ) / (end - start)
    seen = np.sqrt(change) / (end - start)
    if not (np.any(seen > 0) and np.any(speeds > 0)):
        raise Error("neither radar nor wheel shows motion: give a drive with starts and stops")
    told = np.log(seen + FLOOR * _usual(seen))
    rolled = np.log(speeds + FLOOR * _usual(speeds))
    whole, explained = _best_lag(told, rolled, lags)
    if explained < 0.1:
        raise Error(
            f"the wheel's speed explains {100 * explained:.0f} % of how the traces change: give a "
            "drive with more starts and stops"
        )
    parts = [
        _best_lag(told[part], rolled[:, part], lags)[0]
        for part in np.array_split(np.arange(len(told)), BLOCKS)
        if np.std(told[part]) > 0.3 * np.std(told)
    ]
    return Offset(whole, max(spread(parts, whole), LAG_S / 5), explained)


def _usual(speed: Floats) -> float:
    """Median of the values that belong to motion."""
    return float(np.median(speed[speed > 0.1 * speed.max()]))


def trace_changes(traces: logs.Channel) -> tuple[Floats, Floats, Floats]:
    """Times (s) of neighbouring traces and the change q between them, less the noise: (n - 1,)
    each.
    """
    from gprodom.gpr import band_pass, check_traces

    samples = np.asarray(traces["samples"], np.float64)
    whole = check_traces(samples.astype(np.float32)) == 0
    if np.count_nonzero(whole) < 3:
        raise Error(
            "hardly a trace can be used: all others are empty, or cut off (`gprodom doctor`)"
        )
    time, samples = traces["utime"][whole] * 1e-6, samples[whole]
    filtered = band_pass(samples, float(np.median(traces["sample_interval"])))
    ground = filtered - np.median(filtered, axis=0)
    difference = filtered[1:] - filtered[:-1]
    mean = 0.5 * (filtered[1:] + filtered[:-1])
    for way in (mean, np.gradient(mean, axis=1)):  # gain, time zero
        share = np.sum(difference * way, axis=1) / np.maximum(np.sum(way * way, axis=1), 1e-9)
        difference = difference - way * share[:, None]
    energy = np.sum(ground[:-1] ** 2, axis=1) + np.sum(ground[1:] ** 2, axis=1)
    change = np.sum(difference**2, axis=1) / np.maximum(energy, 1e-9)
    apart = np.diff(time)
    near = apart < MAX_GAP * np.median(apart)
    change = np.maximum(change[near] - np.percentile(change[near], QUIET), 0.0)
    return time[:-1][near], time[1:][near], change


def _best_lag(told: Floats, rolled: Floats, lags: Floats) -> tuple[float, float]:
    """The lag (s) whose row of `rolled` (lags, n) explains most of `told` (n,), and the share."""
    target = told - told.mean()
    rows = rolled - rolled.mean(axis=1, keepdims=True)
    energy = np.maximum(np.sum(rows**2, axis=1) * float(target @ target), 1e-12)
    best, share = refine((rows @ target) ** 2 / energy)
    return float(lags[0] + best * LAG_S), share
