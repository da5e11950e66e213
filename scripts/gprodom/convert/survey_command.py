"""``gprodom convert survey``: radar makers' files to ground for ``gprodom simulate``."""

import argparse
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from gprodom.arrays import Ints
from gprodom.console import add_json_flag, format_table, tell, warn
from gprodom.convert.sampling import add_sample_interval_option
from gprodom.convert.survey_files import (
    Line,
    channel_numbers,
    chosen,
    decide,
    mean_frequency,
    read_lines,
)
from gprodom.errors import Error, UsageError
from gprodom.ground.survey import FULL_SCALE, Survey, write_survey
from gprodom.options import Subparsers, add_command

WAVE_SPEED = 1e8  # m/s, in dry ground; a third of it in wet

DESCRIPTION = """\
Reads lines of a radar survey: Sensors & Software DT1 (with HD), GSSI DZT, MALA RD3 and RD7 (with
RAD), Impulse IPRB (with IPRH), IDS DT of one channel. Writes them as ground, over which `gprodom
simulate --ground FILE` simulates a drive of any kind that fits on a line. Several files are
parallel lines, each --aside metres to the left of the one before. They are cut to the shortest, and
must have the same spacing and sampling. Of a DZT of several channels the first is taken, or those
of --channels, each as a line of its own in the order given. Where a header contradicts itself,
--spacing or --sample-interval must decide.

examples:
  gprodom convert survey beach_0001_0.iprb -o beach.npz
  gprodom convert survey line1.DT1 line2.DT1 --aside 0.2 --samples 201 -o field.npz
  gprodom convert survey wall.dt --spacing 0.004 --sample-interval 2.34e-11 -o wall.npz
  gprodom convert survey array.dzt --channels 0,1 --aside 0.08 -o array.npz
  gprodom simulate --ground field.npz --route line --distance 40 -o 1700000000-0-field-cmu-gpr.zip
"""


def add_parser(formats: Subparsers) -> None:
    """Adds ``convert survey``."""
    parser = add_command(
        formats, "survey", "survey lines, to drive over in simulation", DESCRIPTION, run
    )
    parser.operand("files", "FILE", "survey files, one line each", nargs="+")
    parser.output("NPZ", "ground to write (npz)")
    parser.option("--aside M", 0.2, "distance from line to line (default %(default)s)")
    parser.option(
        "--channels N,..",
        channel_numbers,
        "of each file, counted from 0: antennas side by side (default 0)",
    )
    parser.option("--samples N", 0, "keep the first N samples of each trace (default all)")
    parser.option("--spacing M", float, "distance between traces, if the header is wrong")
    add_sample_interval_option(parser, "seconds between samples, if the header is wrong")
    add_json_flag(parser)


def run(args: argparse.Namespace) -> int:
    """Reads, joins and writes."""
    if not args.aside > 0:
        raise UsageError(f"--aside {args.aside:g}: expected a distance above 0")
    if args.spacing is not None and not args.spacing > 0:
        raise UsageError(f"--spacing {args.spacing:g}: expected a distance above 0")
    given = {"spacing": args.spacing, "sample_interval": args.sample_interval}
    lines = [
        decide(line, path, **given) for path in args.files for line in read(path, args.channels)
    ]
    survey = join(lines, args.output.stem, args.aside, args.samples)
    write_survey(args.output, survey)
    apart, wavelength = survey.spacing, wavelength_m(survey.lines, survey.sample_interval)
    if apart > wavelength / 4:
        warn(
            f"traces {apart:.3g} m apart at a wavelength of {wavelength:.2g} m in the ground: more "
            "than a quarter of it from trace to trace, so that motion cannot be told from them; a "
            "drive over this ground is no test of the radar"
        )
    facts = {
        "lines": survey.lines.shape[0],
        "traces": survey.lines.shape[1],
        "samples": survey.lines.shape[2],
        "spacing_m": survey.spacing,
        "length_m": survey.length,
        "sample_interval_s": survey.sample_interval,
    }
    rows = [[name, f"{value:.6g}"] for name, value in facts.items()]
    tell(args.json, facts, format_table([str(args.output), ""], rows))
    return 0


def read(path: Path, channels: Sequence[int] | None) -> list[Line]:
    """The lines of a file; None: of its first channel, and what is left out is told."""
    if channels is not None:
        return list(chosen(path, channels).values())
    lines = read_lines(path)
    if len(lines) > 1:
        warn(f"{path}: holds {len(lines)} channels; 0 is taken, --channels takes others")
    return lines[:1]


def join(lines: list[Line], name: str, aside: float, samples: int = 0) -> Survey:
    """Parallel lines as one survey, in int16."""
    first = lines[0]
    for line in lines:
        if abs(line.spacing - first.spacing) > 1e-6 * first.spacing:
            raise Error(f"lines of different spacing: {first.spacing:g} and {line.spacing:g} m")
        if abs(line.sample_interval / first.sample_interval - 1) > 1e-6:
            raise Error("lines of different sampling: convert them one by one")
    count = min(len(line.traces) for line in lines)
    wide = min(line.traces.shape[1] for line in lines)
    keep = min(samples, wide) if samples > 0 else wide
    traces = np.stack([line.traces[:count, :keep] for line in lines]).astype(np.float64)
    return Survey(
        name,
        _as_int16(traces),
        first.spacing,
        aside * np.arange(len(lines)),
        first.sample_interval,
        first.time_zero,
        closed=False,
    )


def wavelength_m(lines: Ints, sample_interval: float) -> float:
    """Wavelength of the echoes in (k, n, samples) at their mean frequency, with the wave speed of
    dry ground."""
    mean = mean_frequency(lines, sample_interval)
    return WAVE_SPEED / mean if mean > 0 else float("inf")


def _as_int16(traces: np.ndarray) -> Ints:
    """Unchanged if they fit, otherwise scaled so that all but 0.1 % (glitches) fit."""
    reach = float(np.quantile(np.abs(traces).max(axis=2), 0.999))
    scale = min(1.0, FULL_SCALE / max(reach, 1.0))
    return np.clip(np.rint(traces * scale), -32768, 32767).astype(np.int16)
