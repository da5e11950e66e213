"""``gprodom commission``."""

from __future__ import annotations

import argparse
import sys
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gprodom.commission.parameter import CIRCLES, STAND, STARTS, STRAIGHT
from gprodom.config import Channels, read_channels
from gprodom.console import Progress, format_table, print_json
from gprodom.convert.sampling import add_sample_interval_option
from gprodom.errors import Error, UsageError
from gprodom.files import OutputFile, replacing, temporary_folder, write_text
from gprodom.lcm import DEFAULT_URL, connect, logs
from gprodom.options import Subparsers, add_command
from gprodom.trajectory import Trajectory

if TYPE_CHECKING:
    from gprodom.commission.compare import Comparison
    from gprodom.commission.find import Commission

DESCRIPTION = f"""\
Finds the constants of a new robot in one recording: mounting of the IMU, time offsets, the wheel's
scale, the track, the noise of the IMU, band and gain of the radar, the fastest speed for its trace
rate, and the antenna's lever arm. Each has its standard deviation; what the recording does not show
is told with the manoeuvre that would show it. With -o all settings are written as one configuration
for -c, those of before with what was found; with --page, a page is. The drive is replayed with the
configuration of before and with the new one, and both are compared with the recorded positions, or,
where there are none, with wheel and gyro alone.

Any drive does. This one of some minutes shows everything:
  1. {STAND};
  2. {STRAIGHT}: its
     length is --stretch, and no other straight piece may be longer;
  3. {STARTS};
  4. {CIRCLES};
  5. drive the 10 m back.

--live records a running robot into the file of --record and says what to do next, in these steps,
by its wheel and its gyro; then it goes on with that file. Enter leaves a step, done or not; Ctrl-C
ends the recording.

examples:
  gprodom commission drive.lcmlog --stretch 10 -o robot.yaml --page robot.html
  gprodom commission drive.lcmlog -c robot.yaml --set wheel.drive=differential -o robot2.yaml
  gprodom commission drive.lcmlog --no-replay --json
  gprodom commission --live --record drive.lcmlog --stretch 10 -o robot.yaml
"""


def add_parser(subparsers: Subparsers) -> None:
    """Adds ``commission``."""
    parser = add_command(
        subparsers, "commission", "the configuration of a new robot", DESCRIPTION, run
    )
    parser.operand("source", "LOG|SEQ", nargs="?")
    parser.flag("--live", "guide a drive, and record it")
    parser.option("--record LOG", OutputFile, "what --live records; kept")
    parser.option("--lcm-url URL", DEFAULT_URL, "with --live (default %(default)s)")
    parser.output("YAML", "configuration to write", required=False)
    parser.option("--page HTML", OutputFile, "page to write")
    parser.option(
        "--stretch M",
        float,
        "length by tape of the longest straight piece from a standstill to a standstill",
    )
    parser.flag(
        "--fit-truth", "the wheel's scale from the recorded positions, as gprodom calibrate wheel"
    )
    parser.flag("--no-replay", "compare no replays")
    add_sample_interval_option(parser)
    parser.common_options()


def run(args: argparse.Namespace) -> int:
    """Finds, writes, compares, tells."""
    from gprodom.commission.find import commission
    from gprodom.odometry.dead_reckoning import has_wheel
    from gprodom.odometry.estimate import as_log
    from gprodom.odometry.settings import printed_settings, read_settings
    from gprodom.score.sources import known_truth

    _check(args)
    channels = read_channels(args.configs, args.overrides)
    settings = read_settings(args.configs, args.overrides)
    if args.live:
        args.source = _record(args, channels)
    with temporary_folder() as folder:
        log = as_log(args.source, folder, args.sample_interval, channels)
        sensors = logs.read_roles(log, channels.of("imu", "wheel", "gpr_trace"))
        if "imu" not in sensors or not has_wheel(sensors):
            raise Error(f"{args.source}: needs IMU and wheel ({channels.imu}, {channels.wheel})")
        truth = known_truth(log)
        if args.fit_truth and truth is None:
            raise UsageError("--fit-truth: the recording has no positions; say --stretch M")
        found = commission(sensors, settings, args.stretch, truth if args.fit_truth else None)
        text = printed_settings(args.configs, [*args.overrides, *found.settings])
        written = folder / "found.yaml"
        written.write_text(_told(args.source, found) + text, encoding="utf-8")
        if args.output is not None:
            write_text(args.output, written.read_text(encoding="utf-8"))
        comparison = None
        if not args.no_replay:
            comparison = _compare(args, log, sensors, found, written, truth, folder)
    if args.page is not None:
        from gprodom.commission.page import write_html

        write_text(args.page, write_html(args.source.stem, found, comparison))
    _print(args, found, comparison)
    return 0


def _record(args: argparse.Namespace, channels: Channels) -> Path:
    """The recording of a guided drive."""
    from gprodom.commission.live import record

    at_terminal = sys.stderr.isatty()

    def show(text: str) -> None:
        print(f"\r\x1b[2K{text}" if at_terminal else text, end="" if at_terminal else "\n",
              file=sys.stderr, flush=True)  # fmt: skip

    with replacing(args.record) as part:
        guide = record(connect(args.lcm_url), part, channels, show)
    ended = "" if guide.done else f", ended in step {guide.step + 1}"
    print(f"\n{args.record}: recorded{ended}", file=sys.stderr)
    return Path(args.record)


def _check(args: argparse.Namespace) -> None:
    if (args.source is None) != args.live:
        raise UsageError("give either a LOG or --live")
    if args.live != (args.record is not None):
        raise UsageError("--live and --record LOG go together")
    if args.stretch is not None and not 1 <= args.stretch <= 1000:
        raise UsageError(f"--stretch {args.stretch:g}: expected 1 to 1000 m")
    if args.stretch is not None and args.fit_truth:
        raise UsageError("--stretch and --fit-truth: expected one of them")


def _compare(
    args: argparse.Namespace,
    log: Path,
    sensors: dict[str, Any],
    found: Commission,
    written: Path,
    truth: Trajectory | None,
    folder: Path,
) -> Comparison:
    from gprodom.commission.compare import compare_drives, methods_of

    before, after = (args.configs, args.overrides), ((written,), ())
    with Progress("replaying", 2 * len(methods_of(sensors))) as progress:
        return compare_drives(
            log, sensors, found.sensors, before, after, truth, folder, progress.advance
        )


def _told(source: Path, found: Commission) -> str:
    """What was found, as comments above the configuration."""
    from gprodom.commission.page import in_words

    lines = [f"# Found by gprodom commission in {source.name}, ± one standard deviation:"]
    for each in found.parameters:
        keys = ", ".join(setting.partition("=")[0] for setting in each.settings)
        what = in_words(each) if each.value else "not shown"
        lines.append(f"#   {each.name}: {what}" + (f" -> {keys}" if keys else ""))
    return "\n".join(lines) + "\n\n"


def _print(args: argparse.Namespace, found: Commission, comparison: Comparison | None) -> None:
    from gprodom.commission import page

    if args.json:
        ways = [] if comparison is None else comparison.ways
        print_json(
            {
                "parameters": [asdict(each) for each in found.parameters],
                "findings": [asdict(each) for each in found.findings],
                "settings": found.settings,
                "of_truth": comparison is not None and comparison.of_truth,
                "ways": [{"name": w.name, "error_m": w.error_m, "why": w.why} for w in ways],
            }
        )
        return
    for each in found.parameters:
        text = page.in_words(each) if each.value else "not shown"
        mark = "written" if each.settings else "not written"
        print(f"{each.name}: {text}" + (f" ({mark})" if each.value else ""))
        for more in (each.remark, each.manoeuvre and f"to show it: {each.manoeuvre}"):
            if more:
                print(f"    {more}")
    for finding in found.findings:
        print(f"{finding.code}: {finding.what}\n    mend: {finding.mend}")
    if comparison is not None:
        print(f"\nRMS distance {page.reference_name(comparison)}:")
        rows = [[name, error, why] for name, error, why in page.errors_of(comparison)]
        print(format_table(["way", "m", ""], rows))
