#!/usr/bin/env python3
"""Does gprodom-replay give the same bytes as that of another commit, each with its own profiles?

Builds the commit of --base in a folder of its own (the program alone, as the present build is
built) and compares what both make of

    cmu_like     every sequence in DATA/cmu_like, with config/cmu_gpr.yaml
    sample       the sample with the settings of every method, with config/cmu_gpr.yaml and with
                 config/paper.yaml, and the solution over all data
    rough        every sequence in DATA/rough, with config/gprodom.yaml
    robots       every recording in DATA/robots that bench/recordings.py knows, with
                 config/gprodom.yaml, the mounting that gprodom calibrate mount finds, and the
                 solution over all data
    commands     the sample twice over, with save_map, reset, load_map and reset all on the way; the
                 files that are left in the state directory, too
    state        the rest of the sample, going on from a state directory that the base has written

Prints a table with the number of messages compared and, where bytes differ, of which channel and
from when on, and how far the poses of ODOMETRY and ODOMETRY_MAP are apart at most and at the end.
Exit code 1 where any differ. Without DATA its cases are left out, --only takes those whose name
holds a text; without --base the present program is compared with itself.

    bench/same_bytes.py --base v0.1.0 --data ../shared/data
    bench/same_bytes.py --short
"""

from __future__ import annotations

import argparse
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from pathlib import Path

from estimates import mount_in, mounting_setting
from gprodom import RESET_ALL, CommandName
from gprodom.config import STANDARD
from gprodom.console import Progress, format_table
from gprodom.errors import Error
from gprodom.lcm.messages import message
from gprodom.odometry.methods import METHODS
from gprodom.odometry.replay import find_program
from log_events import differences, read_events, write_events
from program import exit_with, parser_of, print_figures
from recordings import Recording, convert, recordings_of
from repeat_log import repeat
from zips import log_of

sys.path.append(str(Path(__file__).resolve().parent / "runner"))

from commits import build, sources_of

CHECKOUT = Path(__file__).resolve().parents[1]
FULL = METHODS["gprodom_full"].overrides
ROUND_S = 90.0  # from one beginning of the sample to the next, where it is repeated
COMMANDS = (  # seconds after the first message, name, argument
    (60.0, CommandName.save_map, "first"),
    (ROUND_S + 1.0, CommandName.reset, ""),  # the sample begins with a standstill
    (ROUND_S + 2.0, CommandName.load_map, "first"),
    (ROUND_S + 60.0, CommandName.save_map, "second"),
    (ROUND_S + 70.0, CommandName.reset, RESET_ALL),
)
STOPPED_S, RESUMED_S = 60.0, 61.0  # of the sample, where a run ends and the next begins


@dataclass(frozen=True)
class Side:
    """A program and the folder of the profiles that belong to it."""

    program: Path
    profiles: Path


PRESENT = Side(find_program(), CHECKOUT / "config")


@dataclass(frozen=True)
class Case:
    """A replay. keeps: with a state directory, which begins as a copy of `kept` if given. trouble:
    why there is no log."""

    name: str
    log: Path
    profile: str
    overrides: tuple[str, ...] = ()
    smoothed: bool = False
    keeps: bool = False
    kept: Path | None = None
    trouble: str = ""


@dataclass(frozen=True)
class Result:
    """Of one case. differing: what is not the same, in words; empty where all is."""

    case: str
    messages: int
    files: int
    differing: list[str]


# ---- what is replayed ----


def cut(log: Path, since_s: float, until_s: float, output: Path) -> Path:
    """The messages of `log` between two times after its first."""
    events = read_events(log)
    first = events[0][0]
    inside = (event for event in events if since_s <= (event[0] - first) * 1e-6 < until_s)
    return write_events(inside, output)


def with_commands(sample: Path, folder: Path) -> Path:
    """The sample twice over, with `COMMANDS`."""
    twice = folder / "twice.lcmlog"
    repeat(sample, twice, 2 * ROUND_S)
    events = read_events(twice)
    first = events[0][0]
    for seconds, name, argument in COMMANDS:
        command = message("command_t")()
        command.utime = first + round(seconds * 1e6)
        command.name, command.argument = name.name, argument
        events.append((command.utime, STANDARD.command, command.encode()))
    events.sort(key=lambda event: event[0])
    return write_events(events, folder / "commands.lcmlog")


def sample_cases(base: Side, folder: Path, short: bool) -> Iterator[Case]:
    """The cases on the sample; what `state` begins with is written by `base`."""
    [sequence] = (CHECKOUT / "sample").glob("*-cmu-gpr.zip")
    sample = log_of(sequence, folder)
    methods = [method for method in METHODS.values() if method.reckoned != "wheel"]
    for profile in ("cmu_gpr.yaml",) if short else ("cmu_gpr.yaml", "paper.yaml"):
        for method in methods[-1:] if short else methods:
            name = f"sample {profile.removesuffix('.yaml')} {method.name}"
            yield Case(name, sample, profile, method.overrides, smoothed=not method.reckoned)
    if not short:
        yield Case("sample paper", sample, "paper.yaml", smoothed=True)
    commands = with_commands(sample, folder)
    yield Case("commands", commands, "cmu_gpr.yaml", FULL, keeps=True)
    begun = cut(sample, 0.0, STOPPED_S, folder / "begun.lcmlog")
    run(base, Case("begun", begun, "cmu_gpr.yaml", FULL, keeps=True), folder / "begun", "base")
    rest = cut(sample, RESUMED_S, 1e9, folder / "rest.lcmlog")
    kept = folder / "begun" / "state"
    yield Case("state", rest, "cmu_gpr.yaml", FULL, keeps=True, kept=kept)


def data_cases(data: Path, folder: Path, only: Sequence[str]) -> Iterator[Case]:
    """The cases on recorded sequences."""
    like, rough = (sorted((data / name).glob("*.zip")) for name in ("cmu_like", "rough"))
    if not like or not rough:
        raise Error(f"{data}: expected sequences in its folders cmu_like and rough")
    for kind, profile, sequences in (
        ("cmu_like", "cmu_gpr.yaml", like),
        ("rough", "gprodom.yaml", rough),
    ):
        for sequence in sequences:
            name = f"{kind} {sequence.stem}"
            if is_wanted(name, only):
                yield Case(name, log_of(sequence, folder), profile)
    for name, recording in recordings_of(data / "robots").items():
        if is_wanted(f"robots {name}", only):
            yield robot_case(f"robots {name}", recording, data / "robots", folder)


def robot_case(name: str, recording: Recording, data: Path, folder: Path) -> Case:
    """Of a recording, with the mounting that is found; one that is refused tells why."""
    log = folder / f"{re.sub(r'[^a-z0-9]+', '_', name)}.lcmlog"
    try:
        convert(recording, data, log)
        settings = (mounting_setting(mount_in(log)), *recording.settings)
    except Error as error:
        return Case(name, log, "gprodom.yaml", trouble=str(error))
    return Case(name, log, "gprodom.yaml", settings, smoothed=True)


def is_wanted(name: str, only: Sequence[str]) -> bool:
    """A case of that name, if only those that hold one of the texts are."""
    return not only or any(part in name for part in only)


# ---- replays by both programs ----


def run(side: Side, case: Case, folder: Path, name: str) -> dict[str, Path]:
    """Replays; the files that were written, by what they are."""
    folder.mkdir(parents=True, exist_ok=True)
    made = {"log": folder / f"{name}.lcmlog"}
    command = [str(side.program), "-c", str(side.profiles / case.profile), str(case.log)]
    command += ["-o", str(made["log"])]
    if case.smoothed:
        made["smoothed"] = folder / f"{name}.smoothed.tum"
        command += ["--smoothed", str(made["smoothed"])]
    overrides = list(case.overrides)
    state = folder / "state"  # of the same path on both sides
    if case.keeps:
        shutil.rmtree(state, ignore_errors=True)
        state.mkdir()
        if case.kept is not None:
            shutil.copytree(case.kept, state, dirs_exist_ok=True)
        overrides.append(f"state.directory={state}")
    for override in overrides:
        command += ["--set", override]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode != 0:
        raise Error(f"{case.name}, {name}: {done.stderr.strip() or done.returncode}")
    if case.keeps:
        left = folder / f"{name}.state"
        shutil.rmtree(left, ignore_errors=True)
        shutil.copytree(state, left)
        made |= {f"state/{path.name}": path for path in sorted(left.iterdir())}
    return made


def compare(base: Side, present: Side, case: Case, folder: Path) -> Result:
    """Replays the case on both sides."""
    if case.trouble:
        return Result(case.name, 0, 0, [case.trouble])
    folder = folder / re.sub(r"\W+", "_", case.name)
    try:
        before, now = run(base, case, folder, "base"), run(present, case, folder, "present")
    except Error as error:
        return Result(case.name, 0, 0, [str(error)])
    count = len(read_events(now["log"]))
    differing = [f"{name} on one side only" for name in sorted(before.keys() ^ now.keys())]
    for name in sorted(before.keys() & now.keys()):
        if before[name].read_bytes() != now[name].read_bytes():
            differing += differences(before[name], now[name]) if name == "log" else [name]
    if not differing:  # gone, as the data of a long list would fill a disk
        shutil.rmtree(folder)
    return Result(case.name, count, len(now), differing)


# ---- the command line ----


def compare_all(base: Side, args: argparse.Namespace, folder: Path) -> list[Result]:
    """All cases, in their order."""
    cases = list(sample_cases(base, folder, args.short))
    if args.data is not None:
        cases += data_cases(args.data, folder, args.only)
    cases = [case for case in cases if is_wanted(case.name, args.only)]
    with Progress("replaying", len(cases)) as progress, ThreadPoolExecutor(args.jobs) as pool:

        def work(case: Case) -> Result:
            result = compare(base, PRESENT, case, folder)
            progress.advance()
            return result

        return list(pool.map(work, cases))


def report(results: Sequence[Result]) -> str:
    """The table and the sums."""
    rows = [
        [result.case, result.messages, result.files, "; ".join(result.differing) or "same"]
        for result in results
    ]
    wrong = sum(bool(result.differing) for result in results)
    total = sum(result.messages for result in results)
    verdict = f"{wrong} differ" if wrong else "the same"
    table = format_table(["case", "messages", "files", "bytes"], rows)
    return f"{table}\n{len(results)} cases, {total} messages: {verdict}"


def main() -> int:
    """Runs the command line."""
    parser = parser_of(__doc__, jobs=1)
    base = parser.add_mutually_exclusive_group()
    base.add_argument("--base", metavar="REV", help="commit to compare with")
    base.add_argument(
        "--base-program", type=Path, metavar="FILE", help="a gprodom-replay that is there, instead"
    )
    parser.add_argument("--data", type=Path, metavar="DIR", help="recorded sequences")
    parser.add_argument("--only", action="append", default=[], metavar="TEXT", help="some cases")
    parser.add_argument("--short", action="store_true", help="the sample by one method alone")
    parser.add_argument("-o", "--output", type=Path, metavar="DIR", help="keep what differs there")
    args = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="gprodom-") as temporary:
        folder = Path(temporary)
        if args.output is not None:
            args.output.mkdir(parents=True, exist_ok=True)
            folder = args.output.resolve()
        base_side = PRESENT
        if args.base is not None:
            other = sources_of(args.base, Path(temporary))
            build(other, ["gprodom-replay"])
            base_side = Side(other.root / "build/bin/gprodom-replay", other.root / "config")
        elif args.base_program is not None:
            base_side = replace(PRESENT, program=args.base_program)
        results = compare_all(base_side, args, folder)
    print_figures(args, [vars(result) for result in results], report(results))
    return 1 if any(result.differing for result in results) else 0


if __name__ == "__main__":
    exit_with(main)
