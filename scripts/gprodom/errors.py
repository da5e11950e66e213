"""Errors that end a command with one line: what is wrong, where, and what was expected."""


class Error(Exception):
    """Something in the data or the machine: ``gprodom: error: MESSAGE``, exit code 1."""

    exit_code = 1


class UsageError(Error):
    """Arguments that argparse cannot judge by itself: exit code 2."""

    exit_code = 2
