"""What the networks are given: windows of traces in time, and images along a track.

The traces' samples are averaged onto a grid of `ROWS` rows and freed from wow, the slow offset that
a receiver adds to each trace anew. There is no other processing and no statistic of any data set:
the networks normalise each input by itself.
"""

import numpy as np

from gprodom.arrays import Floats
from gprodom.ground.laid import columns_at

ROWS = 64
ROW_TIME = 6e-10  # s
FULL_SCALE = 32768.0  # counts
WOW_ROWS = 13  # whose running mean is the wow: some 8 ns, four periods of the wavelet

WINDOW = 16  # traces of a window of learned_sequential
STEP_S = 0.5  # s from a window to the next, within the limits in traces
LEAST_STEP, MOST_STEP = 4, 16

COLUMNS, COLUMN = 64, 0.02  # of an image of learned_pair; m
LENGTH = COLUMNS * COLUMN  # m


def to_rows(traces: Floats, sample_interval: float) -> Floats:
    """Traces (n, samples), counts, as (n, ROWS) float32 between -1 and 1, without wow."""
    return without_wow(on_rows(traces, sample_interval), 1)


def without_wow(rows: Floats, axis: int) -> Floats:
    """Rows, which run along that axis, less their running mean."""
    from scipy.ndimage import uniform_filter1d

    return np.asarray(rows - uniform_filter1d(rows, WOW_ROWS, axis=axis, mode="nearest"))


def on_rows(traces: Floats, sample_interval: float) -> Floats:
    """The means of the samples of each row, float32, parts of full scale."""
    n, samples = traces.shape
    total = np.zeros((n, samples + 1))
    np.cumsum(traces, axis=1, out=total[:, 1:])
    edges = np.clip(np.arange(ROWS + 1) * (ROW_TIME / sample_interval), 0, samples)
    index = np.minimum(edges.astype(np.int64), samples - 1)
    part = edges - index
    at = total[:, index] * (1 - part) + total[:, index + 1] * part
    width = np.maximum(np.diff(edges), 1e-9)
    return np.asarray(np.diff(at, axis=1) / width / FULL_SCALE, np.float32)


def step_at(rate: float) -> int:
    """Traces from a window to the next where `rate` traces come in a second."""
    return int(np.clip(round(STEP_S * rate), LEAST_STEP, MOST_STEP))


def image(rows: Floats, along: Floats, first: float) -> Floats:
    """(ROWS, COLUMNS): the traces `rows` (n, ROWS) at the places `along` (n,), m, ascending,
    interpolated from `first` (m) on."""
    wanted = first + COLUMN * (0.5 + np.arange(COLUMNS))
    return np.ascontiguousarray(columns_at(wanted, rows, along).T)
