"""A program that is run as a task: whole, with what it says and how long it took."""

from __future__ import annotations

import os
import subprocess
import time
from collections.abc import Mapping
from dataclasses import dataclass

NO_ANSWER = -1


@dataclass(frozen=True)
class Answer:
    """Of a program. code: `NO_ANSWER` where it was ended for taking too long."""

    code: int
    output: str
    said: str  # on standard error, its last lines
    seconds: float


@dataclass(frozen=True)
class Call:
    """A program with its arguments, as a task for `gprodom.executor`. environment: beside that of
    the worker. limit_s: after which it is ended."""

    command: tuple[str, ...]
    environment: Mapping[str, str]
    limit_s: float

    def __call__(self) -> Answer:
        """Runs it to its end."""
        started = time.monotonic()
        try:
            done = subprocess.run(
                self.command,
                env={**os.environ, **self.environment},
                capture_output=True,
                text=True,
                errors="replace",
                timeout=self.limit_s,
            )
        except subprocess.TimeoutExpired:
            return Answer(NO_ANSWER, "", f"took more than {self.limit_s:.0f} s", self.limit_s)
        said = "\n".join(done.stderr.strip().splitlines()[-20:])
        return Answer(done.returncode, done.stdout, said, time.monotonic() - started)
