"""The ``gprodom`` command.

Every subcommand is a module with two functions:

``add_parser(subparsers)``
    adds its parser, which names `run` (`gprodom.options.add_command`);
``run(args) -> int``
    does the work and returns the exit code.

Arguments that are paths are inputs, or of a type of `gprodom.files.Output`: no command writes over
its inputs.

A module is registered by its name in `COMMANDS`. Modules are all imported to build the parser, so
they import what is slow (matplotlib, scipy) inside `run`.

Exit codes: 0 done, 1 failed (one line on stderr), 2 bad usage.
"""

import argparse
import os
import signal
import sys
from collections.abc import Sequence
from importlib import import_module
from pathlib import Path
from types import FrameType
from typing import Any, NoReturn

import gprodom
from gprodom.errors import Error
from gprodom.files import Output, check_outputs, reading
from gprodom.options import Parser
from gprodom.rooms import rooms

COMMANDS: tuple[str, ...] = (
    "gprodom.convert.command",
    "gprodom.ground.command",
    "gprodom.simulate.command",
    "gprodom.odometry.command",
    "gprodom.score.command",
    "gprodom.benchmark.command",
    "gprodom.calibrate.command",
    "gprodom.commission.command",
    "gprodom.doctor.command",
    "gprodom.export.command",
    "gprodom.plot.command",
    "gprodom.report.command",
    "gprodom.view.command",
    "gprodom.map.command",
    "gprodom.status.command",
    *(command for room in rooms() for command in room.COMMANDS),
)

DESCRIPTION = "Odometry from ground-penetrating radar, IMU and wheel encoder."

EPILOG = """\
examples:
  gprodom convert cmu 1613063877-0-gates_g-cmu-gpr.zip -o garage.lcmlog
  gprodom simulate --seed 7 -o 1700000000-0-yard-cmu-gpr.zip
  gprodom COMMAND --help

exit codes: 0 done, 1 failed, 2 bad usage
"""


def build_parser() -> Parser:
    """The parser with all registered subcommands."""
    parser = Parser(
        prog="gprodom",
        description=DESCRIPTION,
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--version", action=_Version, help="print the version and end")
    subparsers = parser.add_subparsers(metavar="COMMAND", required=True)
    for name in COMMANDS:
        import_module(name).add_parser(subparsers)
    return parser


class _Version(argparse.Action):
    """Looks the version up only when it is asked for."""

    def __init__(self, **options: Any) -> None:
        super().__init__(nargs=0, **options)

    def __call__(self, parser: argparse.ArgumentParser, *_: object) -> NoReturn:
        print(f"gprodom {gprodom.__version__}")
        parser.exit()


def paths_of(args: argparse.Namespace) -> tuple[list[Output], list[Path]]:
    """The outputs and the inputs among the arguments: all paths are one or the other."""
    values = [
        value
        for each in vars(args).values()
        for value in (each if isinstance(each, (list, tuple)) else [each])
        if isinstance(value, Path)
    ]
    outputs = [value for value in values if isinstance(value, Output)]
    return outputs, [value for value in values if not isinstance(value, Output)]


def _terminate(_signal: int, _frame: FrameType | None) -> NoReturn:
    raise SystemExit(128 + signal.SIGTERM)  # unwinds, so that half-written files are removed


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs the command line; returns the exit code."""
    signal.signal(signal.SIGTERM, _terminate)
    try:
        args = build_parser().parse_args(arguments)
        outputs, inputs = paths_of(args)
        with reading(inputs):
            check_outputs(outputs)
            code: int = args.run(args)
        sys.stdout.flush()
        return code
    except Error as error:
        print(f"gprodom: error: {error}", file=sys.stderr)
        return error.exit_code
    except BrokenPipeError:  # the reader of our output has gone (gprodom … | head)
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 1
    except OSError as error:
        where = f"{error.filename}: " if error.filename else ""
        print(f"gprodom: error: {where}{error.strerror or error}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        return 128 + signal.SIGINT
