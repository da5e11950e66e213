"""``gprodom plot``."""

import argparse
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

from gprodom import canvas
from gprodom.calibrate.k import measure_shifts
from gprodom.config import read_channels
from gprodom.console import Progress, add_json_flag, format_table, tell, to_json, warn
from gprodom.convert.sampling import add_sample_interval_option
from gprodom.errors import Error, UsageError
from gprodom.files import OutputFolder, temporary_folder, write_text
from gprodom.lcm import logs
from gprodom.odometry.dead_reckoning import wheel_distance
from gprodom.odometry.estimate import as_log
from gprodom.odometry.methods import METHODS, find_method
from gprodom.options import Subparsers, add_command, add_config_options
from gprodom.plot import radar, revisits
from gprodom.plot.log import flag_shares, log_figure
from gprodom.plot.observability import Observed, measure, observability_figure, observe, pool
from gprodom.score.align import FIRST_M, add_align_option, fit
from gprodom.score.associate import associate
from gprodom.score.frames import in_last_frame, warn_of_frames
from gprodom.score.pictures import draw_paths
from gprodom.score.sources import FRAMES, read_estimate, read_truth
from gprodom.trajectory import Trajectory

EXAMPLES = """
examples:
  gprodom plot trajectory wheel.tum imu_wheel.tum --truth garage.zip -o paths.png
  gprodom plot log out.lcmlog --wheel garage.lcmlog -o garage.png
  gprodom plot observability data/*gates_g*.zip -o out
  gprodom plot radar garage.lcmlog --at 40 -o radar.png
  gprodom plot revisits out.lcmlog -o revisits.png
"""

TRAJECTORY = """\
Draws trajectories (logs or TUM files) seen from above, over the truth where it is given.
"""

LOG = """\
Draws what a log of the estimator says along time: speed beside the wheel's, standard
deviations, and the flags (standing, slipping and so on); prints the share of each flag.
"""

OBSERVABILITY = """\
Measures what time-ordered windows of radar traces observe: the shift that a front end finds against
the displacement that took place, for each of --methods side by side. Writes observability.png and
observability.json to DIR and prints the figures.
"""


def add_parser(subparsers: Subparsers) -> None:
    """Adds ``plot`` and its subjects."""
    parser = add_command(subparsers, "plot", "draw pictures", "Draws pictures.\n" + EXAMPLES)
    subjects = parser.add_subparsers(metavar="WHAT", required=True)
    _add_trajectory(subjects)
    _add_log(subjects)
    _add_observability(subjects)
    radar.add_parser(subjects)
    revisits.add_parser(subjects)


def _add_trajectory(subjects: Subparsers) -> None:
    parser = add_command(
        subjects,
        "trajectory",
        "trajectories seen from above",
        TRAJECTORY + EXAMPLES,
        run_trajectory,
    )
    parser.operand("estimates", "EST", "log or TUM file", nargs="+")
    parser.option("--truth TRUTH", Path, "truth, to which the trajectories are aligned")
    parser.option(
        "--labels A,B",
        str,
        "names of the trajectories in the legend (default: the methods that the files are "
        "named by, else estimate 1 and so on, in the order given)",
    )
    add_align_option(parser)
    parser.choice("--frame", FRAMES, "map", "frame of the poses of logs (default map)")
    parser.picture_output()
    add_config_options(parser)


def _add_log(subjects: Subparsers) -> None:
    parser = add_command(
        subjects, "log", "speed, uncertainty and flags along time", LOG + EXAMPLES, run_log
    )
    parser.operand("log", "LOG", "output of a replay or a recording")
    parser.option(
        "--wheel LOG", Path, "log with the wheel's speed: the replay's input (its output has none)"
    )
    parser.picture_output()
    parser.common_options()


def _add_observability(subjects: Subparsers) -> None:
    parser = add_command(
        subjects,
        "observability",
        "what radar windows observe",
        OBSERVABILITY + EXAMPLES,
        run_observability,
    )
    parser.operand("sources", "SEQ|LOG", "sequence with truth", nargs="+")
    parser.option("--methods A,B", "sfm,trace_count", "front ends (default sfm,trace_count)")
    parser.output("DIR", "folder for the results", OutputFolder)
    add_config_options(parser)
    add_sample_interval_option(parser)
    add_json_flag(parser)


def run_trajectory(args: argparse.Namespace) -> int:
    """Runs ``plot trajectory``."""
    labels = labels_of(args.estimates, args.labels)
    paths: dict[Path, Trajectory] = {}
    channels = read_channels(args.configs, args.overrides)
    truth = read_truth(args.truth, channels=channels).trajectory if args.truth else None
    for path in args.estimates:
        source = read_estimate(path, args.frame, channels)
        warn_of_frames(source.trajectory, source.frame)
        trajectory = in_last_frame(source.trajectory, source.frame)
        if truth is not None:
            pairs = associate(trajectory, truth)
            trajectory = fit(pairs, args.align, FIRST_M).apply(pairs.estimate)
        paths[path] = trajectory
    figure, (axis,) = canvas.new_figure(width=7.5, height=5.5)
    named = dict(zip(labels, paths.values(), strict=True))
    draw_paths(axis, None if truth is None else truth.position, named)
    canvas.legend_below(axis, 4)
    canvas.save(figure, args.output)
    return 0


def labels_of(estimates: Sequence[Path], told: str | None) -> list[str]:
    """What the paths are called: as told, else by the names of methods, of which a benchmark names
    its files, and `estimate`, with a number where there are several."""
    if len(set(estimates)) < len(estimates):
        raise UsageError("the same trajectory twice")
    if told is not None:
        labels = [label.strip() for label in told.split(",")]
        if not len(labels) == len(set(labels)) == len(estimates):
            raise UsageError(f"--labels: expected {len(estimates)} different names, got {told!r}")
        return labels
    labels = []
    for i, path in enumerate(estimates, start=1):
        method, _, rest = path.name.partition(".")
        smoothed = ", smoothed" if rest.startswith("smoothed") else ""
        name = f"{method}{smoothed}" if method in METHODS else "estimate"
        several = name == "estimate" and len(estimates) > 1
        labels.append(f"{name} {i}" if several or name in labels else name)
    return labels


def run_log(args: argparse.Namespace) -> int:
    """Runs ``plot log``."""
    channels = read_channels(args.configs, args.overrides)
    log = logs.read_roles(args.log, channels.of("odometry", "wheel"))
    if "odometry" not in log:
        wanted = channels.odometry
        raise Error(f"{args.log}: holds no {wanted} messages; expected a log of the estimator")
    if args.wheel:
        log |= logs.read_roles(args.wheel, channels.of("wheel"))
    canvas.save(log_figure(log, args.log.stem), args.output)
    shares = flag_shares(log)
    figures = {"messages": int(log["odometry"]["utime"].size), "flags": shares}
    tell(args.json, figures, format_table(["flag", "share"], list(shares.items())))
    return 0


def run_observability(args: argparse.Namespace) -> int:
    """Runs ``plot observability``."""
    methods = [find_method(name.strip()) for name in args.methods.split(",")]
    for method in methods:
        if not method.k_key:
            raise UsageError(f"--methods: {method.name} measures no shift")
    channels = read_channels(args.configs, args.overrides)
    seen: dict[str, list[Observed]] = {method.name: [] for method in methods}
    with Progress("measuring shifts", len(args.sources) * len(methods)) as progress:
        for source in args.sources:
            with temporary_folder() as folder:
                log = as_log(source, folder, args.sample_interval, channels)
                truth = read_truth(source, frame=None).trajectory
                wheel = wheel_distance(logs.read_roles(log, channels.of("wheel")))
                for method in methods:
                    output = folder / "output.lcmlog"
                    settings = (args.configs, args.overrides)
                    shifts = measure_shifts(log, method, *settings, truth, output, on_warning=warn)
                    seen[method.name].append(observe(shifts, *wheel))
                    progress.advance()
    pooled = {name: pool(parts) for name, parts in seen.items()}
    figures = {name: measure(windows) for name, windows in pooled.items()}
    content = {name: asdict(found) for name, found in figures.items()}
    args.output.mkdir(parents=True, exist_ok=True)
    canvas.save(observability_figure(pooled, figures), args.output / "observability.png")
    write_text(args.output / "observability.json", to_json(content) + "\n")
    rows = [[key, *(of[key] for of in content.values())] for key in next(iter(content.values()))]
    tell(args.json, content, format_table(["figure", *content], rows))
    return 0
