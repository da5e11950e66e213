"""Common parts of the commands' parsers."""

import argparse
import re
import sys
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

from gprodom.console import add_json_flag
from gprodom.files import PICTURES, Output, OutputFile, PictureFile
from gprodom.rooms import rooms

Subparsers = Any  # argparse's own class for this is private

_NEGATIVE = re.compile(r"-\.?\d")  # begins a value, and no option of ours


class Parser(argparse.ArgumentParser):
    """Declares options briefly, and takes values that begin with a minus.

    The value of a long option may, as coordinates do (`--datum -33.9,18.4`): argparse takes such a
    word for an option where it is not a single number.
    """

    def option(self, usage: str, kind: Any, what: str, **more: Any) -> None:
        """An option with a value.

        usage: its name and what stands for the value, as in `--speed M/S`.
        kind: the type of the value, or the default, whose type it then has.
        what: the help.
        more: as `add_argument` takes it.
        """
        if not callable(kind):
            more |= {"default": kind}
            kind = type(kind)
        name, metavar = usage.split()
        self.add_argument(name, metavar=metavar, type=kind, help=what, **more)

    def operand(self, name: str, metavar: str, what: str | None = None, **more: Any) -> None:
        """A word that stands by itself: a path, where `more` names no other type."""
        self.add_argument(name, metavar=metavar, help=what, **{"type": Path} | more)

    def choice(self, name: str, choices: Iterable[str], default: str | None, what: str) -> None:
        """An option whose value is one of the words `choices`."""
        self.add_argument(name, choices=choices, default=default, help=what)

    def flag(self, name: str, what: str) -> None:
        """An option without a value: False where it is not given."""
        self.add_argument(name, action="store_true", help=what)

    def output(
        self, metavar: str, what: str, kind: type[Output] = OutputFile, required: bool = True
    ) -> None:
        """``-o``, to `args.output`."""
        self.add_argument(
            "-o", "--output", type=kind, required=required, metavar=metavar, help=what
        )

    def picture_output(self) -> None:
        """``-o``, where the command makes one picture."""
        self.output("PICTURE", f"file to draw, ending in {', '.join(PICTURES)}", PictureFile)

    def common_options(self) -> None:
        """``-c``, ``--set`` and ``--json``."""
        add_config_options(self)
        add_json_flag(self)

    def parse_known_args(  # type: ignore[override]
        self, args: Sequence[str] | None = None, namespace: argparse.Namespace | None = None
    ) -> tuple[argparse.Namespace, list[str]]:
        """As argparse's own."""
        return super().parse_known_args(
            list(_joined(sys.argv[1:] if args is None else args)), namespace
        )


def _joined(words: Iterable[str]) -> Iterable[str]:
    """`--option -1,2` as `--option=-1,2`."""
    option = ""
    for word in words:
        if option and _NEGATIVE.match(word):
            yield f"{option}={word}"
            option = ""
            continue
        if option:
            yield option
        option = word if word.startswith("--") and len(word) > 2 and "=" not in word else ""
        if not option:
            yield word
    if option:
        yield option


def add_command(
    subparsers: Subparsers,
    name: str,
    summary: str,
    description: str,
    run: Callable[[argparse.Namespace], int] | None = None,
) -> Parser:
    """A subcommand's parser with house style: summary, description, examples at the end.

    description: with the examples, after a line `examples:`.
    run: does the work and returns the exit code; None where subcommands of its own do.
    """
    text, head, examples = description.partition("examples:\n")
    parser: Parser = subparsers.add_parser(
        name,
        help=summary,
        description=text,
        epilog=head + examples,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.set_defaults(run=run)
    return parser


def numbers(
    what: str, fit: Callable[[Sequence[Any]], Any], kind: type[float] = float
) -> Callable[[str], tuple[Any, ...]]:
    """The type of an option whose value is numbers between commas, for which `fit` is true.

    what: is expected, for the error.
    """

    def parse(text: str) -> tuple[Any, ...]:
        try:
            values = tuple(kind(part) for part in text.split(","))
        except ValueError:
            values = ()
        if not values or not fit(values):
            raise argparse.ArgumentTypeError(f"{text!r}: expected {what}")
        return values

    return parse


point = numbers("X,Y in metres", lambda values: len(values) == 2)


def add_config_option(parser: argparse.ArgumentParser) -> None:
    """``-c``, the same in every program that takes a configuration: to `args.configs`."""
    parser.add_argument(
        "-c",
        "--config",
        type=Path,
        action="append",
        default=[],
        metavar="CONFIG",
        dest="configs",
        help="configuration (default gprodom.yaml); a later one overrides earlier ones",
    )


def add_config_options(parser: argparse.ArgumentParser) -> None:
    """``-c`` and ``--set``."""
    add_config_option(parser)
    add_overrides_option(parser)


def add_overrides_option(parser: argparse.ArgumentParser) -> None:
    """``--set``, to `args.overrides`."""
    parser.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="KEY=VALUE",
        dest="overrides",
        help="override one configuration key; may be repeated",
    )


def add_scheduler_option(parser: argparse.ArgumentParser) -> None:
    """``--scheduler``, for commands with many jobs."""
    parser.add_argument(
        "--scheduler",
        metavar="ADDRESS",
        help="run the jobs on this Dask cluster (tcp://127.0.0.1:8786, or tls://HOST:PORT) in "
        "place of processes here; its workers have the same program and files",
    )


def add_method_options(parser: Parser) -> None:
    """``--pipes``, and what `rooms` add, for commands that run a method."""
    parser.set_defaults(networks=None)
    for room in rooms():
        room.add_method_options(parser)
    parser.option(
        "--pipes FILE",
        Path,
        "map of pipes for the method salient (YAML: pipes: [{x: M, depth: M}, ...], and if "
        "known wave_speed: M/S, and length: M of a line that closes)",
    )
