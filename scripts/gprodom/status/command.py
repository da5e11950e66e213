"""``gprodom status``."""

import argparse
import sys
import time

from gprodom.console import add_json_flag, tell
from gprodom.errors import Error, UsageError
from gprodom.lcm import DEFAULT_URL, LCM, connect
from gprodom.options import Subparsers, add_command
from gprodom.status.heard import Heard, figures

DESCRIPTION = """\
Shows what a running gprodomd is doing, until interrupted: health and its reasons, the estimate with
its uncertainty, standstill, slip, revisits, rates and delays of all channels, and the daemon's own
counts and times.

If the output is no terminal (`gprodom status | cat`), prints one line a second.

--once prints one line and ends, with exit code 0 if the daemon is healthy, otherwise 1: degraded,
failed, or silent for --timeout.

examples:
  gprodom status
  gprodom status --once || systemctl restart gprodomd
  gprodom status --once --json
"""

LINE_S = 1.0  # between lines, where the output is no terminal
SETTLE_S = 1.2  # after the first message, so that rates are worth something


def add_parser(subparsers: Subparsers) -> None:
    """Registers the subcommand."""
    parser = add_command(subparsers, "status", "watch a running gprodomd", DESCRIPTION, run)
    parser.option("--lcm-url URL", DEFAULT_URL, "LCM connection (default: %(default)s)")
    parser.flag("--once", "print one line and end")
    parser.option("--timeout S", 5.0, "seconds to wait for the daemon, with --once (default: 5)")
    add_json_flag(parser)


def run(args: argparse.Namespace) -> int:
    """Exit code: with --once 0 where healthy, 1 where not."""
    if args.json and not args.once:
        raise UsageError("--json goes with --once")
    lcm = connect(args.lcm_url)
    heard = Heard()
    lcm.subscribe(".*", heard.take).set_queue_capacity(1000)
    if args.once:
        return _once(args, lcm, heard)
    return _watch(args, lcm, heard) if sys.stdout.isatty() else _print_lines(lcm, heard)


def _once(args: argparse.Namespace, lcm: LCM, heard: Heard) -> int:
    from gprodom.status.view import line

    started = time.monotonic()
    while heard.status is None or time.monotonic() < started + SETTLE_S:
        if time.monotonic() > started + max(args.timeout, SETTLE_S):
            raise Error(
                f"no STATUS on {args.lcm_url} within {args.timeout:g} s: is gprodomd running, "
                "on this URL?"
            )
        lcm.handle_timeout(50)
    tell(args.json, figures(heard), line(heard))
    return 0 if heard.status.health == heard.status.OK else 1


def _print_lines(lcm: LCM, heard: Heard) -> int:
    """A line a second, for a pipe, a file or a journal."""
    from gprodom.status.view import line

    due = time.monotonic() + SETTLE_S
    while True:
        lcm.handle_timeout(100)
        if time.monotonic() >= due:
            due = time.monotonic() + LINE_S
            print("no STATUS yet" if heard.status is None else line(heard), flush=True)


def _watch(args: argparse.Namespace, lcm: LCM, heard: Heard) -> int:
    from rich.live import Live

    from gprodom.status.view import page

    with Live(page(heard, args.lcm_url), auto_refresh=False, screen=True) as live:
        due = time.monotonic()
        while True:
            lcm.handle_timeout(100)
            if time.monotonic() >= due:
                live.update(page(heard, args.lcm_url), refresh=True)
                due = time.monotonic() + 0.25
