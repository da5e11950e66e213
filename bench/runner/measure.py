"""Measures the jobs of benches by an executor, or takes what was measured before."""

from __future__ import annotations

import json
import os
import platform
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from datetime import UTC, datetime
from itertools import chain
from pathlib import Path
from typing import Any

from job import MOST_S, Bench, Job, Program, command_line, digests_of_data, key_of

from figures import Figure, Measured, Report
from gprodom.console import to_json
from gprodom.errors import Error
from gprodom.executor import Answer, Call, Executor, LocalExecutor
from gprodom.files import write_bytes

# A bench ends with 1 where a figure is over what its program asks for, which is no failure here.
FINE = (0, 1)
NOT_HERE = 3  # a bench that is not possible on this machine says why


@dataclass(frozen=True)
class Settings:
    """What all jobs share. overrides: of the estimator's settings."""

    data: Path
    cache: Path
    short: bool
    overrides: tuple[str, ...] = ()
    fresh: bool = False


@dataclass(frozen=True)
class Task:
    """A job that can be run. arguments: with the overrides."""

    bench: Bench
    job: Job
    arguments: tuple[str, ...]
    data: dict[str, str]
    key: str

    @property
    def name(self) -> str:
        """For people."""
        return f"{self.bench.name}/{self.job.name}"

    def figures(self, output: Any) -> Iterator[Figure]:
        """Of what its program has printed."""
        prefix = f"{self.job.prefix}/" if self.job.prefix else ""
        for figure in self.bench.read(output):
            yield replace(figure, name=prefix + figure.name)


class Measurement:
    """Of one program."""

    def __init__(
        self,
        program: Program,
        settings: Settings,
        executor: Executor,
        prepare: Callable[[], None] = lambda: None,
    ) -> None:
        """prepare: called before anything is run, but not where all was measured before."""
        self._program, self._settings, self._executor = program, settings, executor
        self._prepare = prepare

    def of(self, benches: Sequence[Bench]) -> list[Report]:
        """Their reports, in their order; without benches of which nothing is short, if it is."""
        tasks: list[Task] = []
        measured: dict[str, Measured] = {}
        failed: dict[str, str] = {}
        for bench in benches:
            for job in bench.jobs:
                if self._settings.short and not job.short:
                    continue
                try:
                    task = self._task(bench, job)
                except Error as error:
                    failed[f"{bench.name}/{job.name}"] = str(error)
                    continue
                kept = None if self._settings.fresh else self._kept(task)
                if kept is None:
                    tasks.append(task)
                else:
                    measured[task.name] = kept
        if measured:
            print(f"{len(measured)} jobs were measured before", file=sys.stderr)
        if tasks:
            self._prepare()
        together = self._run([task for task in tasks if not task.bench.alone], self._executor)
        alone = self._run([task for task in tasks if task.bench.alone], LocalExecutor(1))
        begun = time.monotonic()
        for done, (task, answer) in enumerate(chain(together, alone), 1):
            try:
                if answer.code == NOT_HERE:
                    said = f"NOT RUN: {answer.said.strip()}"
                else:
                    measured[task.name] = self._read(task, answer)
                    said = f"{answer.seconds:.0f} s"
            except Error as error:
                failed[task.name] = str(error)
                said = f"failed: {str(error).splitlines()[0]}"
            minutes = (time.monotonic() - begun) * (len(tasks) / done - 1) / 60
            left = f"[{done}/{len(tasks)}, {minutes:.0f} min left]"
            print(f"{left} {task.name}: {said}", file=sys.stderr)
        return [report for bench in benches if (report := _report(bench, measured, failed))]

    def _task(self, bench: Bench, job: Job) -> Task:
        arguments = job.command(self._settings.short)
        if bench.settable:
            overrides = self._settings.overrides
            arguments += tuple(word for each in overrides for word in ("--set", each))
        data = digests_of_data(job, self._settings.data)
        key = key_of(self._program, bench, arguments, data)
        return Task(bench, job, arguments, data, key)

    def _run(self, tasks: list[Task], executor: Executor) -> Iterator[tuple[Task, Answer]]:
        environment = self._program.environment()
        calls = [
            Call(command_line(task.bench, task.arguments, self._settings.data), environment, MOST_S)
            for task in tasks
        ]
        for index, finished in executor.run(calls):
            try:
                answer = finished.result()
            except Exception as error:  # a job that fails in any way is told, the others go on
                answer = Answer(-1, "", f"{type(error).__name__}: {error}", 0.0)
            yield tasks[index], answer

    def _path(self, key: str) -> Path:
        return self._settings.cache / key[:2] / f"{key}.json"

    def _kept(self, task: Task) -> Measured | None:
        path = self._path(task.key)
        if not path.exists():
            return None
        content = json.loads(path.read_text(encoding="utf-8"))
        figures = tuple(task.figures(content["output"]))
        return Measured.of({**content["measured"], "figures": [asdict(each) for each in figures]})

    def _read(self, task: Task, answer: Answer) -> Measured:
        """What was measured, which is kept; raises `Error` where it failed."""
        said = answer.said.splitlines()[-1:] or ["said nothing"]
        if answer.code not in FINE:
            raise Error(f"exit code {answer.code}: {said[0]}")
        try:
            output = json.loads(answer.output)
            figures = tuple(task.figures(output))
        except (KeyError, TypeError, ValueError) as error:
            why = f" ({type(error).__name__} {error})" if answer.output.strip() else ""
            raise Error(f"no figures: {said[0]}{why}") from None
        words = " ".join([task.bench.program, *task.arguments])
        words = words.replace("{data}", "../shared/data").replace("{checkout}/", "")
        measured = Measured(
            task.job.name,
            f"bench/{words}",
            self._program.commit,
            datetime.now(UTC).date().isoformat(),
            machine(),
            round(answer.seconds, 1),
            task.data,
            task.key,
            figures,
        )
        path = self._path(task.key)
        path.parent.mkdir(parents=True, exist_ok=True)
        kept = {"output": output, "measured": asdict(measured)}
        write_bytes(path, (to_json(kept) + "\n").encode())
        return measured


def machine() -> str:
    """Where times were measured: its processor and cores."""
    name = platform.machine()
    try:
        for line in Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                name = line.partition(":")[2].strip()
                break
    except OSError:
        pass
    return f"{name}, {os.cpu_count()} cores"


def _report(bench: Bench, measured: dict[str, Measured], failed: dict[str, str]) -> Report | None:
    names = [f"{bench.name}/{job.name}" for job in bench.jobs]
    jobs = tuple(measured[name] for name in names if name in measured)
    lost = {name.split("/", 1)[1]: failed[name] for name in names if name in failed}
    counts = Counter(figure.name for job in jobs for figure in job.figures)
    for name, count in counts.items():
        if count > 1:
            lost[name] = "a figure of this name twice: give the jobs a prefix"
    return Report(bench.name, bench.title, jobs, lost) if jobs or lost else None
