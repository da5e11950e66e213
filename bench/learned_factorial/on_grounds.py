"""Each method on each ground. Other processes run it, so it cannot stand in __main__."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cache
from pathlib import Path

import numpy as np
from cells import KINDS, RATES, SEGMENT_S, SPEEDS, calibration_drive, make_cell
from rivals import Answers, ByCoherence, ByNetwork, ByRidge, Rival, speed_in

from gprodom.learned.grounds import make_line, seeds

SCALED_ON = 3  # validation grounds


@dataclass
class Scored:
    """Of one ground and method: rows (speed, rate, true, told) by kind of cell, m; of the single
    answers of the driven cells, error over sigma; the scale learnt on the same ground."""

    rows: dict[str, list[tuple[float, float, float, float]]] = field(default_factory=dict)
    normal: list[float] = field(default_factory=list)
    scale: float = 1.0


@cache
def rivals(folder: Path) -> dict[str, Rival]:
    """Once a process: the ridge regression takes some seconds."""
    return {
        "learned_sequential": ByNetwork(folder),
        "ridge on coherence": ByRidge(folder),
        "coherence": ByCoherence(),
    }


def scale_of(rival: Rival, ground: int) -> tuple[float, float]:
    """True over told way of a drive on the ground, and the spread of that, relative."""
    cell = calibration_drive(make_line(ground), ground)
    answers = rival(cell)
    driving = answers.begin >= cell.segments[0][0]
    if not driving.any() or answers.speed[driving].mean() <= 0:
        return 1.0, 1.0
    speeds = answers.speed[driving]
    return cell.speed / float(speeds.mean()), float(speeds.std() / speeds.mean())


def score_ground(
    folder: Path, lengths: dict[str, tuple[float, float]], ground: int
) -> dict[str, Scored]:
    """All cells of a ground by each method."""
    line = make_line(ground)
    scored = {}
    for name, rival in rivals(folder).items():
        length, relative = lengths.get(name, (1.0, 0.0))
        if name in lengths:
            rival = ByCoherence(length, relative)
        result = scored[name] = Scored(scale=scale_of(rival, ground)[0])
        for kind in KINDS:
            rows = result.rows[kind] = []
            for speed in SPEEDS if kind != "standing" else SPEEDS[:1]:
                for rate in RATES:
                    cell = make_cell(line, ground, kind, speed, rate)
                    answers = rival(cell)
                    for begin, end in cell.segments:
                        told = speed_in(answers, begin, end)
                        rows.append((speed, rate, cell.speed * SEGMENT_S, told * SEGMENT_S))
                    if kind == "driven":
                        result.normal += errors(answers, cell.speed, cell.segments, result.scale)
    return scored


def errors(
    answers: Answers, speed: float, segments: list[tuple[float, float]], scale: float
) -> list[float]:
    """Error over standard deviation of the scaled answers in the segments."""
    inside = (answers.begin >= segments[0][0]) & (answers.end <= segments[-1][1] + 0.1)
    sigma = np.maximum(scale * answers.sigma[inside], 1e-6)
    return list((scale * answers.speed[inside] - speed) / sigma)


def lengths_of_coherence() -> dict[str, tuple[float, float]]:
    """Metres of a decorrelation length, mean of some validation grounds, and the relative standard
    deviation of an answer that is scaled on its own ground."""
    found = [scale_of(ByCoherence(), ground) for ground in seeds("validate")[:SCALED_ON]]
    known = [each for each in found if each[1] < 1.0]
    length = float(np.exp(np.mean([np.log(scale) for scale, _ in known])))
    return {"coherence": (length, float(np.mean([spread for _, spread in known])))}
