"""Where many independent tasks run: processes of this machine, or a Dask cluster; a program as a
task."""

import os
import signal
import subprocess
import time
from collections import Counter, deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Future, ProcessPoolExecutor, wait
from dataclasses import dataclass
from typing import Protocol, TypeVar

from gprodom.errors import Error

Result = TypeVar("Result")
Given = TypeVar("Given", covariant=True)
# A task that was running each time that a worker died is most likely why.
MOST_LOSSES = 3


class Finished(Protocol[Given]):
    """A task that has ended; `result` gives what it returned, or raises what it raised."""

    def result(self) -> Given:
        """What the task returned; raises what it raised, or `Error` where its workers died."""
        ...


class Executor(Protocol):
    """Runs tasks, which must be picklable. A worker that dies loses no result: what it was working
    on is run again elsewhere, up to `MOST_LOSSES` times."""

    @property
    def workers(self) -> int:
        """Tasks at once."""
        ...

    def run(self, tasks: Sequence[Callable[[], Result]]) -> Iterator[tuple[int, Finished[Result]]]:
        """Number of a task and its end, in the order in which they end."""
        ...


class LocalExecutor:
    """Processes of this machine."""

    def __init__(self, workers: int) -> None:
        self.workers = workers

    def run(self, tasks: Sequence[Callable[[], Result]]) -> Iterator[tuple[int, Finished[Result]]]:
        """See `Executor`."""
        waiting = deque(range(len(tasks)))
        losses: Counter[int] = Counter()
        while waiting:
            pool = ProcessPoolExecutor(self.workers, initializer=_leave_signals)
            running: dict[Future[Result], int] = {}
            broken = False
            try:
                while running or (waiting and not broken):
                    # No more than run at once, so that a dead worker is known by what it did.
                    while waiting and not broken and len(running) < self.workers:
                        index = waiting.popleft()
                        running[pool.submit(tasks[index])] = index
                    for future in wait(running, return_when=FIRST_COMPLETED).done:
                        index = running.pop(future)
                        if not isinstance(future.exception(), BrokenExecutor):
                            yield index, future
                            continue
                        broken = True
                        losses[index] += 1
                        if losses[index] < MOST_LOSSES:
                            waiting.append(index)
                        else:
                            yield index, _lost()
            finally:
                pool.shutdown(cancel_futures=True)


def _lost() -> Future[Result]:
    future: Future[Result] = Future()
    future.set_exception(Error(f"its worker ended without a word {MOST_LOSSES} times"))
    return future


def _leave_signals() -> None:
    """An interrupt ends a worker at once, without a traceback; the parent cancels the rest. So does
    SIGTERM, by which a pool ends its workers when one has died: as an exception (`gprodom.cli`) it
    would end the task alone, and the pool waits for ever."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)


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
    """A program with its arguments, as a task. environment: beside that of
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
