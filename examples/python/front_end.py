#!/usr/bin/env python3
"""A radar front end of your own: front_end.py LOG runs the estimator on a log with it.

The same three functions as in C++ (include/gprodom/front_end.h).
"""

from __future__ import annotations

import sys

import numpy as np

import gprodom
from gprodom.gpr import GprTrace, PathLength, Standstill
from gprodom.lcm import logs


def correlation(a: np.ndarray, b: np.ndarray) -> float:
    """1 for traces of the same shape."""
    return float(np.vdot(a, b) / max(np.linalg.norm(a) * np.linalg.norm(b), 1e-9))


class Similarity:
    """Compares traces 0.3 s apart: their similarity falls with the distance moved."""

    def __init__(self) -> None:
        self.reset()

    def add_trace(self, trace: GprTrace) -> None:
        """Every trace, in time order."""
        samples = trace.samples.astype(float)
        if self.mean is None:
            self.mean = samples
        ground = samples - self.mean  # without the direct wave, which all traces have
        self.mean = 0.98 * self.mean + 0.02 * samples
        self.traces.append((trace.time, samples, ground))
        del self.traces[:-200]

    def tick(self, time: int) -> list[Standstill | PathLength]:
        """Every gpr.tick of data time."""
        newest = self.traces[-1][0] if self.traces else 0
        before = [trace for trace in self.traces if newest - trace[0] >= 300_000_000]
        if not before:
            return []
        since, samples, ground = before[-1]
        if correlation(samples, self.traces[-1][1]) > 0.9995:
            return [Standstill(since, newest, sigma=0.005, source="similarity")]
        alike = correlation(ground, self.traces[-1][2])
        valid = 0.35 < alike < 0.95  # otherwise too similar, or too different
        lengths = np.sqrt(-2 * np.log(alike)) if valid else 0.0
        return [PathLength(since, newest, lengths, valid=valid, source="similarity")]

    def reset(self) -> None:
        """After a gap, or a change of the traces' length."""
        self.mean: np.ndarray | None = None
        self.traces: list[tuple[int, np.ndarray, np.ndarray]] = []


def main() -> None:
    """Runs the estimator and counts what the front end found."""
    log = logs.read(sys.argv[1])
    imu, wheel, radar = log["IMU"], log["WHEEL"], log["GPR_TRACE"]
    outputs = gprodom.Odometry(front_end=Similarity).run(
        imu_time=imu["utime"] * 1000,  # ns
        acceleration=imu["linear_acceleration"],
        angular_velocity=imu["angular_velocity"],
        wheel_time=wheel["utime"] * 1000,
        wheel_distance=wheel["ticks"] * wheel["metres_per_tick"],
        gpr_time=radar["utime"] * 1000,
        traces=radar["samples"],
        sample_interval=float(radar["sample_interval"][0]),
    )
    found = [d for d in outputs.displacements if d["source"] == "similarity" and d["valid"]]
    print(f"{len(outputs.odometry['time'])} poses, {len(found)} findings")


if __name__ == "__main__":
    main()
