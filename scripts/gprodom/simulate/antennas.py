"""Several antennas on one robot: where each is, and what it makes of the ground's echoes."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from gprodom.arrays import Floats, Ints
from gprodom.random_streams import Random
from gprodom.simulate import radar
from gprodom.simulate.radar import RadarSpec

LATE = 0.004  # s, from the traces of one antenna to those of the next: they are sampled in turn

_TAPE_SIGMA = (0.001, 0.005)  # m, along and across: centres are hidden in their cases
_UNEVEN = 0.15  # m, of the ground under an antenna: some half of its length
_LIGHT = 2.998e8  # m/s
_DEPTH = 0.5  # m; echoes from about here fade as one over their way


@dataclass(frozen=True)
class AntennaSpec:
    """One of several antennas. All faults but those of `radar` are off by default.

    radar: its errors as of any radar; `radar.lever_arm` is where it truly is. told: where it is by
    tape, m, in body.
    """

    radar: RadarSpec
    told: tuple[float, float]
    late: float = 0.0  # s after the tick of all antennas
    gain: float = 1.0
    time_zero: float = 0.0  # s
    time_zero_rate: float = 0.0  # s/s
    phase: float = 0.0  # rad; turns the pulse
    bounce: float = 0.0  # m, RMS; height above the mean one, over the distance driven


def draw_antennas(
    told: Sequence[tuple[float, float]], spec: RadarSpec, random: Random
) -> tuple[AntennaSpec, ...]:
    """Antennas at the places `told` (m, in body), each with faults of its own, those of `spec`
    among them. The first is where it is told to be: only distances between them matter."""
    antennas = []
    for i, place in enumerate(told):
        off = np.array(_TAPE_SIGMA) * random.standard_normal(2) * (i > 0)
        true = float(round(place[0] + off[0], 4)), float(round(place[1] + off[1], 4))
        antennas.append(
            AntennaSpec(
                replace(
                    spec,
                    lever_arm=true,
                    noise=spec.noise * math.exp(random.uniform(-0.5, 0.5)),
                    ringing=spec.ringing * random.uniform(0.5, 1.5),
                ),
                place,
                late=i * LATE,
                gain=math.exp(random.uniform(-0.5, 0.0)),  # more would exceed full scale
                time_zero=random.uniform(0.0, 1e-9),
                phase=random.uniform(-0.35, 0.35),
                bounce=random.uniform(0.0, 0.004),
            )
        )
    return tuple(antennas)


def receive(
    clean: Floats,
    time: Floats,
    travelled: Floats,
    sample_interval: float,
    spec: AntennaSpec,
    random: Random,
) -> Ints:
    """Traces (n, samples), counts, of noise-free ones `clean` at the times `time` (n,), s, when the
    robot had driven `travelled` (n,), m."""
    height = _height(spec.bounce, travelled, random)
    late = spec.time_zero + spec.time_zero_rate * time + 2 * height / _LIGHT
    gain = spec.gain * _DEPTH / (_DEPTH + height)
    traces = gain[:, None] * radar.delayed(clean, late, sample_interval, spec.phase)
    return radar.measure(traces, time, sample_interval, spec.radar, random)


def _height(rms: float, travelled: Floats, random: Random) -> Floats:
    """Above the mean (n,), m: drawn anew every `_UNEVEN` driven, smooth in between, and without a
    period: one that both antennas shared would look like ground that moves with the robot."""
    from scipy.interpolate import CubicSpline

    knots = np.arange(0.0, float(np.max(travelled, initial=0.0)) + 3 * _UNEVEN, _UNEVEN)
    return np.asarray(CubicSpline(knots, rms * random.standard_normal(len(knots)))(travelled))
