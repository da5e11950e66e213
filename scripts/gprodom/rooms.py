"""Folders of the package that stand alone: the rest works without them, and names none of them.

Such a folder has a module `room`: METHODS, rows for `gprodom.odometry.methods`; COMMANDS, modules
for `gprodom.cli`; add_method_options(parser), of the commands that run a method.
"""

from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from typing import Any


def rooms() -> Iterator[Any]:
    """The module `room` of each."""
    for path in sorted(Path(__file__).parent.glob("*/room.py")):
        yield import_module(f"gprodom.{path.parent.name}.room")
