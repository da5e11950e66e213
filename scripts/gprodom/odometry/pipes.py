"""Apexes of hyperbolas against a map of pipes: where along the track the antenna is (Skartados et
al. 2019), told to the estimator as displacements between pipes.

Places: `s` is the way along the track by odometry, `x` the place along the mapped line; x = o + s
while the robot drives as the line counts, x = o - s against it.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, field

import numpy as np

from gprodom.arrays import Floats
from gprodom.ground.pipes import PipeMap
from gprodom.lcm.answers import Answer
from gprodom.lcm.constants import kind

COLUMN = 0.02  # m of an image, about a tenth of the wavelength in the ground
LENGTH = 3.0  # m of an image: both flanks, at 45 degrees, of an echo 1.25 m deep
REVERSES_M = 0.1  # a step back is no turn, but a correction of the odometry
EVERY = 0.5  # m from an image to the next; each looks for apexes in its middle EVERY
SPEEDS = (0.55e8, 1.75e8)  # m/s: waves in wet soil, and in dry sand
SIGMA_M = 0.03  # of an apex: full-wave ground shows 1 cm for thin pipes, 9 for one of 22 cm
DRIFT = 0.03  # of the way: odometry between two pipes, slip included
DEPTH_SHARE, DEPTH_M = 0.1, 0.03  # of a depth: of the wave speed; of the pipe's radius
SIGMAS = 3.0  # of a gate
MEMORY_M = 15.0  # way whose apexes may locate the track
DEEPEST = 1.5  # m; apexes of other things lie anywhere down to it
FALSE_PLACE = 0.01  # probability that a place is wrong


def _normal(difference: Floats, sigma: Floats) -> Floats:
    """Density of the normal distribution."""
    return np.asarray(np.exp(-0.5 * (difference / sigma) ** 2) / (math.sqrt(2 * math.pi) * sigma))


@dataclass(frozen=True)
class _Apex:
    utime: int
    s: float
    depth: float


@dataclass
class _Place:
    """Of the track on the map: x = offset + sign s, known to `sigma` (m) at `s`."""

    sign: int
    offset: float
    sigma: float
    s: float


@dataclass
class PipeTeller:
    """Hears traces and poses; answers with displacements from pipe to pipe (EXTERNAL), and from a
    pipe to where it was seen before (REVISIT).

    apexes: how many were found."""

    pipes: PipeMap
    longest_s: float = 20.0  # from pipe to pipe, within the estimator's window
    apexes: int = 0
    _traces: deque[tuple[int, Floats]] = field(default_factory=lambda: deque(maxlen=4000))
    _format: tuple[float, int] = (0.0, 0)  # s between samples, samples of a trace
    _track: list[tuple[int, float]] = field(default_factory=list)  # of the next image: time, s
    _pose: tuple[float, float] | None = None
    _s: float = 0.0
    _forwards: bool = True
    _next: float = LENGTH  # way from the track's begin to the next image
    _found: deque[_Apex] = field(default_factory=lambda: deque(maxlen=200))
    _place: _Place | None = None
    _last: tuple[int, _Apex] | None = None  # pipe
    _seen: dict[int, tuple[_Apex, bool]] = field(default_factory=dict)  # by pipe; forwards?

    def trace(self, utime: int, samples: Floats, sample_interval: float) -> list[Answer]:
        """Hears a trace."""
        if self._traces and (sample_interval, samples.size) != self._format:
            self._traces.clear()
        self._format = sample_interval, samples.size
        self._traces.append((utime, samples))
        return []

    def pose(self, utime: int, x: float, y: float, yaw: float) -> list[Answer]:
        """Hears a pose by odometry, m and rad."""
        if self._pose is not None:
            step = (x - self._pose[0]) * math.cos(yaw) + (y - self._pose[1]) * math.sin(yaw)
            turned = (step > 0) != self._forwards
            if abs(step) < (REVERSES_M if turned else 0.1 * COLUMN):
                return []
            if turned:
                self._forwards, self._track, self._next = step > 0, self._track[-1:], LENGTH
            self._s += step
        self._pose = x, y
        self._track.append((utime, self._s))
        if abs(self._s - self._track[0][1]) < self._next:
            return []
        begin = next(i for i, (_, s) in enumerate(self._track) if abs(self._s - s) <= LENGTH)
        self._track, self._next = self._track[max(begin - 1, 0) :], LENGTH + EVERY
        return [answer for apex in self._apexes() for answer in self._heard(utime, apex)]

    def _apexes(self) -> list[_Apex]:
        """In the middle of the last LENGTH, in the order of the way."""
        from gprodom._core import find_apexes

        times, ways = np.array(self._track, np.float64).T
        traces = [(t, samples) for t, samples in self._traces if times[0] <= t <= times[-1]]
        if len(traces) < LENGTH / (5 * COLUMN):
            return []
        way = np.abs(ways - ways[0])
        along = np.interp(np.array([t for t, _ in traces], np.float64), times, way)
        columns = np.arange(0, way[-1], COLUMN)
        after = np.clip(np.searchsorted(along, columns), 1, len(along) - 1)
        part = np.clip(
            (columns - along[after - 1]) / np.maximum(np.diff(along)[after - 1], 1e-9), 0, 1
        )
        rows = np.array([samples for _, samples in traces])
        mean = rows.mean(axis=0)
        interval = self._format[0]
        # Recordings seldom say when the wave leaves: it is taken from the direct wave's maximum.
        zero = float(np.argmax(np.abs(mean))) * interval
        image = (1 - part[:, None]) * rows[after - 1] + part[:, None] * rows[after]
        found = []
        for apex in find_apexes(
            image - mean,
            sample_interval=interval,
            time_zero=zero,
            least_widening=2 * COLUMN / SPEEDS[1],
            most_widening=2 * COLUMN / SPEEDS[0],
        ):
            place = apex.column * COLUMN
            if abs(place - (way[-1] - LENGTH / 2)) > EVERY / 2:
                continue
            s = float(np.interp(place, way, ways))
            depth = apex.time * self.pipes.wave_speed / 2
            found.append(_Apex(int(np.interp(place, way, times)), s, depth))
        return sorted(found, key=lambda apex: apex.utime)

    def _heard(self, utime: int, apex: _Apex) -> list[Answer]:
        self.apexes += 1
        self._found.append(apex)
        if self._place is None:
            self._locate()
            return []
        pipe = self._on_map(self._place, apex)
        if pipe is None:
            return []
        return self._tell(utime, pipe, apex)

    def _locate(self) -> None:
        """From the apexes of the last way, by Bayes: all places and both directions are as likely
        at first, and as likely together as that none of the apexes is of the map."""
        newest = self._found[-1].s
        seen: list[_Apex] = []  # each once, its latest sight
        for apex in reversed(self._found):
            near = abs(apex.s - newest) < MEMORY_M
            if near and all(abs(apex.s - other.s) > SIGMAS * DRIFT * LENGTH for other in seen):
                seen.append(apex)
        s, depth = np.array([[apex.s - newest, apex.depth] for apex in seen]).T
        sigma = np.hypot(SIGMA_M, DRIFT * s)[:, None]
        sigma_depth = np.hypot(DEPTH_SHARE * self.pipes.depth, DEPTH_M)
        in_depth = _normal(depth[:, None] - self.pipes.depth, sigma_depth) * DEEPEST
        margin = 0.0 if self.pipes.length else MEMORY_M
        first, last = self.pipes.x.min() - margin, self.pipes.x.max() + margin
        span = self.pipes.length or last - first
        places = np.arange(first, first + span, SIGMA_M)
        evidence = np.zeros((2, len(places)))
        for row, sign in enumerate((1, -1)):
            off = self.pipes.apart(
                places[:, None, None] + sign * s[:, None] - self.pipes.x[None, None, :]
            )
            ratio = (_normal(off, sigma) * in_depth).mean(axis=2) * span
            # Half of the apexes may be stones, bars, or pipes that the map does not know.
            evidence[row] = np.log(0.5 * ratio + 0.5).sum(axis=1)
        likely = np.exp(evidence - evidence.max())
        nothing = math.exp(-evidence.max()) * likely.size
        row, best = divmod(int(np.argmax(likely)), len(places))
        off = self.pipes.apart(places - places[best])
        at_best = np.abs(off) < SIGMAS * DRIFT * LENGTH
        if likely[row, at_best].sum() > (1 - FALSE_PLACE) * (likely.sum() + nothing):
            sign = (1, -1)[row]
            place = places[best] + np.average(off[at_best], weights=likely[row, at_best])
            self._place = _Place(sign, float(place) - sign * newest, DRIFT * LENGTH, newest)

    def _on_map(self, place: _Place, apex: _Apex) -> int | None:
        """The only pipe that it can be; the place moves by what it shows."""
        sigma = math.hypot(place.sigma, DRIFT * (apex.s - place.s))
        off = self.pipes.apart(self.pipes.x - place.offset - place.sign * apex.s)
        gate = SIGMAS * math.hypot(sigma, SIGMA_M)
        sigma_depth = np.hypot(DEPTH_SHARE * self.pipes.depth, DEPTH_M)
        like = np.abs(apex.depth - self.pipes.depth) < SIGMAS * sigma_depth
        near = np.flatnonzero((np.abs(off) < gate) & like)
        if len(near) != 1:
            return None
        pipe = int(near[0])
        gain = sigma**2 / (sigma**2 + SIGMA_M**2)
        place.offset += gain * float(off[pipe])
        place.sigma, place.s = math.sqrt(1 - gain) * sigma, apex.s
        return pipe

    def _tell(self, utime: int, pipe: int, apex: _Apex) -> list[Answer]:
        place = self._place
        assert place is not None
        sigma = math.sqrt(2) * SIGMA_M
        answers = []
        if self._last is not None and self._last[0] != pipe:
            before, then = self._last
            between = float(self.pipes.x[pipe] - self.pipes.x[before])
            if self.pipes.length:  # which way round, the odometry knows
                laps = (place.sign * (apex.s - then.s) - between) / self.pipes.length
                between += round(laps) * self.pipes.length
            if 0 < apex.utime - then.utime < self.longest_s * 1e6:
                answers.append(
                    Answer(
                        utime, then.utime, apex.utime, "salient", kind("EXTERNAL"),
                        place.sign * between, sigma,
                    )
                )  # fmt: skip
        if pipe in self._seen:
            then, forwards = self._seen[pipe]
            answers.append(
                Answer(
                    utime, then.utime, apex.utime, "salient", kind("REVISIT"), 0.0, sigma,
                    self._forwards != forwards,
                )
            )  # fmt: skip
        else:
            self._seen[pipe] = apex, self._forwards
        self._last = pipe, apex
        return answers
