"""``gprodom run``: one method on one sequence, to a TUM file."""

import argparse
from pathlib import Path

from gprodom.config import read_channels
from gprodom.console import Progress, add_json_flag, tell, warn
from gprodom.convert.sampling import add_sample_interval_option
from gprodom.errors import UsageError
from gprodom.files import OutputFile, temporary_folder
from gprodom.odometry.estimate import as_log, estimate
from gprodom.odometry.methods import describe_methods, find_method
from gprodom.options import Subparsers, add_command, add_config_options, add_method_options
from gprodom.score.align import FIRST_M, add_align_option
from gprodom.score.associate import associate, warn_of_uncovered
from gprodom.score.figures import compare
from gprodom.score.frames import in_last_frame, warn_of_frames
from gprodom.score.record import describe, make_record, sequence_name
from gprodom.score.sources import read_truth
from gprodom.trajectory import write_tum

DESCRIPTION = f"""\
Runs one method on a CMU-GPR sequence (directory or zip; converted first) or on an LCM log, writes
the trajectory as it was published (causal), and scores it where --truth is given.

methods:
{describe_methods()}

examples:
  gprodom run 1700001000-0-gates_g-cmu-gpr.zip --method imu_wheel --tum garage.tum
  gprodom run garage.lcmlog --method gprodom -o out.lcmlog --truth garage.lcmlog
  gprodom run garage.lcmlog --method gprodom --set wheel.scale=0.97 --tum garage.tum
"""


def add_parser(subparsers: Subparsers) -> None:
    """Adds the subcommand."""
    parser = add_command(subparsers, "run", "run a method on a sequence", DESCRIPTION, run)
    parser.operand("source", "SEQ|LOG", "sequence or LCM log")
    parser.add_argument("--method", required=True, help="see above")
    add_config_options(parser)
    add_method_options(parser)
    parser.option("--tum FILE", OutputFile, "file for the trajectory")
    parser.option(
        "--smoothed FILE", OutputFile, "file for every state from one solution over all data (TUM)"
    )
    parser.output("LOG", "file for the replay's log", required=False)
    parser.option("--truth TRUTH", Path, "score against this (as gprodom score does)")
    add_align_option(parser)
    add_sample_interval_option(parser)
    add_json_flag(parser)


def run(args: argparse.Namespace) -> int:
    """Runs the subcommand."""
    method = find_method(args.method, args.networks, args.pipes)
    if args.output and method.reckoned == "wheel":
        raise UsageError("-o: the method wheel is dead reckoning, there is no replay to keep")
    if args.smoothed and method.reckoned:
        raise UsageError(f"--smoothed: {method.name} is dead reckoning, there is nothing to solve")
    channels = read_channels(args.configs, args.overrides)
    # Read first, so that a wrong file is reported before the work and not after it.
    truth = read_truth(args.truth, channels=channels) if args.truth else None
    with temporary_folder() as folder:
        log = as_log(args.source, folder, args.sample_interval, channels)
        output = args.output or folder / "output.lcmlog"
        with Progress(method.name, 1.0) as progress:
            result = estimate(
                log,
                method,
                args.configs,
                args.overrides,
                output,
                progress.update,
                smooth=args.smoothed is not None,
                on_warning=warn,
            )
    if args.tum:
        write_tum(args.tum, result.trajectory)
    if result.smoothed is not None:
        write_tum(args.smoothed, result.smoothed)
    figures: dict[str, object] = {"method": method.name, "poses": len(result.trajectory)}
    text = f"{method.name}: {len(result.trajectory)} poses"
    if truth is not None:
        warn_of_frames(result.trajectory, result.frame)
        pairs = associate(in_last_frame(result.trajectory, result.frame), truth.trajectory)
        warn_of_uncovered(pairs)
        score = compare(pairs, args.align, FIRST_M)
        record = make_record(
            sequence_name(args.source),
            method.name,
            "causal",
            args.align,
            score.figures,
            result.jumps,
            result.answered,
            result.frame,
        )
        figures |= record.as_dict()
        text += "\n" + describe(record)
    tell(args.json, figures, text)
    return 0
