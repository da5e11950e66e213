"""Common parts of the commands' parsers."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

Subparsers = Any  # argparse's own class for this is private


def add_command(
    subparsers: Subparsers, name: str, summary: str, description: str, examples: str
) -> argparse.ArgumentParser:
    """A subcommand's parser with house style: summary, description, examples at the end."""
    parser: argparse.ArgumentParser = subparsers.add_parser(
        name,
        help=summary,
        description=description,
        epilog=f"examples:\n{examples.rstrip()}\n",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    return parser


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
    """``-c`` and ``--set``, the latter to `args.overrides`."""
    add_config_option(parser)
    parser.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="KEY=VALUE",
        dest="overrides",
        help="override one configuration key; may be repeated",
    )


def add_networks_option(parser: argparse.ArgumentParser) -> None:
    """``--networks``, for commands that run a method."""
    parser.add_argument(
        "--networks",
        type=Path,
        metavar="DIR",
        help="folder that gprodom learn wrote, for the learned methods",
    )
