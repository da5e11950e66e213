"""Left and right wheels: two sides of one body, each with its slip; values held and late."""

from dataclasses import dataclass

import numpy as np

from gprodom.arrays import Floats, Ints
from gprodom.random_streams import Random
from gprodom.simulate.drive import Drive
from gprodom.simulate.lasting import draw_slip
from gprodom.simulate.surface import PIECE_S, SURFACES, draw_grip, draw_widening

_FINE = 200.0  # Hz, at which the sides are integrated


@dataclass(frozen=True)
class PairSpec:
    """Two sides `track` (m, by tape) apart. `skids`: they turn the body by skidding.

    The scale, reported over true distance, is drawn from `scale_sigma` around 1, the difference of
    the radii (right over left, less one) from `radii_sigma`.
    """

    track: float
    rate: float = 50.0  # Hz
    skids: bool = False
    surface: str = "floor"
    scale_sigma: float = 0.02
    radii_sigma: float = 0.005
    track_sigma: float = 0.01  # relative, of the contact that the tape does not know
    noise: float = 0.005  # m/sqrt(m), of either side
    quantum: float = 1.82e-4  # m
    held: float = 0.0  # s for which a value is repeated; 0: each is new
    late: float = 0.0  # s between a value's time and its stamp
    lasting: str = ""  # slip of both sides that lasts: of `lasting.KINDS`
    side_slips: int = 0  # times that one side spins for a moment


@dataclass(frozen=True)
class PairData:
    """Encoder counts of each side (n,), and the true figures of the drive."""

    left: Ints
    right: Ints
    scale: float
    track: float  # m, effective: the mean over the drive
    radii: float  # right over left, less one


def measure(t: Floats, drive: Drive, spec: PairSpec, random: Random) -> PairData:
    """Counts as reported at the times `t` (s)."""
    surface = SURFACES[spec.surface]
    fine = np.arange(0, drive.duration, 1 / _FINE)
    motion = drive.at(fine)
    knots = np.arange(int(np.ceil(drive.duration / PIECE_S)) + 2) * PIECE_S
    grip = np.interp(fine, knots, draw_grip(surface, drive.duration, random))
    if spec.lasting:
        grip = grip / (1 + draw_slip(spec.lasting, fine, motion, random))
    track = spec.track * (1 + spec.track_sigma * random.standard_normal())
    width = np.full(len(fine), track)
    if spec.skids:
        width = track * np.interp(fine, knots, draw_widening(surface, drive.duration, random))
    scale = 1 + spec.scale_sigma * random.standard_normal()
    radii = spec.radii_sigma * random.standard_normal()
    spin = _spins(spec.side_slips, fine, motion.v, random)
    counts = []
    for side in (-1, 1):
        ground = motion.v + side * 0.5 * width * motion.yaw_rate
        speed = scale * (1 + side * 0.5 * radii) * (ground / grip + spin[side])
        steps = 0.5 * (speed[1:] + speed[:-1]) / _FINE
        steps = steps + random.standard_normal(len(steps)) * spec.noise * np.sqrt(np.abs(steps))
        distance = np.concatenate([[0.0], np.cumsum(steps)])
        counts.append(np.rint(_told(t, fine, distance, spec) / spec.quantum).astype(np.int64))
    return PairData(counts[0], counts[1], scale, float(width.mean()), radii)


def _told(t: Floats, fine: Floats, distance: Floats, spec: PairSpec) -> Floats:
    """The distance (m) that is reported at `t`, of `distance` at `fine`.

    A held value is the mean speed of the last whole interval. Its integral consists of straight
    lines, and lags by an interval.
    """
    if spec.held > 0:
        knots = np.arange(0, fine[-1], spec.held)
        fine, distance = knots, np.interp(knots, fine, distance)
    return np.interp(t - spec.late - spec.held, fine, distance)


def _spins(count: int, t: Floats, speed: Floats, random: Random) -> dict[int, Floats]:
    """By side (-1 left, 1 right) its spin in addition to rolling (n,), m/s: up and down again."""
    spins = {-1: np.zeros(len(t)), 1: np.zeros(len(t))}
    moving = t[np.abs(speed) > 0.1]
    for _ in range(count if len(moving) else 0):
        start, length = moving[random.randint(len(moving))], random.uniform(1.0, 4.0)
        size = random.uniform(0.3, 1.0) * float(np.abs(speed).max())
        side = 1 if random.uniform() < 0.5 else -1
        shape = np.clip(np.minimum(t - start, start + length - t) / 0.3, 0.0, 1.0)
        spins[side] += size * shape
    return spins
