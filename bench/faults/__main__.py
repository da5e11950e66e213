"""The fault bench: replays sequences with one fault at a time and measures the effect.

Each LOG (a converted sequence) is replayed as it is and with every fault of kinds.py that --only
names (default: all), in seeded combinations of three (--combinations), and, where the sequence's
.truth.npz lies in --truth, with each sensor away for 10 s at several times (--returns), for how
fast the error grows after it is back.

Results are kept in DIR as they come; started again, the bench goes on where it was. Printed, and
written to DIR/table.md: for every fault the error over that of the clean run (mean over the
sequences, and the worst of them; of each the mean over its --draws), the longest silence, the time
after the fault until STATUS was well again, and what STATUS said. Exit code 1 where a fault ended
the program, made a number that is not finite or a pose that is earlier than the one before, or was
not told of in STATUS though it could be.

    python bench/faults LOG.lcmlog... -o DIR [-j 2] [--returns --truth ../shared/data/cmu_like]
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
import zlib
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import kinds
import numpy as np
import outcome
import table

from gprodom.console import Progress, add_json_flag, print_json
from gprodom.errors import Error
from gprodom.lcm import EventLog
from gprodom.odometry.replay import run_replay
from gprodom.options import add_config_option
from gprodom.score.sources import read_truth

sys.path.append(str(Path(__file__).resolve().parents[1]))

from program import exit_with
from zips import log_of

BEGIN = 0.45  # of the run, where faults begin
RETURN_AT = (0.2, 0.4, 0.6)  # of the run, where a sensor goes away for --returns
RETURN_METRES = 20.0
SETTLED = (0, kinds.SECOND, 3 * kinds.SECOND)  # after it is back: the growth from then on


def read_messages(log: Path) -> list[kinds.Message]:
    """All messages of a log in the order of their arrival."""
    return [(e.timestamp, e.channel, e.data) for e in EventLog(str(log), "r")]


def write_messages(path: Path, messages: list[kinds.Message]) -> None:
    """Writes them in the order given."""
    log = EventLog(str(path), "w", overwrite=True)
    for arrival, channel, data in messages:
        log.write_event(arrival, channel, data)
    log.close()


@dataclass(frozen=True)
class Task:
    """A fault of a log, or (returns) a sensor that is away for 10 s.

    fault: its name, empty: the log as it is. share: of the run, where it begins.
    """

    log: Path
    fault: str
    draw: int = 0
    share: float = BEGIN
    returns: bool = False

    @property
    def name(self) -> str:
        """Under which its result is kept."""
        if self.returns:
            return f"return {self.fault} {self.share:g}"
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


class Runner:
    """Does tasks; copied to processes that do several at once."""

    def __init__(self, args: argparse.Namespace) -> None:
        self.folder, self.truth = args.output, args.truth
        self.configs = args.configs
        self.combinations = args.combinations

    def faults(self) -> dict[str, kinds.Fault]:
        """All there are, by name."""
        combined = [kinds.combination(seed) for seed in range(self.combinations)]
        return {fault.name: fault for fault in (*kinds.all_faults(), *combined)}

    def do(self, task: Task) -> dict[str, Any]:
        """The result of a task."""
        if task.returns:
            return self.sensor_back(task)
        truth = read_truth(task.log).trajectory

        def judge(made: Path, begin: int, end: float) -> outcome.Outcome:
            return outcome.judge(made, truth, begin, end)

        fault = self.faults()[task.fault] if task.fault else None
        try:
            return self.replay(task, fault, judge).as_dict()
        except Error as error:
            return {"ended": str(error)}

    def replay(self, task: Task, fault: kinds.Fault | None, then: Callable[..., Any]) -> Any:
        """Replays the log with the fault; `then` is given the log made, and the fault's time."""
        messages = read_messages(task.log)
        first, last = messages[0][0], messages[-1][0]
        begin = round(first + task.share * (last - first))
        seconds = 0.0
        with tempfile.TemporaryDirectory(dir=self.folder) as name:
            faulty, made = Path(name) / "in.lcmlog", Path(name) / "out.lcmlog"
            if fault is not None:
                rng = np.random.default_rng([1 + task.draw, zlib.crc32(fault.name.encode())])
                write_messages(faulty, fault.apply(messages, rng, begin))
                seconds = (last - begin) * 1e-6 if fault.seconds is None else fault.seconds
            source = faulty if fault else task.log
            run_replay(source, made, self.configs, poses_needed=False)  # silence is judged too
            return then(made, begin, begin + seconds * kinds.SECOND)

    def sensor_back(self, task: Task) -> dict[str, Any]:
        """The growth of the error after a sensor was away for 10 s."""
        with np.load(self.truth / f"{task.log.stem}.truth.npz") as data:
            known = {key: data[key] for key in data.files}
        back = 10 * kinds.SECOND

        def measure(made: Path, begin: int, _: float) -> list[list[float]]:
            poses = outcome.read_poses(made, "ODOMETRY")
            return [
                outcome.growth(poses, known, begin + back + later, RETURN_METRES).tolist()
                for later in SETTLED
            ]

        return {
            "clean": self.replay(task, None, measure),
            "faulty": self.replay(task, kinds.gone(task.fault, 10), measure),
        }


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
        if not args.returns:
            continue
        truth = args.truth / f"{log.stem}.truth.npz"
        if not truth.is_file():
            raise Error(f"{truth}: not there; name its folder with --truth")
        tasks += [
            Task(log, channel, share=share, returns=True)
            for channel in kinds.SENSORS
            for share in RETURN_AT
        ]
    return tasks


def parse() -> argparse.Namespace:
    """The command line."""
    parser = argparse.ArgumentParser(
        prog="bench/faults",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("logs", nargs="+", type=Path, metavar="SEQ", help="log or zip")
    parser.add_argument("-o", "--output", type=Path, metavar="DIR", help="default: kept nowhere")
    add_json_flag(parser)
    add_config_option(parser)
    parser.add_argument(
        "--only", action="append", metavar="TEXT", help="faults whose name holds it; repeatable"
    )
    parser.add_argument("--combinations", type=int, default=10, help="default: 10")
    parser.add_argument(
        "--draws", type=int, default=1, help="of each fault that strikes by chance (default: 1)"
    )
    parser.add_argument("--returns", action="store_true", help="sensors back after 10 s, too")
    parser.add_argument("--truth", type=Path, default=Path(), help="folder of the .truth.npz")
    parser.add_argument("-j", "--jobs", type=int, default=1, help="replays at once (default: 1)")
    return parser.parse_args()


def main() -> int:
    """Runs the command line."""
    args = parse()
    with tempfile.TemporaryDirectory(prefix="gprodom-") as name:
        args.output = args.output or Path(name)
        args.output.mkdir(parents=True, exist_ok=True)
        return run(args)


def run(args: argparse.Namespace) -> int:
    """Replays what is missing; prints all."""
    args.logs = [log_of(source, args.output) for source in args.logs]
    results, runner = Results(args.output), Runner(args)
    tasks = results.missing(tasks_of(args, runner.faults()))
    with Progress("replays", len(tasks)) as progress, ProcessPoolExecutor(args.jobs) as pool:
        doing = {pool.submit(runner.do, task): task for task in tasks}
        for done in as_completed(doing):
            results.keep(doing[done], done.result())
            progress.advance()
    text, wrong = table.of_replays(results.all)
    (args.output / "table.md").write_text(text)
    print_json(table.figures(results.all)) if args.json else print(text)
    for line in wrong:
        print(f"faults: {line}", file=sys.stderr)
    return 1 if wrong else 0


if __name__ == "__main__":
    exit_with(main)
