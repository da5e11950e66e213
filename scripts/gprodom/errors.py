"""Errors that end a command with one line: what is wrong, where, and what was expected."""

from importlib import import_module
from typing import Any


class Error(Exception):
    """Something in the data or the machine: ``gprodom: error: MESSAGE``, exit code 1."""

    exit_code = 1


class UsageError(Error):
    """Arguments that argparse cannot judge by itself: exit code 2."""

    exit_code = 2


def need_module(name: str, extra: str, debian: str = "") -> Any:
    """The module `name` of a library that only the `extra` of this package needs; `debian`: its
    package there, if it has one."""
    try:
        return import_module(name)
    except ImportError:
        apt = f"apt install {debian}, or " if debian else ""
        raise Error(
            f"{name.partition('.')[0]} is not installed: {apt}pip install 'gprodom[{extra}]' (in a "
            f"checkout: .venv/bin/pip install -e 'scripts[{extra}]')"
        ) from None
