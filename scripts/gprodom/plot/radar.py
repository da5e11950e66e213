"""``gprodom plot radar``: a window of traces on its way to a feature matrix, and its match."""

import argparse
from dataclasses import dataclass
from typing import Any

import numpy as np

from gprodom import canvas
from gprodom.arrays import Floats, Ints
from gprodom.convert.sampling import add_sample_interval_option
from gprodom.errors import Error, UsageError
from gprodom.lcm import logs
from gprodom.lcm.antennas import choose
from gprodom.lcm.constants import constants
from gprodom.odometry.estimate import read_sensors
from gprodom.options import Subparsers, add_command, add_config_options

ROWS, COLUMNS = 50, 50  # of the feature matrix, as paper.rows and paper.columns
MIN_OVERLAP = 0.3
BEFORE = 600  # traces before the window: what background and amplitude scale are known from
SCALE_QUANTILE = 0.99

DESCRIPTION = """\
Draws a window of radar traces: B as recorded (less its mean trace), B' after details retention,
the peaks found in it, one trace with its peaks, the feature matrices S of the window and of the one
--step traces later, and the distance of the two over the shift, with its minimum. Depth is by the
wave speed.

examples:
  gprodom plot radar 1700001000-0-gates_g-cmu-gpr.zip --at 40 -o radar.png
  gprodom plot radar garage.lcmlog --at 40 --window 200 --step 20 -o radar.png
"""


@dataclass(frozen=True)
class Window:
    """B, B' (traces, samples), the peaks of each trace, S (rows, columns)."""

    raw: Floats
    kept: Floats
    peaks: list[list[Any]]
    matrix: Ints


def make_windows(
    traces: Floats, interval: float, first: int, length: int, step: int
) -> tuple[Window, Window]:
    """The window from trace `first` on and the one `step` traces later, filtered together."""
    from gprodom import gpr

    begin = max(first - BEFORE, 0)
    part = np.ascontiguousarray(traces[begin : first + length + step], np.float32)
    kept = gpr.DetailsRetention(gpr.FilterConfig()).filter(part, interval)[0]
    kept = np.nan_to_num(kept)
    peaks = gpr.PeakExtractor(gpr.PeakOptions()).extract_all(np.ascontiguousarray(kept))
    amplitudes = [abs(peak.amplitude) for row in peaks for peak in row]
    if not amplitudes:
        raise Error("no peaks are found in these traces: does the radar see the ground?")
    scale = float(np.quantile(amplitudes, SCALE_QUANTILE))
    mean = part.mean(axis=0)

    def window(start: int) -> Window:
        rows = slice(start - begin, start - begin + length)
        own = peaks[rows]
        place = [(peak.sample, i, abs(peak.amplitude)) for i, row in enumerate(own) for peak in row]
        depth, position, amplitude = (np.array(x, float) for x in zip(*place, strict=True))
        matrix = gpr.build_sfm(
            depth,
            position,
            amplitude,
            rows=ROWS,
            columns=COLUMNS,
            depth_range=float(part.shape[1]),
            length=float(length),
            amplitude_scale=scale,
        )
        return Window(part[rows] - mean, kept[rows], own, matrix)

    return window(first), window(first + step)


def radar_figure(
    one: Window, two: Window, interval: float, wave_speed: float, step: int, title: str
) -> canvas.Figure:
    """Two rows: B, B' with peaks, a trace; S, S of the later window, their distance."""
    figure, axes = canvas.new_figure(2, 3, width=12.0, height=7.0)
    deepest = one.raw.shape[1] * interval * wave_speed / 2
    extent = (0.0, float(len(one.raw)), deepest, 0.0)
    for axis, image, name in (
        (axes[0], one.raw, "B: traces less their mean"),
        (axes[1], one.kept, "B′: details, and their peaks"),
    ):
        reach = float(np.quantile(np.abs(image), 0.99)) or 1.0
        axis.imshow(image.T, aspect="auto", cmap="gray", vmin=-reach, vmax=reach, extent=extent)
        axis.set_title(name)
    metres = interval * wave_speed / 2
    points = [(i + 0.5, peak.sample * metres) for i, row in enumerate(one.peaks) for peak in row]
    axes[1].plot(*np.array(points).T, ".", color=canvas.COLOURS[1], ms=2.5)
    _draw_trace(axes[2], one, metres)
    highest = constants("sfm_t")["MAX_LEVEL"]
    for axis, window, name in (
        (axes[3], one, "S: feature matrix"),
        (axes[4], two, f"S, {step} traces later"),
    ):
        levels = axis.imshow(
            window.matrix, aspect="auto", cmap="cividis", vmin=0, vmax=highest, extent=extent
        )
        axis.set_title(name)
    figure.colorbar(levels, ax=axes[4], label="level")
    for axis in (axes[0], axes[1], axes[3], axes[4]):
        axis.grid(False)
        axis.set(xlabel="trace of the window", ylabel="depth (m)")
    _draw_match(axes[5], one, two, step)
    figure.suptitle(title)
    return figure


def _draw_trace(axis: canvas.Axes, window: Window, metres: float) -> None:
    """The middle trace of B' against depth, peaks on it."""
    middle = len(window.kept) // 2
    trace = window.kept[middle]
    axis.plot(trace, np.arange(len(trace)) * metres, color=canvas.COLOURS[0], lw=1.0)
    samples = np.array([peak.sample for peak in window.peaks[middle]])
    if samples.size:
        at = np.interp(samples, np.arange(len(trace)), trace)
        axis.plot(at, samples * metres, "o", color=canvas.COLOURS[1], ms=5, label="peak")
    axis.set(ylim=(len(trace) * metres, 0), title=f"trace {middle} of B′")
    axis.locator_params(axis="x", nbins=4)
    axis.set(xlabel="amplitude (counts)", ylabel="depth (m)")
    if samples.size:
        canvas.legend_below(axis, 1)


def _draw_match(axis: canvas.Axes, one: Window, two: Window, step: int) -> None:
    from gprodom import gpr

    match, distances = gpr.align_sfm(one.matrix, two.matrix, min_overlap=MIN_OVERLAP)
    shifts = np.arange(len(distances)) - len(distances) // 2
    axis.plot(shifts, distances, color=canvas.COLOURS[0], lw=1.2)
    said = f"shift {match.subcolumn:.2f}" + ("" if match.valid else ", not valid")
    least = distances[match.shift + len(distances) // 2]
    axis.plot([match.shift], [least], "o", color=canvas.COLOURS[1], label=said)
    expected = -step * COLUMNS / len(one.raw)
    axis.axvline(expected, color="0.6", ls="--", lw=1.0, label=f"new traces: {expected:.1f}")
    axis.set(title="distance of the two S", xlabel="shift (columns)", ylabel="1 - cosine")
    canvas.legend_below(axis, 2)


def add_parser(subjects: Subparsers) -> None:
    """Adds ``plot radar``."""
    parser = add_command(
        subjects, "radar", "traces, details, peaks, feature matrix, match", DESCRIPTION, run
    )
    parser.operand("source", "SEQ|LOG")
    parser.picture_output()
    parser.option("--at S", 20.0, "time of the window, from the first trace (default 20)")
    parser.option("--window N", 100, "traces in the window (default %(default)s)")
    parser.option("--step N", 10, "traces to the next window (default %(default)s)")
    parser.option("--wave-speed M/S", 1e8, "default %(default)g")
    parser.option("--antenna ID", int, "of several (default: the first heard)")
    add_sample_interval_option(parser)
    add_config_options(parser)


def run(args: argparse.Namespace) -> int:
    """Runs ``plot radar``."""
    log = read_sensors(args, args.source, "gpr_trace")
    radar = choose(logs.need(log, "gpr_trace"), args.antenna)
    seconds = (radar["utime"] - radar["utime"][0]) * 1e-6
    first = int(np.searchsorted(seconds, args.at))
    if args.window < 10 or args.step < 1:
        raise UsageError("--window: expected at least 10; --step: at least 1")
    if first + args.window + args.step > len(seconds):
        raise UsageError(
            f"--at {args.at:g}: the traces end {seconds[-1]:.1f} s after the first, which is too "
            f"early for {args.window + args.step} traces"
        )
    interval = float(radar["sample_interval"][0])
    one, two = make_windows(radar["samples"], interval, first, args.window, args.step)
    title = f"{args.source.name}, {args.window} traces from {args.at:g} s"
    canvas.save(radar_figure(one, two, interval, args.wave_speed, args.step, title), args.output)
    return 0
