"""``gprodom report``."""

import argparse
from pathlib import Path

from gprodom.config import read_channels
from gprodom.console import format_table, tell
from gprodom.files import write_text
from gprodom.options import Subparsers, add_command

DESCRIPTION = """\
Writes one HTML page about a drive, from a log of gprodom-replay or a recording of gprodomd: where
and how far, how sure, what went wrong and when, and pictures of the way, of time, of the revisits
and of the ground. No truth is needed. The page fetches nothing, suits a phone as well as paper
(four pages), and can be sent as it is. Prints the figures of its first table.

examples:
  gprodom report recording.lcmlog -o drive.html
  gprodom report out.lcmlog --sensors in.lcmlog -o drive.html
"""


def add_parser(subparsers: Subparsers) -> None:
    """Adds ``report``."""
    parser = add_command(subparsers, "report", "a page about a drive", DESCRIPTION, run)
    parser.operand("log", "LOG", "log with the estimate")
    parser.option(
        "--sensors SEQ|LOG",
        Path,
        "the replay's input, where LOG has no sensor data (as the output of a replay): for "
        "the wheel's speed, dead reckoning and the ground",
    )
    parser.output("FILE", "page to write")
    parser.common_options()


def run(args: argparse.Namespace) -> int:
    """Writes the page."""
    from gprodom.drive.log import read_drive
    from gprodom.drive.troubles import find_troubles
    from gprodom.report.page import facts_of, write_html

    drive = read_drive(args.log, read_channels(args.configs, args.overrides), args.sensors)
    troubles = find_troubles(drive)
    facts = facts_of(drive, troubles)
    write_text(args.output, write_html(drive, troubles, facts))
    table = format_table(["what", "value"], [[fact.name, fact.text] for fact in facts])
    tell(args.json, {fact.key: fact.value for fact in facts}, table)
    return 0
