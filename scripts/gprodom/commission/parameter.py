"""What one recording says of one constant of the robot, or why it says nothing."""

from collections.abc import Sequence
from dataclasses import dataclass

STAND = "stand still for 30 s with the motors on, level"
STRAIGHT = "drive 10 m straight along a tape, forwards, from a standstill to a standstill"
STARTS = "five times 2 m with hard starts and stops, forwards and back"
CIRCLES = "two circles to the left and two to the right, as tight as you usually turn, at 0.2 m/s"


@dataclass(frozen=True)
class Parameter:
    """A constant of the robot.

    value, sigma: in `unit`, as many as the constant has; empty where the recording does not show
      it. settings: KEY=VALUE of the configuration, empty where nothing is written.
    remark: what qualifies the value, or why there is none. manoeuvre: which would show it, or show
      it better; "" where nothing is missing.
    """

    name: str
    unit: str = ""
    value: tuple[float, ...] = ()
    sigma: tuple[float, ...] = ()
    settings: tuple[str, ...] = ()
    remark: str = ""
    manoeuvre: str = ""

    @property
    def text(self) -> str:
        """Value and standard deviation, for people."""
        if not self.value:
            return "not shown"
        values = ", ".join(f"{value:.4g}" for value in self.value)
        if not self.sigma:
            return f"{values} {self.unit}".strip()
        sigmas = ", ".join(f"{sigma:.2g}" for sigma in self.sigma)
        return f"{values} ± {sigmas} {self.unit}".strip()


def listed(values: Sequence[float], digits: int = 4) -> str:
    """As a list of YAML."""
    return "[" + ", ".join(f"{value:.{digits}f}" for value in values) + "]"
