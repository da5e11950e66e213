"""What says how fast a radar moves: the network, a ridge regression, the coherence of gprodom."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from cells import Cell

from gprodom import gpr
from gprodom.arrays import Floats
from gprodom.learned.model import LEAST_SPACING, Network, read_record, to_spacing, widening
from gprodom.learned.windows import ROWS, WINDOW, step_at, to_rows

LAGS = (1, 2, 4, 8)
BANDS = 4
ENOUGH = 6000  # examples for the ridge regression, which has 40 weights
PENALTIES = tuple(10.0 ** np.arange(-2, 5))


@dataclass(frozen=True)
class Answers:
    """Speeds (n,), m/s, over the times `begin` to `end` (s); sigma: standard deviations."""

    begin: Floats
    end: Floats
    speed: Floats
    sigma: Floats


Rival = Callable[[Cell], Answers]


def pairs_of(cell: Cell) -> tuple[Floats, Floats, Floats, Floats, int]:
    """Windows before and after, begin and end (s) of the way between, and the step in traces: as
    the inference takes them."""
    rows, step = to_rows(cell.traces, cell.sample_interval), step_at(cell.rate)
    ends = np.arange(WINDOW + step, len(rows) + 1, step)
    before = np.array([rows[end - step - WINDOW : end - step] for end in ends])
    after = np.array([rows[end - WINDOW : end] for end in ends])
    return before, after, cell.time[ends - 1 - step], cell.time[ends - 1], step


class ByNetwork:
    """learned_sequential."""

    def __init__(self, folder: Path) -> None:
        self._network = Network(folder, "learned_sequential")
        self._widen = widening(read_record(folder), "learned_sequential")

    def __call__(self, cell: Cell) -> Answers:
        """Its answers for a drive."""
        before, after, begin, end, step = pairs_of(cell)
        spacing = to_spacing(self._network(before, after), self._widen)
        per_second = step / (end - begin)
        return Answers(begin, end, spacing.mean * per_second, spacing.sigma * per_second)


def features(before: Floats, after: Floats) -> Floats:
    """(n, k): how unlike traces some steps apart are, in bands of depth, and powers of that."""
    both = np.concatenate([before, after], 1).astype(np.float64)
    level = np.sqrt((both**2).mean(1) + 1e-12)
    near = np.abs(np.subtract.outer(np.arange(ROWS), np.arange(ROWS))) <= 4
    level = level @ (near / near.sum(0))
    before, after = before / level[:, None], after / level[:, None]
    pairs = [(after[:, :-lag], after[:, lag:]) for lag in LAGS] + [(before, after)]
    found = []
    for a, b in pairs:
        change = ((a - b) ** 2).reshape(len(a), a.shape[1], BANDS, ROWS // BANDS)
        found.append(np.log(change.mean((1, 3)) + 1e-6))
    flat = np.concatenate(found, 1)
    return np.concatenate([flat, flat**2], 1)


class ByRidge:
    """Ridge regression of the spacing's logarithm on features of coherence; trained and tuned on
    the examples of the network, in `folder`."""

    def __init__(self, folder: Path) -> None:
        parts = {}
        for part in ("train", "validate"):
            with np.load(folder / f"{part}.npz") as data:
                some = slice(None, None, max(1, len(data["spacing"]) // ENOUGH))
                windows = [data[name][some].astype(np.float32) for name in ("before", "after")]
                parts[part] = (
                    features(windows[0], windows[1]),
                    np.log(data["spacing"][some] + LEAST_SPACING),
                )
        x, y = parts["train"]
        self._mean, self._scale, self._level = x.mean(0), x.std(0) + 1e-9, float(y.mean())
        x = (x - self._mean) / self._scale
        best = np.inf
        for penalty in PENALTIES:
            weights = np.linalg.solve(
                x.T @ x + penalty * np.eye(x.shape[1]), x.T @ (y - self._level)
            )
            told = (parts["validate"][0] - self._mean) / self._scale @ weights + self._level
            error = float(np.sqrt(np.mean((told - parts["validate"][1]) ** 2)))
            if error < best:
                best, self._weights = error, weights
        self._log_sigma = float(np.log(best))

    def __call__(self, cell: Cell) -> Answers:
        """Its answers for a drive."""
        before, after, begin, end, step = pairs_of(cell)
        x = (features(before, after) - self._mean) / self._scale
        told = np.column_stack([x @ self._weights + self._level, np.full(len(x), self._log_sigma)])
        spacing = to_spacing(told)
        per_second = step / (end - begin)
        return Answers(begin, end, spacing.mean * per_second, spacing.sigma * per_second)


class ByCoherence:
    """The coherence of gprodom: decorrelation lengths, times the metres of one (`length`), with a
    relative standard deviation. Where it says that it does not know there is no answer."""

    def __init__(self, length: float = 1.0, relative: float = 0.0) -> None:
        self._length, self._relative = length, relative

    def __call__(self, cell: Cell) -> Answers:
        """Its answers for a drive."""
        nanoseconds = np.round(cell.time * 1e9).astype(np.int64) + 10**18
        traces = cell.traces.astype(np.float32)
        found = [
            ((begin - 10**18) * 1e-9, (end - 10**18) * 1e-9, lengths)
            for begin, end, lengths, valid in gpr.coherence(
                nanoseconds, traces, cell.sample_interval
            )
            if valid
        ]
        begin, end, lengths = np.array(found).reshape(-1, 3).T
        speed = self._length * lengths / np.maximum(end - begin, 1e-9)
        return Answers(begin, end, speed, self._relative * speed)


def speed_in(answers: Answers, begin: float, end: float) -> float:
    """Mean speed (m/s) of the answers that lie in a segment, by their time; NaN: none does."""
    inside = (answers.begin >= begin - 0.6) & (answers.end <= end + 0.1)
    inside &= answers.begin + answers.end > 2 * begin
    if not inside.any():
        return float("nan")
    span = (answers.end - answers.begin)[inside]
    return float(np.sum(answers.speed[inside] * span) / span.sum())
