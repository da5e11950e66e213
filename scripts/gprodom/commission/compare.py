"""The drive by the configuration of before and by the one that was found."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from gprodom.config import Configs
from gprodom.doctor.finding import Log
from gprodom.errors import Error
from gprodom.odometry.dead_reckoning import wheel_and_gyro
from gprodom.odometry.estimate import estimate
from gprodom.odometry.methods import find_method
from gprodom.score.align import FIRST_M, fit
from gprodom.score.associate import associate
from gprodom.score.figures import compare
from gprodom.trajectory import Trajectory, without_repeats


@dataclass(frozen=True)
class Way:
    """A path, and its error against the reference, se2-aligned, m; None of both where there is
    none, and why."""

    name: str
    path: Trajectory | None
    error_m: float | None
    why: str = ""


@dataclass(frozen=True)
class Comparison:
    """reference: positions of the truth, else wheel and gyro alone with the scale that was found.
    of_truth: which of them. ways: dead reckoning as recorded, and the methods before and after."""

    reference: Trajectory
    of_truth: bool
    ways: tuple[Way, ...]


def methods_of(log: Log) -> tuple[str, ...]:
    """That are replayed."""
    return ("imu_wheel", "gprodom_full") if "gpr_trace" in log else ("imu_wheel",)


def compare_drives(
    log: Path,
    sensors: Log,
    corrected: Log,
    before: tuple[Configs, Sequence[str]],
    after: tuple[Configs, Sequence[str]],
    truth: Trajectory | None,
    folder: Path,
    on_step: Callable[[], None] = lambda: None,
) -> Comparison:
    """log: the file of the sensors' data, and these as read; corrected: with clocks and scale put
    right. before, after: configurations and overrides. folder: for the replays."""
    reckoned = without_repeats(wheel_and_gyro(corrected))
    reference = reckoned if truth is None else truth
    found: dict[str, tuple[Trajectory | None, str]] = {}
    for name in methods_of(sensors):
        for when, (configs, overrides) in (("before", before), ("after", after)):
            try:
                output = folder / f"{name}-{when}.lcmlog"
                published = estimate(log, find_method(name), configs, overrides, output).trajectory
                found[f"{name}, {when}"] = (published, "")
            except Error as error:
                found[f"{name}, {when}"] = (None, str(error))
            on_step()
    started = [int(path.time[0]) for path, _ in found.values() if path is not None]
    rest = reference.select(reference.time >= max(started, default=0))
    if truth is not None:
        found = {
            "wheel and gyro alone": (without_repeats(wheel_and_gyro(sensors)), ""),
            "the same, scale and clocks put right": (reckoned, ""),
            **found,
        }
    ways = tuple(_scored(name, path, why, rest) for name, (path, why) in found.items())
    return Comparison(reference, truth is not None, ways)


def _scored(name: str, path: Trajectory | None, why: str, reference: Trajectory) -> Way:
    if path is None:
        return Way(name, None, None, why)
    try:
        figures = compare(associate(path, reference), "se2", FIRST_M).figures
    except Error as unscored:
        return Way(name, path, None, str(unscored))
    return Way(name, path, figures.ate_rmse_m, why)


def aligned(way: Trajectory, reference: Trajectory) -> Trajectory:
    """`way` moved in the plane onto the reference, for a picture."""
    try:
        return fit(associate(way, reference), "se2", FIRST_M).apply(way)
    except Error:
        return way
