"""Traces: what they show, and when they come."""

from collections.abc import Iterator, Mapping

import numpy as np

from gprodom.arrays import Floats
from gprodom.convert.survey_files import mean_frequency
from gprodom.doctor.finding import Finding, Log
from gprodom.lcm.logs import Channel
from gprodom.odometry.dead_reckoning import has_wheel, stays, wheel_distance

SOME = 0.01  # share of traces; fewer are what the estimator drops and counts
CLIPPED = 3  # equal samples at the end of the scale: noise leaves no two of them alike for long
MANY_CLIPPED = 0.05  # share of traces
# Hz outside of the band by this factor: an antenna's echoes have their mean frequency well in it.
OUTSIDE = 2.0
LOOKED_AT = 2000  # traces, evenly chosen
STANDS_S = 2.0
EXPECTED = 10  # traces in standstills, of which by chance none comes with a probability of e^-10
MOVED_M = 0.005  # by wheel, in a standstill
EVEN = 0.5  # of the spread in time: traces are then as even along the way


def check_traces(log: Log, band: tuple[float, float]) -> Iterator[Finding]:
    """band: Hz, of the configuration."""
    radar = log["gpr_trace"]
    every = max(1, len(radar["utime"]) // LOOKED_AT)
    wide = np.bincount([len(samples) for samples in radar["samples"]]).argmax()
    kept = [i for i, samples in enumerate(radar["samples"]) if len(samples) == wide]
    traces = np.array([radar["samples"][i] for i in kept], np.float64)
    spread = np.ptp(traces, axis=1)
    empty = float(np.mean(spread == 0))
    if empty > SOME:
        yield Finding(
            "empty",
            f"radar: {100 * empty:.0f} % of the traces are empty: all samples the same",
            "look at the antenna's cable and the control unit; the estimator drops such traces",
        )
    same = np.all(np.diff(traces, axis=0) == 0, axis=1) & (spread[1:] > 0)
    if float(np.mean(same)) > SOME:
        yield Finding(
            "frozen",
            f"radar: {100 * float(np.mean(same)):.0f} % of the traces repeat the one before to the "
            "last bit, noise included",
            "send each trace once: the driver repeats its last one",
        )
    clipped = _clipped(traces[spread > 0])
    if clipped > MANY_CLIPPED:
        yield Finding(
            "saturated",
            f"radar: {100 * clipped:.0f} % of the traces stay at the end of the scale for "
            f"{CLIPPED} samples or more",
            "turn down the gain of the control unit, or raise the antenna; what is cut off cannot "
            "be restored",
        )
    interval = float(np.median(radar["sample_interval"]))
    good = traces[spread > 0][::every]
    if len(good) > 1 and interval > 0 and not empty > 0.5:
        frequency = mean_frequency(good, interval)
        if not band[0] / OUTSIDE < frequency < band[1] * OUTSIDE and frequency > 0:
            yield Finding(
                "sample interval",
                f"radar: with its sample interval of {interval:.3g} s its echoes have "
                f"{frequency:.2g} Hz, and the antenna's band is {band[0]:.2g} to {band[1]:.2g} Hz",
                "sample_interval in the driver (`gprodom convert ... --sample-interval`), or, of "
                "another antenna, gpr.filter.band_low and band_high",
            )


def check_antennas(
    antennas: Mapping[int, Channel], places: Mapping[int, object]
) -> Iterator[Finding]:
    """For traces that the estimator refuses. antennas: by antenna_id, in the order in which they
    were heard; places: gpr.antennas."""
    counts = {antenna: len(traces["utime"]) for antenna, traces in antennas.items()}
    used = set(places) or set(list(counts)[:1])
    refused = {antenna: count for antenna, count in counts.items() if antenna not in used}
    if refused:
        words = ", ".join(f"{count} of antenna {antenna}" for antenna, count in refused.items())
        yield Finding(
            "antenna",
            f"radar: of {sum(counts.values())} traces the estimator refuses {words}: "
            + ("gpr.antennas has not their place" if places else "gpr.antennas is empty"),
            "gpr.antennas: {ID: [x, y, z], ...}, the place of each antenna on the robot",
        )
    silent = [str(antenna) for antenna in places if antenna not in counts]
    if counts and silent:
        yield Finding(
            "antenna missing",
            f"radar: no traces of antenna {', '.join(silent)}, which gpr.antennas has",
            "the antenna's cable and driver, and the antenna_id that it sends",
        )


def _clipped(traces: Floats) -> float:
    """Share of traces with a run of equal samples at one of the ends of the scale."""
    if not len(traces):
        return 0.0
    share = 0.0
    for end in (traces.max(), traces.min()):
        at = traces == end
        runs = at[:, : -(CLIPPED - 1)].copy()
        for i in range(1, CLIPPED):
            runs &= at[:, i : at.shape[1] - CLIPPED + 1 + i]
        share = max(share, float(np.mean(runs.any(axis=1))))
    return share


def by_distance(log: Log) -> bool:
    """Whether traces are triggered by the wheel: none at standstills, or evenly along the way where
    they are not in time."""
    if "gpr_trace" not in log or not has_wheel(log):
        return False
    utime = log["gpr_trace"]["utime"]
    time, distance = wheel_distance(log)
    steps = np.diff(utime) * 1e-6
    if len(steps) < 10 or len(time) < 10:
        return False
    rate = 1 / max(float(np.median(steps)), 1e-6)
    due = came = 0.0
    for begin, end in _standstills(time, distance):
        inside = (utime[0] < begin) & (end < utime[-1])
        if inside:
            due += (end - begin) * 1e-6 * rate
            came += int(np.searchsorted(utime, end) - np.searchsorted(utime, begin))
    if due > EXPECTED:
        return came < 0.1 * due
    ways = np.abs(np.diff(np.interp(utime, time, distance)))
    in_time = float(np.std(steps) / np.mean(steps))
    along = float(np.std(ways)) / max(float(np.mean(ways)), 1e-9)
    return in_time > 0.2 and along < EVEN * in_time


def _standstills(time: Floats, distance: Floats) -> Iterator[tuple[int, int]]:
    """Microseconds, without what the wheel needs to come to rest."""
    for first, last in stays(distance, MOVED_M):
        begin, end = int(time[first]) + 500_000, int(time[last]) - 500_000
        if end - begin > STANDS_S * 1e6:
            yield begin, end


def check_trigger(log: Log) -> Iterator[Finding]:
    """For who takes pauses for losses."""
    if by_distance(log):
        yield Finding(
            "trigger",
            "radar: its traces are triggered by the wheel: none while the robot stands",
            "gpr.trigger: distance; or better, set the control unit to trigger by time, ten traces "
            "a second or more: so the radar sees standstill and slip; by the wheel it gives "
            "revisits alone",
        )
