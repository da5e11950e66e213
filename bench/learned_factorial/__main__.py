"""What do the networks see, and what do they only count? On grounds that no training has seen.

DIR holds what `gprodom learn -o DIR` wrote. On each test ground (split.json) a radar drives at each
of four speeds, at each of four rates of its traces, so that their number says nothing of the way.
The figure is the R2 of the distance over 4 s beyond the number of traces,

    1 - sum (d - told)^2 / sum (d - best affine function of the number of traces)^2,

with a 95 % interval from resampling the grounds: 1 is exact, 0 is as good as counting. Where a
method has no valid answer the count's is taken. "scaled": each ground's answers times one number,
learnt on 5 m of the same ground from the true way, as gprodom learns its coherence from the wheel.
NEES and "in 2 sigma" are those of the single answers, scaled. Then: the distance claimed while the
robot stands, and with the traces of each segment in another order, over that in order.

For learned_pair: images laid by a wheel that is wrong by 0.7 to 1.3; "follows" is the slope of
what it says over what the wheel says, both relative to the truth: 1 repeats the wheel, 0 sees the
ground.

With SEQUENCEs (each with `.json` and `.truth.npz` beside it) the same methods are scored on those
instead, over 4 s in which the robot drives; the scale is then learnt on the first 5 m. A sequence
that the networks were trained on is refused.

    bench/learned_factorial networks
    bench/learned_factorial networks ../shared/data/cmu_like/*.zip
"""

from __future__ import annotations

import argparse
import sys
from dataclasses import dataclass, field
from functools import cache, partial
from pathlib import Path

import numpy as np
import sequences
from cells import KINDS, RATES, SEGMENT_S, SPEEDS, calibration_drive, make_cell
from rivals import Answers, ByCoherence, ByNetwork, ByRidge, Rival, speed_in
from table import tables

import pairs
from gprodom.learned.grounds import make_line, seeds
from gprodom.learned.model import read_record

sys.path.append(str(Path(__file__).resolve().parents[1]))

from program import in_processes, one_by_one, parser_of, print_figures

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


def on_sequences(args: argparse.Namespace, lengths: dict[str, tuple[float, float]]) -> int:
    """The methods on recorded drives."""
    trained = set(read_record(args.folder)["grounds"].get("sequences", []))
    for sequence in args.sequences:
        if sequence.name in trained:
            raise SystemExit(f"learned_factorial: {sequence.name}: the networks were trained on it")
    methods = {**rivals(args.folder), "coherence": ByCoherence(*lengths["coherence"])}
    found = [sequences.measure(each, methods) for each in one_by_one("sequences", args.sequences)]
    print_figures(args, *sequences.tables(found))
    return 0


def main() -> int:
    """Command line."""
    parser = parser_of(__doc__, jobs=1)
    parser.add_argument("folder", type=Path, metavar="DIR", help="of gprodom learn")
    parser.add_argument("sequences", nargs="*", type=Path, metavar="SEQUENCE")
    parser.add_argument("--share", type=float, default=1.0, help="of the test grounds (default 1)")
    args = parser.parse_args()
    lengths = lengths_of_coherence()
    if args.sequences:
        return on_sequences(args, lengths)
    grounds = seeds("test", args.share)
    work = partial(score_ground, args.folder, lengths)
    results = in_processes(args.jobs, "grounds", work, grounds)
    offsets = [
        pairs.measure(make_line(ground), ground, args.folder)
        for ground in one_by_one("pairs on grounds", grounds)
    ]
    print_figures(args, *tables(results, offsets))
    return 0


if __name__ == "__main__":
    sys.exit(main())
