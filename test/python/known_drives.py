"""Drives over known ground, as the estimator hears them: on another day, by another wheel."""

from typing import Any

import numpy as np

from gprodom.simulate.recording import as_recording
from gprodom.simulate.sequence import Simulated


def later(told: dict[str, Any], shift: int) -> dict[str, Any]:
    """The messages, `shift` ns later than they were."""
    return told | {name: told[name] + shift for name in ("imu_time", "wheel_time", "gpr_time")}


def drive(
    estimator: Any, run: Simulated, shift: int = 0, wheel: float = 1.0, noise: float = 0.0
) -> Any:
    """A whole drive, `shift` ns later than it was, by another wheel and with other noise."""
    told = later(as_recording(run).messages(), shift)
    told["wheel_distance"] = wheel * told["wheel_distance"]
    random = np.random.RandomState(1)
    told["traces"] = told["traces"] + noise * random.standard_normal(told["traces"].shape)
    return estimator.run(**told)
