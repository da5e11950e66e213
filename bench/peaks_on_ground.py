#!/usr/bin/env python3
"""What the peak fit finds on recorded ground, and what it buys over the envelope's maximum.

Traces go through details retention, then through the fit and through the path without it. For each
the repeatability of a peak between neighbouring traces is measured: a peak of an odd trace against
the mean of the same reflector's peaks in the two even traces beside it, which takes out the slope
of the reflector. The deviation is divided by sqrt(1.5), what independent equal errors would make
of it, and given as 1.4826 times its median; "lost" is the share of an odd trace's peaks with no
counterpart within half a period on both sides.

    bench/peaks_on_ground.py ../shared/data/real_ground/seal_beach/line_01.npz
    bench/peaks_on_ground.py ../shared/data/cmu_like/*gates_g*.zip --json
"""

from __future__ import annotations

import io
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gprodom import gpr
from program import exit_with, parser_of, print_figures, table_of
from zips import sample_interval

MAX_TRACES = 2000
REACH = 5.0  # samples: half a period of these antennas
WAYS = {
    "fit": gpr.PeakOptions(),
    "apart": gpr.PeakOptions(max_joint=1),
    "envelope": gpr.PeakOptions(fit=False),
}


def read_traces(path: Path) -> tuple[NDArray[np.float32], float]:
    """Traces (n, 201) and sample interval (s) of an .npz line or a CMU-GPR zip."""
    if path.suffix == ".npz":
        line = np.load(path)
        return line["traces"][:, :201].astype(np.float32), float(line["sample_interval"])
    with zipfile.ZipFile(path) as archive:
        name = next(n for n in archive.namelist() if n.endswith("gpr_meas.csv"))
        text = io.TextIOWrapper(archive.open(name))
        traces = np.loadtxt(text, delimiter=",", skiprows=1, max_rows=MAX_TRACES)[:, 1:]
    return traces.astype(np.float32), sample_interval(path)


def filtered(traces: NDArray[np.float32], interval: float) -> NDArray[np.float32]:
    """Moving traces after details retention, bad ones left out."""
    config = gpr.FilterConfig()
    config.band_low, config.band_high = 0.03 / interval, 0.18 / interval  # Hz, about the antenna
    out = gpr.DetailsRetention(config).filter(traces, interval)[0]
    good = np.isfinite(out).all(axis=1)
    step = np.abs(np.diff(out, axis=0, prepend=out[:1])).mean(axis=1)
    moving = step > 0.3 * np.nanmedian(step)
    return np.ascontiguousarray(out[good & moving])


def repeatability(peaks: list[list[Any]]) -> dict[str, float]:
    """Deviations of odd traces' peaks from their even neighbours' mean."""
    times, amplitudes, lost, total = [], [], 0, 0
    place = [np.array([p.sample for p in row]) for row in peaks]
    height = [np.array([p.amplitude for p in row]) for row in peaks]
    for row in range(1, len(peaks) - 1, 2):
        before, after = place[row - 1], place[row + 1]
        total += len(place[row])
        if not before.size or not after.size:
            lost += len(place[row])
            continue
        for sample, amplitude in zip(place[row], height[row], strict=True):
            i, j = np.argmin(np.abs(before - sample)), np.argmin(np.abs(after - sample))
            if max(abs(before[i] - sample), abs(after[j] - sample)) > REACH:
                lost += 1
                continue
            mean = 0.5 * (height[row - 1][i] + height[row + 1][j])
            times.append(sample - 0.5 * (before[i] + after[j]))
            amplitudes.append((amplitude - mean) / max(mean, 1e-9))
    scale = 1.4826 / np.sqrt(1.5)
    return {
        "time": float(scale * np.median(np.abs(times))),
        "time_rms": float(np.sqrt(np.mean(np.square(times)) / 1.5)),
        "amplitude": float(scale * np.median(np.abs(amplitudes))),
        "lost": lost / max(total, 1),
    }


def examine(path: Path) -> dict[str, Any]:
    """All figures of one recording."""
    traces, interval = read_traces(path)
    traces = filtered(traces, interval)
    figures: dict[str, Any] = {"recording": path.stem, "traces": len(traces)}
    for name, options in WAYS.items():
        figures[name] = repeatability(gpr.PeakExtractor(options).extract_all(traces))
    return figures


def main() -> None:
    """Prints the figures of each recording, a line for each way."""
    parser = parser_of(__doc__)
    parser.add_argument("recording", type=Path, nargs="+", help=".npz line or CMU-GPR zip")
    args = parser.parse_args()
    found = [examine(path) for path in args.recording]
    rows = [
        {"recording": figures["recording"], "way": name, **figures[name]}
        for figures in found
        for name in WAYS
    ]
    print_figures(args, found, table_of(rows))


if __name__ == "__main__":
    exit_with(main)
