"""The fault bench: replays sequences with one fault at a time and measures the effect.

Each LOG (a converted sequence) is replayed as it is and with every fault of kinds.py that --only
names (default: all), and in seeded combinations of three (--combinations).

Results are kept in DIR as they come; started again, the bench goes on where it was. Printed, and
written to DIR/table.md: for every fault the error over that of the clean run (mean over the
sequences, and the worst of them; of each the mean over its --draws), the longest silence, the time
after the fault until STATUS was well again, and what STATUS said. Exit code 1 where a fault ended
the program, made a number that is not finite or a pose that is earlier than the one before, or was
not told of in STATUS though it could be.

    python bench/faults LOG.lcmlog... -o DIR [-j 2]
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
import zlib
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from pathlib import Path
from typing import Any

sys.path.append(str(Path(__file__).resolve().parents[1]))

import kinds
import numpy as np
import outcome
import table

from gprodom.console import Progress
from gprodom.errors import Error
from gprodom.files import temporary_folder
from gprodom.odometry.replay import run_replay
from gprodom.options import add_config_option
from gprodom.score.sources import read_truth
from log_events import read_events, write_events
from program import complain, exit_with, parser_of, print_figures
from zips import log_of

BEGIN = 0.45  # of the run, where faults begin


@dataclass(frozen=True)
class Task:
    """A fault of a log. fault: its name, empty: the log as it is."""

    log: Path
    fault: str
    draw: int = 0

    @property
    def name(self) -> str:
        """Under which its result is kept."""
        name = self.fault or "clean"
        return f"{name}{table.DRAW}{self.draw}" if self.draw else name


class Results:
    """Kept in a folder, as they come."""

    def __init__(self, folder: Path) -> None:
        folder.mkdir(parents=True, exist_ok=True)
        self._file = folder / "results.jsonl"
        self.all: dict[tuple[str, str], dict[str, Any]] = {}
        if self._file.exists():
            for line in self._file.read_text().splitlines():
                result = json.loads(line)
                self.all[result["log"], result["fault"]] = result

    def missing(self, tasks: list[Task]) -> list[Task]:
        """Those without a result."""
        return [task for task in tasks if (task.log.stem, task.name) not in self.all]

    def keep(self, task: Task, result: dict[str, Any]) -> None:
        """Adds a result, in memory and on disk."""
        result = {"log": task.log.stem, "fault": task.name, **result}
        self.all[task.log.stem, task.name] = result
        with self._file.open("a") as file:
            file.write(json.dumps(result) + "\n")


def faults_of(combinations: int) -> dict[str, kinds.Fault]:
    """All there are, by name."""
    combined = [kinds.combination(seed) for seed in range(combinations)]
    return {fault.name: fault for fault in (*kinds.all_faults(), *combined)}


def replay(task: Task, args: argparse.Namespace) -> dict[str, Any]:
    """The result of a task, which another process may do."""
    truth, messages = read_truth(task.log).trajectory, read_events(task.log)
    first, last = messages[0][0], messages[-1][0]
    begin = round(first + BEGIN * (last - first))
    with tempfile.TemporaryDirectory(dir=args.output) as name:
        log, seconds, jump = task.log, 0.0, 0.0
        if task.fault:
            fault = faults_of(args.combinations)[task.fault]
            rng = np.random.default_rng([1 + task.draw, zlib.crc32(fault.name.encode())])
            log = write_events(fault.apply(messages, rng, begin), Path(name) / "in.lcmlog")
            jump = fault.jump
            seconds = (last - begin) * 1e-6 if fault.seconds is None else fault.seconds
        made = Path(name) / "out.lcmlog"
        try:
            run_replay(log, made, args.configs, poses_needed=False)  # silence is judged too
            return outcome.judge(made, truth, begin, begin + seconds * kinds.SECOND, jump)
        except Error as error:
            return {"ended": str(error)}


def tasks_of(args: argparse.Namespace, faults: dict[str, kinds.Fault]) -> list[Task]:
    """All that is to be done."""
    single = {fault.name for fault in kinds.all_faults()}
    tasks: list[Task] = []
    for log in args.logs:
        tasks.append(Task(log, ""))
        for name, fault in faults.items():
            if name in single and args.only and not any(only in name for only in args.only):
                continue
            tasks += [Task(log, name, n) for n in range(args.draws if fault.by_chance else 1)]
    return tasks


def parse() -> argparse.Namespace:
    """The command line."""
    parser = parser_of(__doc__, jobs=1)
    parser.add_argument("logs", nargs="+", type=Path, metavar="SEQ", help="log or zip")
    parser.add_argument("-o", "--output", type=Path, metavar="DIR", help="default: kept nowhere")
    add_config_option(parser)
    parser.add_argument(
        "--only", action="append", metavar="TEXT", help="faults whose name holds it; repeatable"
    )
    parser.add_argument("--combinations", type=int, default=10, help="default: 10")
    parser.add_argument(
        "--draws", type=int, default=1, help="of each fault that strikes by chance (default: 1)"
    )
    return parser.parse_args()


def main() -> int:
    """Runs the command line."""
    args = parse()
    with temporary_folder() as folder:
        args.output = args.output or folder
        args.output.mkdir(parents=True, exist_ok=True)
        return run(args)


def run(args: argparse.Namespace) -> int:
    """Replays what is missing; prints all."""
    args.logs = [log_of(source, args.output) for source in args.logs]
    results = Results(args.output)
    tasks = results.missing(tasks_of(args, faults_of(args.combinations)))
    with Progress("replays", len(tasks)) as progress, ProcessPoolExecutor(args.jobs) as pool:
        doing = {pool.submit(replay, task, args): task for task in tasks}
        for done in as_completed(doing):
            results.keep(doing[done], done.result())
            progress.advance()
    text, wrong = table.of_replays(results.all)
    (args.output / "table.md").write_text(text)
    print_figures(args, table.figures(results.all), text)
    for line in wrong:
        complain(line)
    return 1 if wrong else 0


if __name__ == "__main__":
    exit_with(main)
