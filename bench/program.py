"""What the command lines of the benches have in common."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import redirect_stdout
from io import StringIO
from multiprocessing import get_context
from pathlib import Path
from typing import Any, NoReturn, TypeVar

from gprodom.console import Progress, add_json_flag, format_table, print_json
from gprodom.errors import Error
from gprodom.options import add_overrides_option

T = TypeVar("T")


def parser_of(
    description: str | None, *, jobs: int | None = None, overrides: bool = False
) -> argparse.ArgumentParser:
    """With ``--json``; where asked for with ``--set`` to `args.overrides`, and with ``-j``.
    jobs: at once where the command line does not say."""
    parser = argparse.ArgumentParser(
        description=description, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    if overrides:
        add_overrides_option(parser)
    if jobs is not None:
        parser.add_argument("-j", "--jobs", type=int, default=jobs, help="at once (%(default)s)")
    add_json_flag(parser)
    return parser


def add_seeds(parser: argparse.ArgumentParser, name: str, count: int, first: int = 0) -> None:
    """How many seeds, as the option `name`, and ``--first-seed``; see `seeds_of`."""
    parser.add_argument(name, type=int, default=count, help="default: %(default)s", dest="seeds")
    parser.add_argument("--first-seed", type=int, default=first, help="default: %(default)s")


def seeds_of(args: argparse.Namespace) -> range:
    """Those of the command line."""
    return range(args.first_seed, args.first_seed + args.seeds)


def in_processes(
    jobs: int, what: str, work: Callable[..., T], *arguments: Sequence[Any]
) -> list[T]:
    """`work` of each of the arguments, side by side in other processes, in order."""
    # A fork would hang: OpenMP, which the solver uses, may have threads of this process by now.
    with (
        ProcessPoolExecutor(jobs, get_context("spawn")) as pool,
        Progress(what, len(arguments[0])) as progress,
    ):
        found = []
        for one in pool.map(work, *arguments):
            found.append(one)
            progress.advance()
    return found


def command(*words: object) -> str:
    """What a command of `gprodom` prints; raises `Error` where it fails."""
    from gprodom.cli import main

    said = StringIO()
    with redirect_stdout(said):
        code = main([str(word) for word in words])
    if code != 0:
        raise Error(f"gprodom {words[0]} {words[1]}: exit code {code}")
    return said.getvalue()


def one_by_one(what: str, things: Sequence[T]) -> Iterable[T]:
    """One after the other, with progress."""
    with Progress(what, len(things)) as progress:
        for thing in things:
            yield thing
            progress.advance()


def table_of(rows: Sequence[Mapping[str, object]], heads: Sequence[str] = ()) -> str:
    """A row each; its columns are all keys there are. heads: in place of the keys."""
    keys = list(dict.fromkeys(key for row in rows for key in row))
    return format_table(heads or keys, [[row.get(key) for key in keys] for row in rows])


def list_of(figures: Mapping[str, object]) -> str:
    """A figure a row; floats to four digits."""
    rows = [[k, f"{v:.4g}" if isinstance(v, float) else v] for k, v in figures.items()]
    return format_table(["figure", "value"], rows)


def print_rows(
    args: argparse.Namespace, rows: Sequence[Mapping[str, object]], heads: Sequence[str] = ()
) -> None:
    """As JSON or as `table_of`."""
    print_figures(args, rows, table_of(rows, heads))


def print_figures(args: argparse.Namespace, figures: object, text: str) -> None:
    """Prints the figures as JSON where that is asked for, else the text."""
    print_json(figures) if args.json else print(text)


def complain(error: object) -> None:
    """A line on stderr."""
    print(f"{Path(sys.argv[0]).stem}: error: {error}", file=sys.stderr)


def told_wrong(wrong: Sequence[object]) -> int:
    """Tells what is wrong, a line each; the exit code."""
    for each in wrong:
        complain(each)
    return 1 if wrong else 0


def exit_with(main: Callable[[], int | None], failed: int = 1) -> NoReturn:
    """With what `main` returns, or 0; an `Error` becomes a line, and the code `failed`."""
    try:
        sys.exit(main())
    except Error as error:
        complain(error)
        sys.exit(failed)
