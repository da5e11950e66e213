"""What a running gprodomd publishes on LCM: rates, delays, the newest of each message."""

import math
import struct
import time
from collections import deque
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from gprodom.lcm.constants import flag_bits, health
from gprodom.lcm.messages import by_fingerprint, message

SPAN_S = 5.0  # over which rates are counted
INPUTS = {"imu_t": "IMU", "wheel_t": "wheel", "wheels_t": "wheel", "gpr_trace_t": "radar"}
KEPT = ("odometry_t", "status_t", "correction_t")  # decoded; of the others only the head is read


@dataclass
class Channel:
    """One channel: its type, arrival times (s, monotonic) and the newest stamp (us)."""

    type: str
    arrivals: deque[float] = field(default_factory=deque)
    utime: int = 0

    def rate(self, now: float) -> float:
        """Messages per second over the last `SPAN_S`, or since the first."""
        while self.arrivals and self.arrivals[0] < now - SPAN_S:
            self.arrivals.popleft()
        if len(self.arrivals) < 2:
            return len(self.arrivals) / SPAN_S
        return (len(self.arrivals) - 1) / max(now - self.arrivals[0], 1e-3)


class Heard:
    """Everything so far; `take` is the callback of an LCM subscription to all channels."""

    def __init__(self) -> None:
        self.channels: dict[str, Channel] = {}
        self._newest: dict[str, Any] = {}

    def take(self, channel: str, data: bytes) -> None:
        """Counts a message of one of our types, on any channel."""
        name = by_fingerprint().get(bytes(data[:8]))
        if name is None or len(data) < 16:
            return
        entry = self.channels.setdefault(channel, Channel(name))
        entry.arrivals.append(time.monotonic())
        entry.utime = struct.unpack_from(">q", data, 8)[0]  # the first field of all our types
        if name in KEPT:
            decoded = message(name).decode(data)
            frame = f" {decoded.frame}" if name == "odometry_t" else ""
            self._newest[name + frame] = decoded

    @property
    def status(self) -> Any | None:
        """The newest status_t."""
        return self._newest.get("status_t")

    @property
    def odometry(self) -> Any | None:
        """The newest odometry_t in odom."""
        return self._newest.get("odometry_t odom")

    @property
    def correction(self) -> Any | None:
        """The newest correction_t; map and odom are the same where there is none."""
        return self._newest.get("correction_t")

    def rates(self) -> dict[str, float]:
        """Rates of the inputs (Hz) by sensor."""
        now = time.monotonic()
        rates = dict.fromkeys(INPUTS.values(), 0.0)
        for channel in self.channels.values():
            if channel.type in INPUTS:
                rates[INPUTS[channel.type]] += channel.rate(now)
        return rates


def flags(odometry: Any) -> list[str]:
    """The names of the flags that are set."""
    return [text for text, bit in flag_bits().items() if odometry.flags & bit]


def sigmas(odometry: Any) -> tuple[float, float]:
    """Standard deviations of the position in the plane (m) and of yaw (rad)."""
    variance = np.asarray(odometry.pose_covariance).reshape(6, 6)
    return math.sqrt(max(variance[0, 0] + variance[1, 1], 0.0)), math.sqrt(max(variance[5, 5], 0.0))


def figures(heard: Heard) -> dict[str, Any]:
    """What ``--once --json`` prints; rates in Hz, metres, radians, milliseconds."""
    status, odometry, correction = heard.status, heard.odometry, heard.correction
    result: dict[str, Any] = {
        "health": health(status.health) if status else None,
        "reasons": list(status.reasons) if status else [],
        "rates_hz": heard.rates(),
        "values": dict(zip(status.names, status.values, strict=True)) if status else {},
        "revisits": correction.revisits if correction else 0,
    }
    if odometry is not None:
        position, yaw = sigmas(odometry)
        result |= {
            "flags": flags(odometry),
            "position_m": list(odometry.position),
            "position_sigma_m": position,
            "yaw_sigma_rad": yaw,
            "wheel_scale": odometry.wheel_scale,
            "wheel_scale_sigma": odometry.wheel_scale_sigma,
            "distance_m": odometry.distance,
        }
    return result
