"""The same methods on recorded drives: speeds of 4 s in which the robot drives throughout."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from cells import SEGMENT_S, Cell
from rivals import Answers, Rival, speed_in
from table import interval, with_interval

from gprodom.arrays import Floats
from gprodom.benchmark.motion import Truth, read_beside
from gprodom.convert.cmu import read_recording
from program import table_of

DRIVES = 0.05  # m/s, at least, all the while
LEARNT_M = 5.0  # of the way, that a scale is learnt on; not scored


def measure(sequence: Path, rivals: dict[str, Rival]) -> dict[str, Floats]:
    """By method: rows of true way, told way, and told way scaled by what the first metres say (m);
    and of the single answers, error over standard deviation, under the name with /."""
    truth, interval_s = read_beside(sequence)
    recording = read_recording(sequence)
    time = recording.gpr_utime * 1e-6
    rate = 1 / float(np.median(np.diff(time)))
    begin = time[0]
    cell = Cell(0, "driven", 0.0, rate, time - begin, recording.traces, interval_s)
    path = truth.path(time)
    learnt = float(np.interp(path[0] + LEARNT_M, path, time))
    found = {}
    for name, rival in rivals.items():
        answers = rival(cell)
        scale = _scale(answers, truth, begin, learnt)
        rows = []
        for start in np.arange(learnt, time[-1] - SEGMENT_S, SEGMENT_S):
            if _slowest(truth, start, start + SEGMENT_S) < DRIVES:
                continue
            told = speed_in(answers, start - begin, start + SEGMENT_S - begin) * SEGMENT_S
            moved = float(np.diff(truth.path(np.array([start, start + SEGMENT_S])))[0])
            rows.append((moved, told, scale * told))
        found[name] = np.array(rows).reshape(-1, 3)
        found[f"{name}/"] = _normal(answers, truth, begin, learnt, scale)
    return found


def _ways(answers: Answers, truth: Truth, begin: float) -> tuple[Floats, Floats]:
    """True and told way of each answer, m."""
    true = truth.path(answers.end + begin) - truth.path(answers.begin + begin)
    return true, answers.speed * (answers.end - answers.begin)


def _scale(answers: Answers, truth: Truth, begin: float, learnt: float) -> float:
    true, told = _ways(answers, truth, begin)
    first = (answers.end + begin < learnt) & (true > DRIVES * (answers.end - answers.begin))
    return float(true[first].sum() / told[first].sum()) if first.any() else 1.0


def _normal(answers: Answers, truth: Truth, begin: float, learnt: float, scale: float) -> Floats:
    true, told = _ways(answers, truth, begin)
    span = answers.end - answers.begin
    used = (answers.begin + begin > learnt) & (true > DRIVES * span)
    sigma = np.maximum(scale * answers.sigma * span, 1e-6)
    return np.asarray(((scale * told - true) / sigma)[used])


def _slowest(truth: Truth, begin: float, end: float) -> float:
    """m/s, over any fifth of a second."""
    path = truth.path(np.arange(begin, end, 0.2))
    return float(np.diff(path).min() / 0.2)


def tables(found: list[dict[str, Floats]]) -> tuple[list[dict[str, Any]], str]:
    """R2 of the way (counting is constant where the rate is), resampled by sequence."""
    figures: list[dict[str, Any]] = []
    for name in [name for name in found[0] if not name.endswith("/")]:
        rows = [each[name] for each in found if len(each[name])]
        true = [each[:, 0] for each in rows]
        normal = np.concatenate([each[f"{name}/"] for each in found])
        for column, label in ((1, name), (2, f"{name}, scaled")):
            told = [each[:, column] for each in rows]
            ratio = np.concatenate(told) / np.concatenate(true)
            known = np.isfinite(ratio)
            scaled = column == 2
            figures.append({
                "method": label,
                "r2": interval([np.zeros_like(each) for each in true], true, told),
                "relative_error": float(np.mean(np.abs(ratio[known] - 1))),
                "valid": float(known.mean()),
                "nees": float(np.mean(normal**2)) if scaled else float("nan"),
                "in_2_sigma": float(np.mean(np.abs(normal) < 2)) if scaled else float("nan"),
            })  # fmt: skip
    return figures, table_of([with_interval(each) for each in figures])
