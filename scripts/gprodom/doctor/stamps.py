"""Rates, gaps, order and clocks."""

from collections.abc import Iterator

import numpy as np

from gprodom.calibrate.offset import REACH_S, Offset
from gprodom.calibrate.radar_timing import find_radar_offset
from gprodom.calibrate.timing import find_offset
from gprodom.doctor.finding import NAMES, SIGMAS, Finding, Log
from gprodom.errors import Error

# s without a message that do harm. IMU: with 1 m/s^2 that nobody has measured a robot is 3 cm off
# its course after that time, which is more than the radar forgives. Wheel and radar: a state of the
# estimator in which they are missing; health counts silence from here.
GAP_S = {"imu": 0.25, "wheel": 1.0, "wheels": 1.0, "gpr_trace": 1.0}
GAP_RATIO = 10.0  # times the median interval; a slow sensor has no gap
# Hz: the mean rate at which the estimator works as it should. IMU: vibration and turns are faster
# than half of it. Wheel: a state each 0.2 s. Radar: two traces a tick.
SLOWEST_HZ = {"imu": 20.0, "wheel": 5.0, "wheels": 5.0}
TWICE = 0.01  # share of messages with the stamp of the one before
LATE_S = 0.05  # between two sensors: a hand's breadth at 2 m/s


def check_stamps(log: Log, by_distance: bool) -> Iterator[Finding]:
    """by_distance: the radar's traces are; then pauses are none."""
    for role, content in log.items():
        utime = content["utime"]
        if len(utime) < 10:
            yield Finding(
                f"{role} missing",
                f"{NAMES[role]}: {len(utime)} messages",
                f"look whether the sensor is on, and for channels.{role} (-c, --set)",
            )
            continue
        steps = np.diff(utime) * 1e-6
        median = float(np.median(steps))
        back = steps < 0
        if back.any():
            yield Finding(
                "order",
                f"{NAMES[role]}: {int(back.sum())} stamps are before the one before them, by up to "
                f"{-float(steps.min()):.3g} s",
                "stamp in the driver, at the measurement; what comes late by more than "
                "time.reorder_window is dropped",
            )
        twice = float(np.mean(steps == 0))
        if twice > TWICE:
            yield Finding(
                "twice",
                f"{NAMES[role]}: {100 * twice:.0f} % of the messages have the stamp of the one "
                "before",
                "send each message once, with a stamp in microseconds",
            )
        longest = int(np.argmax(steps))
        pause = role == "gpr_trace" and by_distance
        if steps[longest] > max(GAP_S[role], GAP_RATIO * median) and not pause:
            yield Finding(
                "gap",
                f"{NAMES[role]}: no messages for {steps[longest]:.2f} s, from "
                f"{(utime[longest] - utime[0]) * 1e-6:.1f} s on",
                "look at the sensor's cable and the driver; live, at `gprodom status` for messages "
                "that were lost; or cut the recording there",
            )
        rate = 1 / median if median > 0 else 0.0
        if 0 < rate < SLOWEST_HZ.get(role, 0.0):
            yield Finding(
                "rate",
                f"{NAMES[role]}: {rate:.3g} messages a second, expected {SLOWEST_HZ[role]:g} or "
                "more",
                "set the sensor's rate; if the stamps are in another unit, convert them "
                "(`gprodom convert tables --time-unit`)",
            )


def check_offsets(log: Log) -> Iterator[Finding]:
    """Of IMU and radar against the wheel."""
    for role, find in (("imu", find_offset), ("gpr_trace", find_radar_offset)):
        if role not in log:
            continue
        try:
            offset: Offset = find(log)
        except Error:  # the drive does not show it
            continue
        if abs(offset.offset_s) > REACH_S - LATE_S:  # the search ended there: no clear best one
            continue
        if abs(offset.offset_s) > LATE_S + SIGMAS * offset.sigma_s:
            key = "imu.time_offset" if role == "imu" else "gpr.time_offset"
            yield Finding(
                "clock",
                f"{NAMES[role]}: its stamps are off those of the wheel by "
                f"{-offset.offset_s:.3f} +- {offset.sigma_s:.3f} s",
                f"`gprodom calibrate time LOG`, or {key}={offset.offset_s:.3f}",
            )
