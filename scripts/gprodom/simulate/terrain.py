"""Ground that tilts the robot as it drives over it: roll and pitch over the distance travelled."""

from dataclasses import dataclass

import numpy as np

from gprodom.arrays import Floats

# rad/m, by the lengths (m) of the ground's waves; shorter ones the wheelbase evens out.
_WAVES = 2 * np.pi / np.array([0.9, 1.7, 3.1, 5.9])


@dataclass(frozen=True)
class Terrain:
    """Waves of equal share and random phase, which give `rms` (rad) of roll and of pitch."""

    rms: float
    phases: Floats  # (2, waves)

    def tilt(self, travelled: Floats) -> Floats:
        """Roll and pitch (n, 2), rad."""
        return np.asarray(self._share * np.sin(self._angles(travelled)).sum(axis=2))

    def rate(self, travelled: Floats) -> Floats:
        """Derivative of `tilt` (n, 2), rad/m."""
        return np.asarray(self._share * (_WAVES * np.cos(self._angles(travelled))).sum(axis=2))

    @property
    def _share(self) -> float:
        return float(self.rms * np.sqrt(2 / len(_WAVES)))

    def _angles(self, travelled: Floats) -> Floats:
        return np.asarray(travelled[:, None, None] * _WAVES + self.phases)


def draw_terrain(rms: float, random: np.random.RandomState) -> Terrain:
    """Ground of that tilt."""
    return Terrain(rms, random.uniform(0, 2 * np.pi, (2, len(_WAVES))))
