"""Ground that tilts the robot as it drives over it: roll and pitch over the distance travelled."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gprodom.arrays import Floats

_LENGTHS = (0.9, 1.7, 3.1, 5.9)  # m, of the ground's waves; shorter ones the wheelbase evens out


@dataclass(frozen=True)
class Terrain:
    """Waves of equal share and random phase, which give `rms` (rad) of roll and of pitch."""

    rms: float
    phases: Floats  # (2, waves)

    def tilt(self, travelled: Floats) -> Floats:
        """Roll and pitch (n, 2), rad."""
        share = self.rms * np.sqrt(2 / len(_LENGTHS))
        waves = 2 * np.pi / np.array(_LENGTHS)
        return np.asarray(
            share * np.sin(travelled[:, None, None] * waves + self.phases).sum(axis=2)
        )

    def rate(self, travelled: Floats) -> Floats:
        """Derivative of `tilt` (n, 2), rad/m."""
        share = self.rms * np.sqrt(2 / len(_LENGTHS))
        waves = 2 * np.pi / np.array(_LENGTHS)
        angles = travelled[:, None, None] * waves + self.phases
        return np.asarray(share * (waves * np.cos(angles)).sum(axis=2))


def draw_terrain(rms: float, random: np.random.RandomState) -> Terrain:
    """Ground of that tilt."""
    return Terrain(rms, random.uniform(0, 2 * np.pi, (2, len(_LENGTHS))))
