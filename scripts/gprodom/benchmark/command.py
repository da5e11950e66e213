"""``gprodom benchmark``."""

import argparse
import os
import re
import sys
from pathlib import Path

from gprodom.benchmark.jobs import Sequence, Settings
from gprodom.benchmark.page import write_report
from gprodom.benchmark.pairs import MIN_SEQUENCES
from gprodom.benchmark.results import as_json, describe, write_csv
from gprodom.benchmark.schedule import make_all, run_all
from gprodom.benchmark.simulated import RAYS, drives
from gprodom.cluster import open_executor
from gprodom.config import read_channels
from gprodom.console import add_json_flag, tell, to_json
from gprodom.convert.sampling import sample_interval
from gprodom.errors import UsageError
from gprodom.files import OutputFolder, check_output, write_text
from gprodom.ground.survey import shipped
from gprodom.odometry.methods import DEFAULT_METHODS, describe_methods, find_method
from gprodom.options import (
    Subparsers,
    add_command,
    add_config_options,
    add_method_options,
    add_scheduler_option,
)
from gprodom.score.align import add_align_option, add_first_m_option
from gprodom.score.record import scene_of, sequence_name
from gprodom.score.sources import kind_of
from gprodom.simulate.lasting import KINDS

DESCRIPTION = f"""\
Runs methods on sequences (CMU-GPR directories or zips, or LCM logs), scores them against the
sequences' own truth, and writes

  DIR/SEQUENCE/METHOD.tum            the trajectory as published (causal)
  DIR/SEQUENCE/METHOD.smoothed.tum   every state from one solution over all data
  DIR/results.csv                    a row for each sequence, method and mode
  DIR/results.json                   the same, with means, the K of each row, and what failed
  DIR/report.html                    the paper's experiments on these sequences, beside the
                                     published figures, and every score; fetches nothing

The scene is read off a sequence's name (TIME-0-SCENE-cmu-gpr). Methods with a K (displacement per
unit of shift) have it fitted on the other sequences of the scene, or of all scenes where it has no
other, or too few windows with an answer. A second run with the same arguments goes on where the
first stopped; what changed is run again. A failure leaves the other rows going and ends with exit
code 1. From {MIN_SEQUENCES} sequences on every two methods are compared by paired differences with
bootstrap intervals.

--simulate N makes N sequences, kept in DIR/simulated (some 4 MB each): sequence i from seed S + i
alone, grounds, routes and the kinds of --lasting taking turns. The same arguments give the same
sequences, and a larger N adds to them.

methods:
{describe_methods()}

examples:
  gprodom benchmark data/*.zip -o out
  gprodom benchmark data/*.zip --methods sfm,trace_count -o out --sample-interval beach=3.125e-10
  gprodom benchmark --simulate 200 --methods wheel,imu_wheel,gprodom -o out
  gprodom benchmark --simulate 20 --distance 100 --lasting ramps,steps,turns,ice -o out
"""


def add_parser(subparsers: Subparsers) -> None:
    """Adds the subcommand."""
    parser = add_command(subparsers, "benchmark", "score methods on sequences", DESCRIPTION, run)
    parser.operand("sources", "SEQ", "sequence or LCM log", nargs="*")
    parser.option(
        "--methods A,B",
        ",".join(DEFAULT_METHODS),
        "see above (default: all but the signed and the learned ones)",
    )
    parser.output("DIR", "folder for the results", OutputFolder)
    parser.add_argument(
        "-j",
        "--jobs",
        type=int,
        metavar="N",
        default=os.cpu_count() or 1,
        help="parallel jobs (default: one per processor)",
    )
    parser.option("--simulate N", 0, "add N simulated sequences")
    parser.option("--seed S", 0, "seed of the first simulated sequence (default 0)")
    parser.option(
        "--grounds A,B", ",".join((*shipped(), RAYS)), "grounds of --simulate (default %(default)s)"
    )
    parser.option("--distance M", 30.0, "distance of --simulate, +-30 %% (default %(default)s)")
    parser.option(
        "--lasting A,B",
        "",
        f"slip of --simulate that lasts, some of {', '.join(KINDS)} (default: none)",
    )
    add_config_options(parser)
    add_method_options(parser)
    add_align_option(parser)
    add_first_m_option(parser)
    parser.option(
        "--sample-interval [SCENE=]S",
        parse_interval,
        "seconds between radar samples, of all sequences or of a scene's (default: as "
        "each sequence says, else 2e-10); may be repeated",
        action="append",
        default=[],
    )
    add_scheduler_option(parser)
    add_json_flag(parser)


def parse_interval(text: str) -> tuple[str, float]:
    """SCENE=S or S to (scene, seconds); the empty scene stands for all."""
    scene, _, number = text.rpartition("=")
    return scene, sample_interval(number)


def name_sequences(
    sources: list[Path], output: Path, intervals: dict[str, float]
) -> list[Sequence]:
    """The sequences by name. Names must differ, since results are kept in folders of that name."""
    sequences: dict[str, Sequence] = {}
    for source in sources:
        kind_of(source)  # a missing file ends the command before any work
        name = sequence_name(source)
        if name in sequences:
            raise UsageError(f"{source}: a second sequence of the name {name}")
        interval = intervals.get(scene_of(name), intervals.get(""))
        sequence = Sequence(name, source.resolve(), output / name, interval)
        if sequence.log.exists() and not sequence.log.is_symlink():
            check_output(sequence.log)  # made anew where it is old, and removed at the end
        sequences[name] = sequence
    return list(sequences.values())


def run(args: argparse.Namespace) -> int:
    """Runs the subcommand."""
    names = dict.fromkeys(re.split(r"[,\s]+", args.methods))
    networks = args.networks.resolve() if args.networks else None
    methods = [find_method(name, networks, args.pipes) for name in names]
    if args.jobs < 1:
        raise UsageError(f"-j {args.jobs}: expected at least 1")
    output: Path = args.output.resolve()  # a worker may be in another folder
    if args.simulate < 0 or not args.sources + [None] * args.simulate:
        raise UsageError("nothing to do: give sequences, or --simulate N")
    channels = read_channels(args.configs, args.overrides)
    grounds = tuple(args.grounds.split(","))
    made = drives(
        args.simulate, args.seed, grounds, args.distance, channels, tuple(args.lasting.split(","))
    )
    configs = tuple(config.resolve() for config in args.configs)
    settings = Settings(configs, tuple(args.overrides), args.align, args.first_m)
    with open_executor(args.jobs, args.scheduler) as executor:
        sources = [*args.sources, *make_all(made, output / "simulated", executor)]
        sequences = name_sequences(sources, output, dict(args.sample_interval))
        for sequence in sequences:
            sequence.folder.mkdir(parents=True, exist_ok=True)
        outcomes = run_all(sequences, methods, settings, executor)
    order = {sequence.name: i for i, sequence in enumerate(sequences)}
    records = [record for outcome in outcomes for record in outcome.records]
    by_sequence = sorted(records, key=lambda record: order[record.sequence])
    content = as_json(outcomes, by_sequence, settings)
    write_csv(output / "results.csv", by_sequence)
    write_text(output / "results.json", to_json(content) + "\n")
    write_report(output / "report.html", sequences, outcomes, records, settings)
    written = f"written: {output / 'results.csv'}, results.json, report.html"
    tell(args.json, content, f"{describe(records, args.align)}\n{written}")
    failures = [outcome for outcome in outcomes if outcome.failure]
    for outcome in failures:
        print(f"failed: {outcome.method} on {outcome.sequence}: {outcome.failure}", file=sys.stderr)
    return 1 if failures else 0
