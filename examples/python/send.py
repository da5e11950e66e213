#!/usr/bin/env python3
"""Sends gprodomd what the drivers of a robot send: send.py [SECONDS [URL]]

IMU, wheel and radar of a made-up robot, for SECONDS (0: without end), to LCM at URL. It stands for
three seconds, which the estimator needs for its start, and then drives three metres to and fro. Put
your own drivers in place of the class Robot; what is sent, and how it is stamped, stays as it is.
"""

from __future__ import annotations

import sys
import time

import numpy as np

from gprodom.lcm import DEFAULT_URL, LCM
from gprodom.lcm.messages import message

imu_t, wheel_t, gpr_trace_t = message("imu_t"), message("wheel_t"), message("gpr_trace_t")

IMU_PERIOD_S = 0.01
EVERY = 5  # wheel and radar: one message every so many of the IMU
METRES_PER_TICK = 0.0002
SAMPLE_INTERVAL_S = 2e-10


class Robot:
    """A robot over made-up ground; times in seconds since it was switched on."""

    STANDS_S = 3.0
    FASTEST_MPS, THERE_AND_BACK_S = 0.5, 20.0
    GRAVITY = 9.81  # m/s^2

    def __init__(self) -> None:
        self.random = np.random.default_rng(1)
        # Stones: how far along the track, and how far from it (m), and how strongly they reflect.
        self.stones = self.random.uniform([-1.0, 0.2, -1.0], [4.5, 1.5, 1.0], (120, 3))

    def phase(self, t: float) -> float:
        """Of the drive to and fro (rad)."""
        return 2 * np.pi * max(0.0, t - self.STANDS_S) / self.THERE_AND_BACK_S

    def distance(self, t: float) -> float:
        """Along the track (m), forwards positive: what an encoder counts."""
        reach_m = self.FASTEST_MPS * self.THERE_AND_BACK_S / (2 * np.pi)
        return reach_m * float(1 - np.cos(self.phase(t)))

    def read_imu(self, t: float) -> tuple[np.ndarray, np.ndarray]:
        """Specific force (m/s^2) and angular velocity (rad/s) in the axes of the IMU. At rest on
        level ground the force points up, with the size of gravity."""
        change = self.FASTEST_MPS * 2 * np.pi / self.THERE_AND_BACK_S * np.cos(self.phase(t))
        forwards = change if t > self.STANDS_S else 0.0
        force = np.array([forwards, 0.0, self.GRAVITY]) + self.random.normal(0, 0.01, 3)
        return force, self.random.normal(0, 0.002, 3)

    def read_trace(self, t: float) -> np.ndarray:
        """One trace (samples,) in counts: the direct wave, and the echo of each stone."""
        along, away, strength = self.stones.T
        path_m = 2 * np.hypot(along - self.distance(t), away)
        arrival = np.append(path_m / 1e8, 4e-9)  # s; waves travel at 1e8 m/s in moist soil
        strength = np.append(2000 * strength / (1 + path_m), 8000.0)
        since = np.arange(201) * SAMPLE_INTERVAL_S - arrival[:, None]
        pulse = (np.pi * 4e8 * since) ** 2  # a Ricker wavelet of 400 MHz
        echoes = strength[:, None] * (1 - 2 * pulse) * np.exp(-pulse)
        counts = echoes.sum(0) + self.random.normal(0, 10, 201)
        return np.rint(counts).astype(np.int32)


def main(seconds: float = 0.0, url: str = DEFAULT_URL) -> None:
    """Sends, at the pace of the clock."""
    lcm, robot = LCM(url), Robot()
    begin = time.time()
    sent = 0
    while seconds == 0 or time.time() < begin + seconds:
        # The stamp is the time at which the values were taken, not the time of sending.
        now = time.time()
        utime, t = int(now * 1e6), now - begin

        imu = imu_t()
        imu.utime = utime
        imu.linear_acceleration, imu.angular_velocity = robot.read_imu(t)
        lcm.publish("IMU", imu.encode())

        if sent % EVERY == 0:
            wheel = wheel_t()
            wheel.utime = utime
            wheel.ticks = round(robot.distance(t) / METRES_PER_TICK)  # never set back to zero
            wheel.metres_per_tick = METRES_PER_TICK
            lcm.publish("WHEEL", wheel.encode())

            trace = gpr_trace_t()
            trace.utime = utime
            trace.seq = sent // EVERY
            trace.sample_interval = SAMPLE_INTERVAL_S
            trace.samples = robot.read_trace(t).tolist()
            trace.num_samples = len(trace.samples)
            lcm.publish("GPR_TRACE", trace.encode())
        sent += 1
        time.sleep(max(0.0, begin + sent * IMU_PERIOD_S - time.time()))


if __name__ == "__main__":
    main(*(convert(text) for convert, text in zip((float, str), sys.argv[1:], strict=False)))
