"""The results of a calibration as a piece of configuration."""

import argparse
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from gprodom.console import print_json
from gprodom.files import write_text
from gprodom.options import Parser


@dataclass(frozen=True)
class Found:
    """A configuration key, its value as YAML, and its uncertainty in words.

    significant: it differs significantly from no effect; otherwise it is written as a comment,
    which changes no configuration.
    """

    key: str
    value: str
    sureness: str
    significant: bool = True


def add_output_option(parser: Parser) -> None:
    """``-o``: where the fragment goes."""
    what = "write the result, with its uncertainty, as a configuration for -c"
    parser.output("YAML", what, required=False)


def fragment(found: Sequence[Found]) -> str:
    """YAML with one level of sections, in the given order; insignificant values as comments."""
    sections: dict[str, list[str]] = {}
    lines = ["# Found by gprodom calibrate."]
    for item in found:
        section, _, key = item.key.rpartition(".")
        if item.significant:
            sections.setdefault(section, []).append(f"{key}: {item.value}  # {item.sureness}")
        else:
            lines.append(f"# not significant: {item.key}: {item.value}  # {item.sureness}")
    for section, entries in sections.items():
        parts = section.split(".")
        for depth, part in enumerate(parts):
            lines.append("  " * depth + f"{part}:")
        lines += ["  " * len(parts) + entry for entry in entries]
    if not sections:
        lines.append("{}")  # a configuration all the same
    return "\n".join(lines) + "\n"


def write_fragment(path: Path | None, found: Sequence[Found]) -> None:
    """Writes the fragment where `path` is given."""
    if path is not None:
        write_text(path, fragment(found))


def tell_found(args: argparse.Namespace, found: Sequence[Found], figures: Any) -> int:
    """Writes the fragment where asked to, and prints it, or the figures; the exit code."""
    write_fragment(args.output, found)
    if args.json:
        print_json(figures)
    else:
        print(fragment(found), end="")
    return 0
