"""What benches do with a log: run a method on it, and hold what comes out against the truth."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from gprodom.calibrate.mount import Mount, find_mount
from gprodom.commission.parameter import listed
from gprodom.config import STANDARD
from gprodom.errors import Error
from gprodom.lcm import logs
from gprodom.odometry.estimate import Estimate, estimate
from gprodom.odometry.methods import find_method
from gprodom.score.align import FIRST_M
from gprodom.score.associate import associate
from gprodom.score.consistency import TruthError
from gprodom.score.figures import Figures, compare
from gprodom.trajectory import Trajectory

EXACT = TruthError()


def run_method(
    log: Path, method: str, output: Path, overrides: Sequence[str] = (), smooth: bool = False
) -> Estimate:
    """The trajectory, and with `smooth` the solution over all data."""
    found = estimate(log, find_method(method), (), overrides, output, smooth=smooth)
    if smooth and found.smoothed is None:
        raise Error(f"{log}: no smoothed solution")
    return found


def planar_figures(found: Trajectory, truth: Trajectory, error: TruthError = EXACT) -> Figures:
    """Aligned to the truth by se2."""
    return compare(associate(found, truth), "se2", FIRST_M, error).figures


def mount_in(log: Path) -> Mount:
    """The IMU's mounting as `gprodom calibrate mount` finds it."""
    return find_mount(logs.read_roles(log, STANDARD.of("imu", "wheel")))


def mounting_setting(mount: Mount) -> str:
    """Of the configuration."""
    return f"imu.rpy_body_imu={listed(mount.rpy)}"
