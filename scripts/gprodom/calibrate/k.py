"""``gprodom calibrate k``: displacement per unit of shift of a radar front end."""

import argparse
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from gprodom.arrays import Floats, Ints
from gprodom.calibrate.fragment import Found, add_output_option, write_fragment
from gprodom.config import Configs, read_channels
from gprodom.console import Progress, add_json_flag, format_table, print_json, warn
from gprodom.convert.sampling import add_sample_interval_option
from gprodom.errors import Error, UsageError
from gprodom.files import temporary_folder
from gprodom.lcm import logs
from gprodom.odometry.displacement import Displacements, sequential
from gprodom.odometry.estimate import OnProgress, OnWarning, as_log
from gprodom.odometry.method import Method
from gprodom.odometry.methods import METHODS, find_method
from gprodom.odometry.replay import run_replay
from gprodom.options import Subparsers, add_command, add_config_options
from gprodom.score.associate import covered
from gprodom.score.record import sequence_name
from gprodom.score.sources import read_truth
from gprodom.trajectory import Trajectory, interpolate

# Shifts are measured with this K (metres a unit) and divided by it: the front end's own units.
MEASURING_K = 0.01
HUBER = 1.345  # standard deviations; 95 % efficient on normal errors
MIN_PAIRS = 20

DESCRIPTION = """\
Fits K, the displacement in metres per unit of shift that a sequential radar front end reports
(columns of its matrix; traces for trace_count), on sequences with truth: robust least squares
(Huber) of the true displacement over each window on the size of its shift. Set the result as
paper.k. Do not fit it on the sequences that you score, but on others of the same scene.

examples:
  gprodom calibrate k 1700001000-0-gates_g-cmu-gpr.zip 1700002000-0-gates_g-cmu-gpr.zip
  gprodom calibrate k garage.lcmlog --method dec --json
"""


@dataclass(frozen=True)
class Shifts:
    """Shifts of windows (n,), in the front end's units and signed, with the true displacement."""

    start: Ints
    end: Ints
    shift: Floats
    distance: Floats  # (n,), metres, straight-line; NaN where the truth does not cover the window


@dataclass(frozen=True)
class Fit:
    """K in metres per unit of shift, from n windows; robust spread of the residuals, metres."""

    k: float
    n: int
    residual_m: float


def true_distance(truth: Trajectory, displacements: Displacements) -> Floats:
    """Straight-line displacement (n,), metres, of the truth over each window; NaN without truth."""
    distance = np.full(len(displacements), np.nan)
    known = covered(truth, displacements.start) & covered(truth, displacements.end)
    start = interpolate(truth, displacements.start[known]).position
    end = interpolate(truth, displacements.end[known]).position
    distance[known] = np.linalg.norm((end - start)[:, :2], axis=1)
    return distance


def measure_shifts(
    log: Path,
    method: Method,
    configs: Configs,
    overrides: Sequence[str],
    truth: Trajectory | None,
    output: Path,
    on_progress: OnProgress | None = None,
    on_warning: OnWarning | None = None,
) -> Shifts:
    """Replays `log` with the method's front end and reads the shifts that it published."""
    measuring = [*method.overrides, *overrides, f"{method.k_key}={MEASURING_K}"]
    run_replay(
        log, output, configs, measuring, on_progress, on_warning=on_warning, poses_needed=False
    )
    names = read_channels(configs, measuring).of("displacement")
    found = sequential(logs.read_roles(output, names), method.front_end)
    distance = np.full(len(found), np.nan) if truth is None else true_distance(truth, found)
    return Shifts(found.start, found.end, found.distance / MEASURING_K, distance)


def fit_k(shifts: Sequence[Shifts]) -> Fit:
    """Robust least squares through the origin of true displacement on the size of the shift."""
    if not shifts:
        raise Error("no sequence to fit K on")
    x = np.abs(np.concatenate([part.shift for part in shifts]))
    y = np.concatenate([part.distance for part in shifts])
    x, y = x[np.isfinite(y)], y[np.isfinite(y)]
    if x.size < MIN_PAIRS or not np.any(x > 0):
        raise Error(
            f"K cannot be fitted: {int(np.sum(x > 0))} windows with truth and a shift other than "
            f"0; at least {MIN_PAIRS} are needed"
        )
    k, spread = float(x @ y / (x @ x)), 0.0
    for _ in range(100):
        residual = y - k * x
        spread = 1.4826 * float(np.median(np.abs(residual - np.median(residual))))
        size = np.maximum(np.abs(residual), 1e-12)
        weight = np.minimum(1.0, HUBER * max(spread, 1e-9) / size)
        before, k = k, float(np.sum(weight * x * y) / np.sum(weight * x * x))
        if abs(k - before) <= 1e-12 * abs(k):
            break
    return Fit(k, int(x.size), spread)


def add_parser(subjects: Subparsers) -> None:
    """Adds ``calibrate k``."""
    k = add_command(subjects, "k", "displacement per shift of a radar front end", DESCRIPTION, run)
    k.operand("sources", "SEQ|LOG", "sequence with truth", nargs="+")
    k.option("--method METHOD", "sfm", "sfm (default), bscan, dec, salient or trace_count")
    add_config_options(k)
    add_sample_interval_option(k)
    add_output_option(k)
    add_json_flag(k)


def run(args: argparse.Namespace) -> int:
    """Runs ``calibrate k``."""
    method = find_method(args.method)
    if not method.k_key:
        having = ", ".join(name for name, each in METHODS.items() if each.k_key)
        raise UsageError(f"--method {method.name} has no K; expected one of {having}")
    channels = read_channels(args.configs, args.overrides)
    parts: dict[str, Shifts] = {}
    with Progress("measuring shifts", len(args.sources)) as progress:
        for i, source in enumerate(args.sources):
            with temporary_folder() as folder:
                log = as_log(source, folder, args.sample_interval, channels)
                truth = read_truth(source, frame=None).trajectory
                parts[sequence_name(source)] = measure_shifts(
                    log,
                    method,
                    args.configs,
                    args.overrides,
                    truth,
                    folder / "output.lcmlog",
                    lambda share, done=i: progress.update(done + share),  # type: ignore[misc]
                    warn,
                )
    whole = fit_k(list(parts.values()))
    found = Found(
        method.k_key, f"{whole.k:.6g}", f"{whole.n} windows, {whole.residual_m:.3f} m left"
    )
    write_fragment(args.output, [found])
    fits = {name: fit_k([part]) for name, part in parts.items()}
    if args.json:
        each = {name: asdict(fit) for name, fit in fits.items()}
        print_json({"method": method.name, "key": method.k_key, **asdict(whole), "sequences": each})
        return 0
    rows = [[name, f"{fit.k:.6g}", fit.n, fit.residual_m] for name, fit in fits.items()]
    rows.append(["all", f"{whole.k:.6g}", whole.n, whole.residual_m])
    print(format_table(["sequence", "K (m)", "windows", "residual (m)"], rows))
    print(f"{method.k_key}: {whole.k:.6g}")
    return 0
