"""Simulated grounds by seed, for training, validation and test (`split.json`), and passes on them.

Each ground of rays has its own wave speed, wavelet, layers, scatterers and losses, so that no
length of it can be known beforehand. Beside them stand the kept FDTD lines, for training alone:
each some times, stretched.
"""

import json
import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from gprodom.arrays import Floats, Ints
from gprodom.ground.survey import find_survey, shipped
from gprodom.random_streams import Random, stream
from gprodom.simulate import radar
from gprodom.simulate.ground import Ground, GroundSpec
from gprodom.simulate.radar import RadarSpec

LENGTH = 12.0  # m, of a ground
_SPACING = 0.004  # m, of its traces; linear between them
_FAR = 0.12  # m; the other line lies up to so far beside
_STRETCH = (0.95, 1.3)  # of an FDTD line's lengths and times
_LOUDNESS = (0.3, 1.0)  # of its amplitude
KEPT = shipped()  # FDTD lines that come with the package


def seeds(part: str, share: float = 1.0) -> list[int]:
    """Seeds of the grounds of `train`, `validate` or `test`, or of the copies of each FDTD line
    (`copies`); `share` of them, one at least."""
    split = json.loads(Path(__file__).with_name("split.json").read_text(encoding="utf-8"))
    count = max(1, math.ceil(share * split[part]["count"]))
    return list(range(split[part]["first"], split[part]["first"] + count))


def draw_ground(random: Random) -> GroundSpec:
    """Ground of any kind."""
    depths = np.sort(random.uniform(0.2, 1.6, int(random.randint(0, 4))))
    return GroundSpec(
        frequency=random.uniform(3.5e8, 6e8),
        wave_speed=random.uniform(0.7e8, 1.3e8),
        surface_time=random.uniform(3e-9, 5e-9),
        scatterers=_log_uniform(random, 1.0, 25.0),
        layers=tuple(depths.tolist()),
        waviness=_log_uniform(random, 0.2, 2.0),
        attenuation=random.uniform(0.5, 2.5),
        amplitude=_log_uniform(random, 3e3, 1.6e4),
        direct=random.uniform(1e4, 1.6e4),
    )


def draw_radar(random: Random) -> RadarSpec:
    """Errors of a radar, from hardly any to bad ones."""
    return RadarSpec(
        noise=_log_uniform(random, 4.0, 60.0),
        gain_drift=random.uniform(0.0, 0.05),
        time_zero_drift=random.uniform(0.0, 8e-11),
        ringing=random.uniform(0.0, 2000.0),
        spikes=random.uniform(0.0, 0.004),
    )


def draw_any_radar(random: Random) -> RadarSpec:
    """The same, and worse ones, whose traces differ where the antenna rests: a network that has not
    seen that takes it for slowness."""
    return replace(
        draw_radar(random),
        noise=_log_uniform(random, 4.0, 400.0),
        gain_jitter=_log_uniform(random, 3e-4, 0.05),
        time_zero_jitter=_log_uniform(random, 1e-12, 3e-11),
    )


def _log_uniform(random: Random, low: float, high: float) -> float:
    return math.exp(random.uniform(math.log(low), math.log(high)))


def draw_speed(random: Random) -> float:
    """m/s, drawn without regard to the rate of the traces."""
    return _log_uniform(random, 0.08, 1.2)


def draw_rate(random: Random) -> float:
    """Traces per second, drawn without regard to the speed."""
    return _log_uniform(random, 5.0, 40.0)


@dataclass(frozen=True)
class Line:
    """Noise-free traces along a line, every `_SPACING`, and along another one `beside` it (m)."""

    traces: Floats  # (2, n, samples), counts
    sample_interval: float  # s
    beside: float

    @property
    def length(self) -> float:
        """m, of the ground."""
        return float(self.traces.shape[1] * _SPACING)

    def at(self, along: Floats, line: int = 0) -> Floats:
        """(n, samples), counts, at the places `along` (n,), m."""
        place = np.clip(along / _SPACING, 0, self.traces.shape[1] - 1.001)
        index = place.astype(np.int64)
        part = (place - index)[:, None].astype(np.float32)
        on = self.traces[line]
        return np.asarray((1 - part) * on[index] + part * on[index + 1])


def make_line(seed: int, kept: str = "") -> Line:
    """The ground of that seed; with `kept`, a copy of that FDTD line."""
    if kept:
        return _stretched(kept, stream(seed, f"learned ground {kept}"))
    random = stream(seed, "learned ground")
    spec = draw_ground(random)
    beside = random.uniform(0.0, _FAR)
    x = np.arange(0.0, LENGTH, _SPACING)
    ground = Ground(spec, x, np.array([0.0, beside]), random)
    lines = [ground.traces(x, np.full_like(x, y)) for y in (0.0, beside)]
    return Line(np.array(lines, np.float32), spec.sample_interval, beside)


def _stretched(kept: str, random: Random) -> Line:
    """An FDTD line with all lengths and times multiplied by one number, which is again a solution
    of Maxwell's equations with less or more loss; begun anywhere, of either sign, louder or not."""
    survey = find_survey(kept)
    stretch = _log_uniform(random, *_STRETCH)
    x = np.arange(0.0, min(LENGTH, stretch * survey.length), _SPACING) / stretch
    x += random.uniform(0, survey.length)
    loudness = random.choice([-1.0, 1.0]) * _log_uniform(random, *_LOUDNESS)
    lines = [loudness * survey.traces(x, np.full_like(x, y)) for y in survey.aside[:2]]
    beside = stretch * float(survey.aside[1] - survey.aside[0])
    return Line(np.array(lines, np.float32), stretch * survey.sample_interval, beside)


def receive(
    line: Line,
    along: Floats,
    rate: float,
    random: Random,
    on: int = 0,
    draw: Callable[[Random], RadarSpec] = draw_radar,
) -> Ints:
    """Traces as a radar gives them, counts, of a pass over the places `along` (m)."""
    spec = replace(draw(random), rate=rate)
    time = np.arange(len(along)) / rate
    return radar.measure(line.at(along, on), time, line.sample_interval, spec, random)
