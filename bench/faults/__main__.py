"""The fault bench: sequences replayed with one fault at a time, and what came of it.

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
import zlib
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import kinds
import numpy as np
import outcome
import table

from gprodom.console import Progress
from gprodom.errors import Error
from gprodom.lcm import EventLog
from gprodom.replay import default_config, run_replay
from gprodom.score.sources import read_truth

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


def name_of(fault: kinds.Fault | None, draw: int) -> str:
    """Under which a result is kept."""
    name = fault.name if fault else "clean"
    return f"{name}{table.DRAW}{draw}" if draw else name


class Bench:
    """Replays, and the results kept in a folder."""

    def __init__(self, folder: Path, config: Path) -> None:
        self.folder, self.config = folder, config
        folder.mkdir(parents=True, exist_ok=True)
        self._file = folder / "results.jsonl"
        self.results: dict[tuple[str, str], dict[str, Any]] = {}
        if self._file.exists():
            for line in self._file.read_text().splitlines():
                result = json.loads(line)
                self.results[result["log"], result["fault"]] = result

    def keep(self, log: str, fault: str, result: dict[str, Any]) -> None:
        """Adds a result, in memory and on disk."""
        result = {"log": log, "fault": fault, **result}
        self.results[log, fault] = result
        with self._file.open("a") as file:
            file.write(json.dumps(result) + "\n")

    def replay(
        self,
        log: Path,
        fault: kinds.Fault | None,
        begin_share: float,
        then: Callable[..., Any],
        draw: int = 0,
    ) -> Any:
        """Replays the log with the fault; `then` is given the log made, and the fault's time."""
        messages = read_messages(log)
        first, last = messages[0][0], messages[-1][0]
        begin = round(first + begin_share * (last - first))
        name = f"{log.stem}-{zlib.crc32((fault.name if fault else '').encode()):08x}"
        name += f"-{begin_share:g}-{draw}"
        faulty, made = self.folder / f"{name}.in.lcmlog", self.folder / f"{name}.out.lcmlog"
        seconds = 0.0
        try:
            if fault is not None:
                rng = np.random.default_rng([1 + draw, zlib.crc32(fault.name.encode())])
                write_messages(faulty, fault.apply(messages, rng, begin))
                seconds = (last - begin) * 1e-6 if fault.seconds is None else fault.seconds
            run_replay(faulty if fault else log, made, self.config)
            return then(made, begin, begin + seconds * kinds.SECOND)
        finally:
            faulty.unlink(missing_ok=True)
            made.unlink(missing_ok=True)

    def one(self, log: Path, fault: kinds.Fault | None, draw: int = 0) -> None:
        """One log, one fault (None: as it is)."""
        truth = read_truth(log).trajectory

        def judge(made: Path, begin: int, end: float) -> outcome.Outcome:
            return outcome.judge(made, truth, begin, end)

        try:
            result = self.replay(log, fault, BEGIN, judge, draw).as_dict()
        except Error as error:
            result = {"ended": str(error)}
        self.keep(log.stem, name_of(fault, draw), result)

    def sensor_back(self, log: Path, truth: Path, channel: str, share: float) -> None:
        """The growth of the error after a sensor was away for 10 s."""
        with np.load(truth) as data:
            known = {key: data[key] for key in data.files}
        fault = kinds.gone(channel, 10)
        back = 10 * kinds.SECOND

        def measure(made: Path, begin: int, _: float) -> list[list[float]]:
            poses = outcome.read_poses(made, "ODOMETRY")
            return [
                outcome.growth(poses, known, begin + back + later, RETURN_METRES).tolist()
                for later in SETTLED
            ]

        result = {
            "clean": self.replay(log, None, share, measure),
            "faulty": self.replay(log, fault, share, measure),
        }
        self.keep(log.stem, f"return {channel} {share:g}", result)


def work_of(bench: Bench, args: argparse.Namespace) -> list[tuple[str, str, Callable[[], None]]]:
    """What is to be done: log, name and how."""
    work: list[tuple[str, str, Callable[[], None]]] = []
    faults: list[kinds.Fault | None] = [None]
    faults += [
        f for f in kinds.all_faults() if not args.only or any(o in f.name for o in args.only)
    ]
    faults += [kinds.combination(seed) for seed in range(args.combinations)]
    for log in args.logs:
        for fault in faults:
            for draw in range(args.draws if fault and fault.by_chance else 1):
                work.append(
                    (
                        log.stem,
                        name_of(fault, draw),
                        lambda log=log, fault=fault, draw=draw: bench.one(log, fault, draw),
                    )
                )
        if not args.returns:
            continue
        truth = args.truth / f"{log.stem}.truth.npz"
        if not truth.is_file():
            raise Error(f"{truth}: not there; name its folder with --truth")
        for channel in kinds.SENSORS:
            for share in RETURN_AT:
                work.append(
                    (
                        log.stem,
                        f"return {channel} {share:g}",
                        lambda log=log, truth=truth, channel=channel, share=share: (
                            bench.sensor_back(log, truth, channel, share)
                        ),
                    )
                )
    return work


def parse() -> argparse.Namespace:
    """The command line."""
    parser = argparse.ArgumentParser(
        prog="bench/faults",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("logs", nargs="+", type=Path, metavar="LOG.lcmlog")
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="DIR")
    parser.add_argument("-c", "--config", type=Path, help="default: gprodom.yaml")
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
    try:
        bench = Bench(args.output, args.config or default_config())
        work = [item for item in work_of(bench, args) if item[:2] not in bench.results]
        with Progress("replays", len(work)) as progress, ThreadPoolExecutor(args.jobs) as pool:
            for done in [pool.submit(do) for _, _, do in work]:
                done.result()
                progress.advance()
    except Error as error:
        print(f"faults: error: {error}", file=sys.stderr)
        return 1
    text, wrong = table.of_replays(bench.results)
    (args.output / "table.md").write_text(text)
    print(text)
    for line in wrong:
        print(f"faults: {line}", file=sys.stderr)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
