"""The jobs of a benchmark, over the workers of an executor."""

from collections.abc import Callable, Iterable
from functools import partial
from pathlib import Path
from typing import TypeVar

from gprodom.benchmark.jobs import Outcome, Sequence, Settings, clean, run_job, save_shifts
from gprodom.benchmark.simulated import Drive
from gprodom.console import Progress
from gprodom.errors import Error
from gprodom.executor import Executor
from gprodom.odometry.method import Method
from gprodom.odometry.methods import METHODS

Result = TypeVar("Result")


def make_all(drives: list[Drive], folder: Path, executor: Executor) -> list[Path]:
    """Makes the logs of simulated drives in `folder`; existing ones are kept."""
    folder.mkdir(parents=True, exist_ok=True)
    with Progress("simulating", len(drives)) as progress:
        return _together([partial(drive.make, folder) for drive in drives], executor, progress)


def _together(
    tasks: Iterable[Callable[[], Result]], executor: Executor, progress: Progress
) -> list[Result]:
    """Their results, in their order."""
    results: dict[int, Result] = {}
    for index, finished in executor.run(list(tasks)):
        results[index] = finished.result()
        progress.advance()
    return [results[index] for index in sorted(results)]


def run_all(
    sequences: list[Sequence], methods: list[Method], settings: Settings, executor: Executor
) -> list[Outcome]:
    """Runs all methods on all sequences; a failure does not stop the others.

    First the shifts on which K is fitted, then everything. Consecutive jobs are of different
    sequences, so that workers seldom wait for the same conversion.
    """
    front_ends = dict.fromkeys(method.front_end for method in methods if method.k_key)
    total = len(sequences) * (len(front_ends) + len(methods))
    measured = [(name, each) for name in front_ends for each in sequences]
    with Progress("benchmark", total) as progress:
        try:
            measure = [partial(_measure, each, METHODS[name], settings) for name, each in measured]
            reasons = _together(measure, executor, progress)
            wanted = [(name, each.name) for name, each in measured]
            unmeasured = dict(zip(wanted, reasons, strict=True))
            run = [
                partial(
                    _run,
                    each,
                    method,
                    settings,
                    unmeasured.get((method.front_end, each.name), ""),
                    [other for other in sequences if other != each],
                )
                for method in methods
                for each in sequences
            ]
            return _together(run, executor, progress)
        finally:
            for sequence in sequences:
                clean(sequence)


def _measure(sequence: Sequence, method: Method, settings: Settings) -> str:
    """Measures the shifts of one front end on one sequence; returns the error, or nothing."""
    try:
        save_shifts(sequence, method, settings)
    except Error as error:
        return str(error)
    except Exception as error:  # as in run_job: a defect must not lose results of other jobs
        return f"{type(error).__name__}: {error}"
    return ""


def _run(
    sequence: Sequence, method: Method, settings: Settings, unmeasured: str, others: list[Sequence]
) -> Outcome:
    """Runs one method on one sequence; fails at once if the shifts that it needs are missing."""
    if unmeasured:
        return Outcome(sequence.name, method.name, failure=unmeasured)
    return run_job(sequence, method, settings, others)
