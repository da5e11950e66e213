"""A recording made ready, and its runs with fixes and without."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from estimates import mount_in, mounting_setting, run_method
from gprodom.arrays import Bools
from gprodom.config import STANDARD
from gprodom.errors import Error
from gprodom.files import temporary_folder
from gprodom.fixes.made import add_to_log
from gprodom.fixes.record import Fixes
from gprodom.lcm import logs
from gprodom.score.align import fit_planar
from gprodom.score.associate import associate
from gprodom.score.sources import read_truth
from gprodom.trajectory import Trajectory
from recordings import RECORDINGS, convert


@dataclass(frozen=True)
class Drive:
    """settings: the IMU's mounting as `gprodom calibrate mount` finds it, and what a user gives."""

    name: str
    log: Path
    truth: Trajectory
    settings: tuple[str, ...]


@dataclass(frozen=True)
class Run:
    """The estimate, as published and as solved over all data; reasons of STATUS with their times
    (us). smoothed: of the antenna of the fixes, where that solution finds it; else of body."""

    causal: Trajectory
    smoothed: Trajectory
    smoothed_body: Trajectory
    reasons: list[tuple[int, str]]
    scale_sigma: float


def ready(name: str, data: Path, folder: Path) -> Drive:
    """A recording of RECORDINGS as a log in `folder`."""
    if name not in RECORDINGS:
        raise Error(f"--only {name}: expected some of {', '.join(RECORDINGS)}")
    missing = [file for file in RECORDINGS[name].files if not (data / file).is_file()]
    if missing:
        raise Error(f"{data / missing[0]}: no such file; {name} is not measured")
    log = folder / f"{name}.lcmlog"
    convert(RECORDINGS[name], data, log)
    settings = (mounting_setting(mount_in(log)), *RECORDINGS[name].settings)
    return Drive(name, log, read_truth(log).trajectory, settings)


def each_of(
    names: Sequence[str], data: Path, overrides: Sequence[str]
) -> Iterator[tuple[Drive, Run]]:
    """These recordings, each with its estimate without fixes."""
    for name in names:
        with temporary_folder() as folder:
            drive = ready(name, data, folder)
            yield drive, run(drive, None, overrides)


def run(drive: Drive, fixes: Fixes | None, overrides: Sequence[str]) -> Run:
    """The estimate of IMU and wheel with these fixes."""
    log = drive.log
    if fixes is not None:
        log = drive.log.with_suffix(".fixes.lcmlog")
        add_to_log(drive.log, log, [fixes.stream(STANDARD.position_fix)])
    output = log.with_suffix(".out.lcmlog")
    found = run_method(log, "imu_wheel", output, [*drive.settings, *overrides], smooth=True)
    assert found.smoothed is not None
    told = logs.read_roles(output, STANDARD.of("status", "odometry"))
    messages = told["status"]["messages"] if "status" in told else []
    reasons = [(message.utime, reason) for message in messages for reason in message.reasons]
    sigma = float(told["odometry"]["wheel_scale_sigma"][-1])
    body = found.smoothed
    smoothed = found.antennas[0].track(body) if 0 in found.antennas else body
    return Run(found.trajectory, smoothed, body, reasons, sigma)


def error(estimate: Trajectory, truth: Trajectory, chosen: Bools, by: Bools | None) -> float:
    """Of the chosen points of the truth, m; aligned by se2 over those of `by`; None: as it is."""
    pairs = associate(estimate, truth)
    used = np.isin(truth.time, pairs.truth.time)
    source, target = pairs.estimate.position, pairs.truth.position
    if by is not None:
        fit = fit_planar(source[by[used]], target[by[used]])
        source = source @ fit.matrix.T + fit.translation
    off = (source - target)[chosen[used], :2]
    return float(np.sqrt(np.mean(np.sum(off**2, axis=1))))


def compare(drive: Drive, bare: Run, helped: Run, chosen: Bools, fixed: Bools) -> dict[str, Any]:
    """The figures of one drive over the `chosen` points of the truth. `fixed`: those with fixes."""
    rows: dict[str, Any] = {}
    for mode in ("smoothed", "causal"):
        without, with_fixes = getattr(bare, mode), getattr(helped, mode)
        rows |= {
            f"{mode}_without_m": error(without, drive.truth, chosen, chosen),
            f"{mode}_placed_m": error(without, drive.truth, chosen, fixed),
            f"{mode}_m": error(with_fixes, drive.truth, chosen, chosen),
            f"{mode}_site_m": error(with_fixes, drive.truth, chosen, None),
        }
        rows[f"{mode}_ratio"] = rows[f"{mode}_m"] / rows[f"{mode}_without_m"]
        rows[f"{mode}_site_ratio"] = rows[f"{mode}_site_m"] / rows[f"{mode}_placed_m"]
    rows["smoothed_body_m"] = error(helped.smoothed_body, drive.truth, chosen, chosen)
    rows["smoothed_body_site_m"] = error(helped.smoothed_body, drive.truth, chosen, None)
    return rows
