"""Measures everything, or the benches that are named, and writes figures as JSON and as a page.

    bench/run -o out/figures                    all of it
    bench/run rough robots -o out/figures       some
    bench/run --short -o out/figures            a part of each that is quick
    bench/run rough --compare HEAD~3 -o DIR     and what it was before; DIR/before has the figures
    bench/run --publish                         all of it, to bench/figures and docs/results.md
    bench/run --list                            what there is

DIR gets NAME.json for each bench. What was measured before, with the same program, data and
arguments, is taken from the cache (out/bench), so that a run that was ended goes on where it was. A
job that fails, or is not possible here, is told, and the others go on. Exit code: 0; 1 where a job
failed; 2 for bad usage.
"""

from __future__ import annotations

import argparse
import os
import sys
from dataclasses import replace
from pathlib import Path

from benches import benches
from commits import build, sources_of
from compare import changes, table
from ending import end_with_descendants_on_sigterm
from job import CHECKOUT, Bench, Job, Program, commit_of
from measure import Measurement, Settings
from page import page, with_table

from figures import Report, read_reports
from gprodom.cluster import open_executor
from gprodom.console import format_table
from gprodom.errors import Error, UsageError
from gprodom.executor import Executor
from gprodom.files import write_bytes
from gprodom.options import add_scheduler_option

FIGURES = CHECKOUT / "bench" / "figures"


def data_folder() -> Path:
    """Recorded data: beside the checkout, or named by GPRODOM_SHARED."""
    return Path(os.environ.get("GPRODOM_SHARED", CHECKOUT.parent / "shared")).resolve() / "data"


def chosen(known: tuple[Bench, ...], names: list[str]) -> list[Bench]:
    """Those of the names; all without names. NAME/JOB: that job alone."""
    if not names:
        return list(known)
    by_name = {bench.name: bench for bench in known}
    found: dict[str, Bench] = {}
    for each in names:
        name, _, job = each.partition("/")
        if name not in by_name:
            raise UsageError(f"{name}: expected some of {', '.join(by_name)}")
        bench = by_name[name]
        if job:
            jobs = tuple(one for one in bench.jobs if one.name == job)
            if not jobs:
                known_jobs = ", ".join(one.name for one in bench.jobs)
                raise UsageError(f"{each}: expected one of {known_jobs}")
            before = found[name].jobs if name in found else ()
            bench = replace(bench, jobs=before + jobs)
        found[name] = bench
    return list(found.values())


def without_data(known: tuple[Bench, ...], data: Path) -> tuple[Bench, ...]:
    """The benches and jobs that need no recorded data, which are not there."""
    print(f"no recorded data in {data}: what needs them is left out", file=sys.stderr)

    def needs_none(job: Job) -> bool:
        return not any("{data}" in path for path in job.data)

    rest = [replace(each, jobs=tuple(filter(needs_none, each.jobs))) for each in known]
    return tuple(each for each in rest if each.jobs)


def describe(known: tuple[Bench, ...]) -> str:
    """The table of --list."""
    lines = [
        [each.name, len(each.jobs), sum(bool(job.short) for job in each.jobs), each.title]
        for each in known
    ]
    return format_table(["bench", "jobs", "in --short", "what"], lines)


def summary(reports: list[Report]) -> str:
    """How much was measured of each."""
    lines = []
    for report in reports:
        seconds = sum(job.seconds for job in report.jobs)
        lines.append([report.name, len(report.jobs), len(report.figures()), f"{seconds:.0f}"])
    return format_table(["bench", "jobs", "figures", "seconds"], lines)


def figures_table(report: Report) -> str:
    """All figures of a bench."""
    lines = [
        [each.name, each.value, each.unit, "" if each.spread is None else f"+- {each.spread:.2g}"]
        for each in report.figures().values()
    ]
    return format_table([report.name, "", "", ""], lines)


def parse() -> argparse.Namespace:
    """The command line."""
    parser = argparse.ArgumentParser(
        prog="bench/run",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("names", metavar="NAME", nargs="*", help="bench, or BENCH/JOB")
    parser.add_argument("-o", "--output", type=Path, metavar="DIR", help="folder for the figures")
    parser.add_argument("--short", action="store_true", help="what is quick of each")
    parser.add_argument("--list", action="store_true", help="the benches that there are")
    parser.add_argument(
        "-j", "--jobs", type=int, default=os.cpu_count() or 1, metavar="N", help="at once"
    )
    parser.add_argument(
        "--compare", metavar="COMMIT",
        help="measure this commit too (built in the cache), or read the figures of this folder, "
        "and print what differs beyond its noise",
    )  # fmt: skip
    add_scheduler_option(parser)
    parser.add_argument(
        "--set", action="append", default=[], metavar="KEY=VALUE", dest="overrides",
        help="a setting of the estimator, in all that take one; may be repeated",
    )  # fmt: skip
    parser.add_argument(
        "--cache", type=Path, default=CHECKOUT / "out" / "bench", metavar="DIR",
        help="what was measured before (default: out/bench of the checkout)",
    )  # fmt: skip
    parser.add_argument("--fresh", action="store_true", help="measure anew what is in the cache")
    parser.add_argument(
        "--publish", action="store_true",
        help="write the figures to bench/figures of the checkout, and from all that are there "
        "docs/results.md and the table in README.md",
    )  # fmt: skip
    args = parser.parse_args()
    if args.publish:
        if args.short or args.overrides or args.output is not None:
            parser.error("--publish takes whole benches as they are: no --short, --set or -o")
        args.output = FIGURES
    if args.output is None and not args.list:
        parser.error("-o DIR is needed, or --publish")
    if args.jobs < 1:
        parser.error(f"-j {args.jobs}: expected at least 1")
    return args


def measure_before(
    args: argparse.Namespace, wanted: list[Bench], settings: Settings, executor: Executor
) -> list[Report]:
    """The figures to compare with: of a folder, or of another commit, measured by these benches."""
    folder = Path(args.compare)
    if folder.is_dir():
        kept = read_reports(folder)
        if not kept:
            raise UsageError(f"--compare {folder}: no figures in it")
        return [kept[bench.name] for bench in wanted if bench.name in kept]
    program = sources_of(args.compare, args.cache / "commits")
    targets = ["programs", *(["benches"] if any(bench.compiled for bench in wanted) else [])]
    measurement = Measurement(program, settings, executor, lambda: build(program, targets))
    reports = measurement.of(wanted)
    (args.output / "before").mkdir(exist_ok=True)
    for report in reports:
        report.save(args.output / "before")
    return reports


def publish() -> None:
    """Writes docs/results.md and the table of README.md from the figures of the checkout."""
    reports = read_reports(FIGURES)
    write_bytes(CHECKOUT / "docs" / "results.md", page(reports).encode())
    readme = CHECKOUT / "README.md"
    write_bytes(readme, with_table(readme.read_text(encoding="utf-8"), reports).encode())


def run(args: argparse.Namespace) -> int:
    """Measures."""
    data = data_folder()
    known = benches(data)
    if not data.is_dir():
        known = without_data(known, data)
    if args.list:
        print(describe(known))
        return 0
    wanted = chosen(known, args.names)
    settings = Settings(data, args.cache, args.short, tuple(args.overrides), args.fresh)
    program = Program(CHECKOUT, commit_of(CHECKOUT))
    args.output.mkdir(parents=True, exist_ok=True)
    with open_executor(args.jobs, args.scheduler) as executor:
        before = None if args.compare is None else measure_before(args, wanted, settings, executor)
        reports = Measurement(program, settings, executor).of(wanted)
    for report in reports:
        report.save(args.output)
        if args.names:
            print(figures_table(report), end="\n\n")
    if args.publish:
        publish()
    print(summary(reports))
    if before is not None:
        found = changes(before, reports)
        compared = sum(len(report.figures()) for report in reports)
        print("", table(found, compared), sep="\n")
    failed = [(each.name, *what) for each in reports for what in each.failed.items()]
    for bench, job, why in failed:
        print(f"failed: {bench}/{job}: {why}", file=sys.stderr)
    return 1 if failed else 0


def main() -> int:
    """Runs the command line."""
    args = parse()
    end_with_descendants_on_sigterm()
    try:
        return run(args)
    except KeyboardInterrupt:
        print("bench/run: ended; what was measured is kept", file=sys.stderr)
        return 130
    except UsageError as error:
        print(f"bench/run: error: {error}", file=sys.stderr)
        return 2
    except Error as error:
        print(f"bench/run: error: {error}", file=sys.stderr)
        return 1


if __name__ == "__main__":
    sys.exit(main())
