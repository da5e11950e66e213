"""``gprodom convert``: recordings of other makes to LCM logs."""

import argparse

from gprodom.config import read_channels
from gprodom.console import tell
from gprodom.convert import bag_command, survey_command, tables_command
from gprodom.convert.cmu import read_recording
from gprodom.convert.plausible import check_streams
from gprodom.convert.sampling import add_sample_interval_option
from gprodom.convert.streams import streams
from gprodom.convert.summary import as_text, summarise
from gprodom.lcm.log_writer import write_log
from gprodom.options import Subparsers, add_command

CMU_EXAMPLES = """
examples:
  gprodom convert cmu 1613063877-0-gates_g-cmu-gpr.zip -o garage.lcmlog
  gprodom convert cmu beach/ -o beach.lcmlog --sample-interval 3.125e-10 --json
"""

CMU_DESCRIPTION = """\
Converts a sequence of the CMU-GPR dataset to an LCM log with the channels GPR_TRACE, IMU, WHEEL
and, where there is truth, TOTAL_STATION, in order of time (at equal times: IMU, WHEEL, GPR_TRACE,
TOTAL_STATION). SEQ is a directory or the dataset's zip. Rows that are out of order are sorted into
place and counted; a malformed row ends the conversion, and no log is left behind.

gpr_meas.csv holds antenna 0; gpr_meas_1.csv and so on, where they are, become traces of antenna 1
and so on, on the same channel.

The dataset's files do not tell the time between radar samples. A sequence of `gprodom simulate`
holds it in gpr_meas.json; else it is --sample-interval.
"""


def add_parser(subparsers: Subparsers) -> None:
    """Adds ``convert`` and its formats."""
    parser = add_command(
        subparsers,
        "convert",
        "convert a recording to an LCM log",
        "Converts recordings of other makes to LCM logs.\n" + CMU_EXAMPLES,
    )
    formats = parser.add_subparsers(metavar="FORMAT", required=True)
    cmu = add_command(
        formats, "cmu", "a sequence of the CMU-GPR dataset", CMU_DESCRIPTION + CMU_EXAMPLES, run
    )
    cmu.operand("sequence", "SEQ", "directory or zip")
    cmu.output("LOG", "LCM log")
    add_sample_interval_option(cmu)
    cmu.common_options()
    bag_command.add_parser(formats)
    tables_command.add_parser(formats)
    survey_command.add_parser(formats)


def run(args: argparse.Namespace) -> int:
    """Converts and prints the summary."""
    channels = read_channels(args.configs, args.overrides)
    recording = read_recording(args.sequence)
    interval = args.sample_interval or recording.sample_interval
    made = streams(recording, interval, channels)
    check_streams(made)
    write_log(args.output, made)
    summary = summarise(recording, interval)
    tell(args.json, {"log": str(args.output), **summary}, as_text(summary))
    return 0
