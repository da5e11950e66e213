"""The surface under the wheels: their slip on it, and the effective track of a skid steer.

The figures are of a Warthog (skid steer, 1.08 m between its sides), from recordings by the Norlab
of Université Laval (repository norlab-ulaval/DRIVE, BSD-3-Clause) in pieces of 2 s with lidar
positions. Those of constant command, with 1 m and more by the wheels, and turning by less than 0.6
of what turning on the spot is: 119 on asphalt, 114 on gravel, 92 on ice. On asphalt the wheels
hardly slip: its scatter comes from lidar and turning, and is subtracted from that of the others.
"""

from dataclasses import dataclass

import numpy as np

from gprodom.arrays import Floats
from gprodom.random_streams import Random

PIECE_S = 2.0  # of the recordings: slip is drawn anew as often, and changes evenly between

_SHARES = (0.1, 0.25, 0.5, 0.75, 0.9)  # of the pieces


@dataclass(frozen=True)
class Surface:
    """`grip`: distance on the ground over that of the wheels, which a share of `_SHARES` of the
    pieces stays below. `widening`: effective over geometric track, and by how much (relative, one
    sigma) it differs from piece to piece."""

    grip: tuple[float, float, float, float, float]
    widening: float
    widening_sigma: float
    roughness: float  # of vibration and tilt, against gravel


_NONE = (1.0, 1.0, 1.0, 1.0, 1.0)

SURFACES = {
    # Wheels over gyro yaw: 1.85 m on asphalt (10 to 90 %: 1.67 to 1.96), 7 % of scatter.
    "floor": Surface(_NONE, 1.71, 0.0, 0.3),
    # Another drive of that robot on grass: effective track 1.73 m, wheels as far as the lidar.
    "grass": Surface(_NONE, 1.60, 0.02, 1.0),
    # Median 0.978 of asphalt's 0.999; no scatter beyond asphalt's. Near-straight pieces: 0.943.
    "gravel": Surface((0.94, 0.95, 0.96, 0.97, 0.98), 1.69, 0.02, 1.0),
    # Effective track 2.10 m, from 1.22 to 3.62 m (10 to 90 %).
    "ice": Surface((0.34, 0.56, 0.83, 0.94, 0.99), 1.95, 0.33, 0.6),
}


def draw_grip(surface: Surface, duration: float, random: Random) -> Floats:
    """Distance on the ground over that of the wheels at the multiples of `PIECE_S` (n,)."""
    count = int(np.ceil(duration / PIECE_S)) + 2
    return np.interp(random.uniform(0.05, 0.95, count), _SHARES, surface.grip)


def draw_widening(surface: Surface, duration: float, random: Random) -> Floats:
    """Effective over geometric track at the multiples of `PIECE_S` (n,)."""
    count = int(np.ceil(duration / PIECE_S)) + 2
    scatter = surface.widening_sigma * np.clip(random.standard_normal(count), -2, 2)
    return np.asarray(surface.widening * np.exp(scatter))
