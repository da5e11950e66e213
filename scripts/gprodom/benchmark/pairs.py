"""Compares methods on the same sequences: paired differences with bootstrap intervals."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from gprodom.benchmark.jobs import CAUSAL
from gprodom.score.record import Record

RESAMPLES = 10_000
CONFIDENCE = 0.95
MIN_SEQUENCES = 5  # fewer say nothing


@dataclass(frozen=True)
class Pair:
    """ate_rmse_m of `method` less that of `other`, over the sequences that both were scored on.

    low, high: 95 % interval of the mean difference, by the percentile bootstrap over sequences.
    better: share of the sequences on which `method` had the smaller error.
    """

    method: str
    other: str
    n: int
    mean_m: float
    low_m: float
    high_m: float
    better: float

    @property
    def verdict(self) -> str:
        """The conclusion of the comparison, in words."""
        if self.high_m < 0:
            return f"{self.method} better"
        if self.low_m > 0:
            return f"{self.other} better"
        return "no difference shown"


def compare_methods(records: Sequence[Record]) -> list[Pair]:
    """Every two methods, causal, that share at least `MIN_SEQUENCES` sequences."""
    errors: dict[str, dict[str, float]] = {}
    for record in records:
        if record.mode == CAUSAL:
            errors.setdefault(record.method, {})[record.sequence] = record.ate_rmse_m
    pairs = []
    for first, second in combinations(errors, 2):
        shared = sorted(errors[first].keys() & errors[second].keys())
        if len(shared) >= MIN_SEQUENCES:
            difference = [errors[first][name] - errors[second][name] for name in shared]
            pairs.append(_pair(first, second, np.array(difference)))
    return pairs


def _pair(method: str, other: str, difference: np.ndarray) -> Pair:
    low, high = interval(difference)
    return Pair(
        method,
        other,
        len(difference),
        float(difference.mean()),
        low,
        high,
        float(np.mean(difference < 0)),
    )


def interval(values: np.ndarray) -> tuple[float, float]:
    """Of the mean of `values` (n,), `CONFIDENCE`; the same values give the same interval."""
    random = np.random.RandomState(0)
    picked = random.randint(len(values), size=(RESAMPLES, len(values)))
    means = values[picked].mean(axis=1)
    tail = 50 * (1 - CONFIDENCE)
    low, high = np.percentile(means, [tail, 100 - tail])
    return float(low), float(high)


def pair_cells(pairs: Sequence[Pair]) -> tuple[list[str], list[list[object]]]:
    """Header and rows of the table."""
    header = ["method", "against", "sequences", "mean difference (m)", "95 % from", "to", "verdict"]
    rows: list[list[object]] = [
        [p.method, p.other, p.n, p.mean_m, p.low_m, p.high_m, p.verdict] for p in pairs
    ]
    return header, rows
