"""Ends what the present process has started, and what that has started in turn."""

from __future__ import annotations

import os
import signal
from contextlib import suppress
from pathlib import Path
from types import FrameType


def descendants(process: int) -> list[int]:
    """Of a process that runs on this machine: parents before their children."""
    children: dict[int, list[int]] = {}
    for folder in Path("/proc").iterdir():
        if not folder.name.isdigit():
            continue
        try:
            # pid (name, which may hold anything) state parent ...
            parent = int((folder / "stat").read_text().rpartition(")")[2].split()[1])
        except (OSError, IndexError):  # it has just ended
            continue
        children.setdefault(parent, []).append(int(folder.name))
    found = [process]
    for each in found:
        found += children.get(each, [])
    return found[1:]


def end_descendants() -> None:
    """All of them are held first, so that none starts another one meanwhile."""
    held: list[int] = []
    while new := [each for each in descendants(os.getpid()) if each not in held]:
        _send(signal.SIGSTOP, new)
        held += new
    _send(signal.SIGTERM, held)
    _send(signal.SIGCONT, held)


def end_with_descendants_on_sigterm() -> None:
    """From now on SIGTERM ends them and is a KeyboardInterrupt in the main thread. (An interrupt
    from a terminal reaches them by itself.)"""
    signal.signal(signal.SIGTERM, _ended)


def _ended(_number: int, _frame: FrameType | None) -> None:
    end_descendants()
    raise KeyboardInterrupt


def _send(number: int, processes: list[int]) -> None:
    for each in processes:
        with suppress(ProcessLookupError):
            os.kill(each, number)
