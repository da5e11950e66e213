"""The figures of the factorial test, and its tables."""

from __future__ import annotations

from typing import Any

import numpy as np
from cells import RATES, SPEEDS

from gprodom.arrays import Floats
from pairs import CONSECUTIVE, REVISIT, Offsets
from program import table_of

RESAMPLES = 2000


def beyond(reference: Floats, true: Floats, told: Floats) -> float:
    """R2 of `told` beyond the best affine function of `reference`; where nothing is told (NaN) that
    function's value is taken."""
    slope = np.column_stack([reference, np.ones_like(reference)])
    simple = slope @ np.linalg.lstsq(slope, true, rcond=None)[0]
    told = np.where(np.isfinite(told), told, simple)
    return float(1 - np.sum((true - told) ** 2) / np.sum((true - simple) ** 2))


def interval(reference: list[Floats], true: list[Floats], told: list[Floats]) -> list[float]:
    """R2 beyond, and its 95 % interval from resampled grounds."""
    random = np.random.RandomState(0)

    def of(chosen: Any) -> float:
        parts = [np.concatenate([x[i] for i in chosen]) for x in (reference, true, told)]
        return beyond(*parts)

    drawn = [of(random.randint(len(true), size=len(true))) for _ in range(RESAMPLES)]
    low, high = np.percentile(drawn, [2.5, 97.5])
    return [of(range(len(true))), float(low), float(high)]


def _figures(name: str, results: list[Any], scaled: bool) -> dict[str, Any]:
    rows = {
        kind: [np.array(each[name].rows[kind], float) for each in results]
        for kind in results[0][name].rows
    }
    scales = [each[name].scale if scaled else 1.0 for each in results]

    def parts(kind: str) -> tuple[list[Floats], list[Floats], list[Floats]]:
        counts = [each[:, 1] for each in rows[kind]]  # traces over a fixed time
        told = [scale * each[:, 3] for scale, each in zip(scales, rows[kind], strict=True)]
        return counts, [each[:, 2] for each in rows[kind]], told

    every = np.concatenate(rows["driven"])
    told = np.concatenate(parts("driven")[2])
    cells = {
        f"{rate:g}": [_relative(every, told, speed, rate) for speed in SPEEDS] for rate in RATES
    }
    shuffled = np.concatenate(parts("shuffled")[2])
    standing = np.concatenate(parts("standing")[2])
    normal = np.concatenate([each[name].normal for each in results])
    return {
        "method": name + (", scaled" if scaled else ""),
        "r2": interval(*parts("driven")),
        "r2_shuffled": interval(*parts("shuffled"))[0],
        "valid": float(np.isfinite(told).mean()),
        "nees": float(np.mean(normal**2)) if scaled else float("nan"),
        "in_2_sigma": float(np.mean(np.abs(normal) < 2)) if scaled else float("nan"),
        "standing_mps": float(np.nansum(standing) / (4.0 * len(standing))),
        "shuffled_over": float(np.nanmean(shuffled) / np.nanmean(told)),
        "relative_error": cells,
    }


def _relative(rows: Floats, told: Floats, speed: float, rate: float) -> float:
    """Mean relative error of one speed and rate."""
    at = (rows[:, 0] == speed) & (rows[:, 1] == rate) & np.isfinite(told)
    return float(np.mean(np.abs(told[at] / rows[at, 2] - 1))) if at.any() else float("nan")


def _of_pairs(offsets: list[list[Offsets]], kind: str) -> dict[str, Any]:
    grounds = [[each for each in ground if each.kind == kind] for ground in offsets]

    def parts(name: str) -> list[Floats]:
        return [np.concatenate([getattr(each, name) for each in ground]) for ground in grounds]

    true, told, wheel, sigma = (
        np.concatenate(parts(n)) for n in ("true", "told", "wheel", "sigma")
    )
    same = np.concatenate(parts("same"))
    far = np.abs(true) > 0.1
    slope = np.polyfit((wheel / true)[far], np.clip(told / true, -1, 3)[far], 1)[0]
    at_one = [np.full(len(each.true), each.scale == 1.0) for ground in grounds for each in ground]
    at_one = np.concatenate(at_one)
    error = told - true
    return {
        "pairs": kind,
        "follows": float(slope),
        "r2_beyond_wheel": interval(parts("wheel"), parts("true"), parts("told")),
        "median_mm": 1e3 * float(np.median(np.abs(error[at_one]))),
        "nees": float(np.mean((error / sigma)[at_one] ** 2)),
        "same": float(np.mean(same[at_one] > 0.5)),
    }


def with_interval(row: dict[str, Any]) -> dict[str, Any]:
    """A row for people: R2 with its interval in one column."""
    shown = {}
    for key, value in row.items():
        is_r2 = key.startswith("r2") and isinstance(value, list)
        shown[key] = "{:.3f} ({:.3f} to {:.3f})".format(*value) if is_r2 else value
    return shown


def tables(results: list[Any], offsets: list[list[Offsets]]) -> tuple[dict[str, Any], str]:
    """All figures, and them as text."""
    ways = [_figures(name, results, scaled) for name in results[0] for scaled in (False, True)]
    seen = [_of_pairs(offsets, kind) for kind in (CONSECUTIVE, REVISIT)]
    columns = [[with_interval(each) for each in some] for some in (ways, seen)]
    text = table_of([{k: v for k, v in w.items() if k != "relative_error"} for w in columns[0]])
    for way in ways:
        errors = [
            {"traces/s": rate} | dict(zip((f"{s:g} m/s" for s in SPEEDS), each, strict=True))
            for rate, each in way["relative_error"].items()
        ]
        text += f"\n\n{way['method']}: mean relative error\n{table_of(errors)}"
    return {"ways": ways, "pairs": seen}, f"{text}\n\n{table_of(columns[1])}"
