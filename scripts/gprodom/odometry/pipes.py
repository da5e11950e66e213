"""Apexes of hyperbolas against a map of pipes: where along the track the antenna is (Skartados et
al. 2019), told to the estimator as displacements between pipes.

Places: `s` is the way along the track by odometry, `x` the place along the mapped line; x = o + s
while the robot drives as the line counts, x = o - s against it.
"""

import math
from collections import deque
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from gprodom.arrays import Floats
from gprodom.ground.laid import LaidTraces, Piece, columns_at
from gprodom.ground.pipes import PipeMap, read_pipes
from gprodom.lcm.answers import Answer
from gprodom.lcm.constants import kind

COLUMN = 0.02  # m of an image, about a tenth of the wavelength in the ground
LENGTH = 3.0  # m of an image: both flanks, at 45 degrees, of an echo 1.25 m deep
TURN_M = 0.1  # a shorter step back is no turn, but a correction of the odometry
EVERY = 0.5  # m from an image to the next; each looks for apexes in its middle EVERY
SPEEDS = (0.55e8, 1.75e8)  # m/s: waves in wet soil, and in dry sand
# Of an apex's place. Straight rays from a pipe 0.5 m deep, through permittivity that varies by 15 %
# over grains of 10 by 6 cm, move the hyperbola that fits them by 2 cm (docs/sfm.md). What pipes of
# this map show (`PipeTeller.sigma`) counts where it is more.
APEX_M = 0.02
FEW = 5  # ways from pipe to pipe, whose median is known to half of itself
DRIFT = 0.03  # of the way: odometry between two pipes, slip included
DEPTH_SHARE, DEPTH_M = 0.1, 0.03  # of a depth: of the wave speed; of the pipe's radius
SIGMAS = 3.0  # of a gate
MEMORY_M = 15.0  # way whose apexes may locate the track
DEEPEST = 1.5  # m; apexes of other things lie anywhere down to it
FALSE_PLACE = 0.01  # probability that a place is wrong


def _normal(difference: Floats, sigma: Floats) -> Floats:
    """Density of the normal distribution."""
    return np.asarray(np.exp(-0.5 * (difference / sigma) ** 2) / (math.sqrt(2 * math.pi) * sigma))


@dataclass(frozen=True, order=True)
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
    pipe to where it was seen before (REVISIT)."""

    pipes: PipeMap
    longest_s: float = 20.0  # from pipe to pipe, within the estimator's window
    _laid: LaidTraces = field(default_factory=lambda: LaidTraces(LENGTH, EVERY, COLUMN, TURN_M))
    _interval: float = 0.0  # s between samples
    _forwards: bool = True
    _found: deque[_Apex] = field(default_factory=lambda: deque(maxlen=200))
    _place: _Place | None = None
    _last: tuple[int, _Apex] | None = None  # pipe
    _seen: dict[int, tuple[_Apex, bool]] = field(default_factory=dict)  # by pipe; forwards?
    _misfits: list[float] = field(default_factory=list)  # m, from pipe to pipe, odometry less map

    def trace(self, utime: int, samples: Floats, sample_interval: float) -> list[Answer]:
        """Hears a trace."""
        self._interval = sample_interval
        self._laid.trace(utime, samples)
        return []

    def pose(self, utime: int, x: float, y: float, yaw: float) -> list[Answer]:
        """Hears a pose by odometry, m and rad."""
        piece = self._laid.pose(utime, x, y, yaw)
        if piece is None:
            return []
        self._forwards = piece.forwards
        return [answer for apex in self._apexes(piece) for answer in self._heard(utime, apex)]

    @property
    def sigma(self) -> float:
        """Standard deviation of an apex's place, m: by the median way from pipe to pipe, of which
        the map tells another than the odometry. It is not below APEX_M; while few ways are known,
        it is what the odometry errs by in an image."""
        if len(self._misfits) < FEW:
            return DRIFT * LENGTH
        spread = 1.4826 * float(np.median(np.abs(self._misfits)))  # of a normal distribution
        return max(APEX_M, spread / math.sqrt(2))

    @property
    def _depth_sigma(self) -> Floats:
        return np.asarray(np.hypot(DEPTH_SHARE * self.pipes.depth, DEPTH_M))

    def _apexes(self, piece: Piece) -> list[_Apex]:
        """In the middle of the piece, in the order of the way."""
        from gprodom._core import find_apexes

        ways = np.arange(piece.way[-1] - LENGTH, piece.way[-1], COLUMN)
        mean = piece.traces.mean(axis=0)
        # Recordings seldom say when the wave leaves: it is taken from the direct wave's maximum.
        zero = float(np.argmax(np.abs(mean))) * self._interval
        found = []
        for apex in find_apexes(
            columns_at(ways, piece.traces, piece.along) - mean,
            sample_interval=self._interval,
            time_zero=zero,
            least_widening=2 * COLUMN / SPEEDS[1],
            most_widening=2 * COLUMN / SPEEDS[0],
        ):
            way = float(ways[0]) + apex.column * COLUMN
            if abs(way - (piece.way[-1] - LENGTH / 2)) <= EVERY / 2:
                depth = apex.time * self.pipes.wave_speed / 2
                found.append(_Apex(int(piece.at(way, piece.utime)), piece.at(way, piece.s), depth))
        return sorted(found)

    def _heard(self, utime: int, apex: _Apex) -> list[Answer]:
        self._found.append(apex)
        if self._place is None:
            self._locate()
            return []
        pipe = self._on_map(self._place, apex)
        return [] if pipe is None else self._tell(utime, self._place.sign, pipe, apex)

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
        sigma = np.hypot(APEX_M, DRIFT * s)[:, None]
        in_depth = _normal(depth[:, None] - self.pipes.depth, self._depth_sigma) * DEEPEST
        margin = 0.0 if self.pipes.length else MEMORY_M
        span = self.pipes.length or float(np.ptp(self.pipes.x)) + 2 * margin
        places = self.pipes.x.min() - margin + np.arange(0, span, APEX_M)
        signs = np.array([1, -1])[:, None, None, None]
        off = self.pipes.apart(places[:, None, None] + signs * s[:, None] - self.pipes.x)
        ratio = (_normal(off, sigma) * in_depth).mean(axis=3) * span
        # Half of the apexes may be stones, bars, or pipes that the map does not know.
        evidence = np.log(0.5 * ratio + 0.5).sum(axis=2)
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
        gate = SIGMAS * math.hypot(sigma, self.sigma)
        like = np.abs(apex.depth - self.pipes.depth) < SIGMAS * self._depth_sigma
        near = np.flatnonzero((np.abs(off) < gate) & like)
        if len(near) != 1:
            return None
        pipe = int(near[0])
        gain = sigma**2 / (sigma**2 + self.sigma**2)
        place.offset += gain * float(off[pipe])
        place.sigma, place.s = math.sqrt(1 - gain) * sigma, apex.s
        return pipe

    def _tell(self, utime: int, sign: int, pipe: int, apex: _Apex) -> list[Answer]:
        """sign: of the way along the line."""

        def answer(since: _Apex, what: str, distance: float, mirrored: bool = False) -> Answer:
            sigma = math.sqrt(2) * self.sigma
            times = utime, since.utime, apex.utime
            return Answer(*times, "salient", kind(what), distance, sigma, mirrored)

        answers = []
        if self._last is not None and self._last[0] != pipe:
            before, then = self._last
            between = float(self.pipes.x[pipe] - self.pipes.x[before])
            driven = sign * (apex.s - then.s)
            if self.pipes.length:  # which way round, the odometry knows
                between += round((driven - between) / self.pipes.length) * self.pipes.length
            self._misfits.append(driven - between)
            if 0 < apex.utime - then.utime < self.longest_s * 1e6:
                answers.append(answer(then, "EXTERNAL", sign * between))
        if pipe in self._seen:
            then, forwards = self._seen[pipe]
            answers.append(answer(then, "REVISIT", 0.0, self._forwards != forwards))
        else:
            self._seen[pipe] = apex, self._forwards
        self._last = pipe, apex
        return answers


def teller_of(pipes: Path) -> PipeTeller:
    """Of the file with the map."""
    return PipeTeller(read_pipes(pipes))
