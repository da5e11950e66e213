#!/usr/bin/env python3
"""What do the networks see, and what do they only count? On grounds that no training has seen.

DIR holds what `gprodom learn -o DIR` wrote. On each test ground (split.json) a radar drives at each
of four speeds, at each of four rates of its traces, so that their number says nothing of the way.
The figure is the R2 of the distance over 4 s beyond the number of traces,

    1 - sum (d - told)^2 / sum (d - best affine function of the number of traces)^2,

with a 95 % interval from resampling the grounds: 1 is exact, 0 is as good as counting. Where a
method has no valid answer the count's is taken. "scaled": each ground's answers times one number,
learnt on 5 m of the same ground from the true way, as gprodom learns its coherence from the wheel.
Then the R2 with the traces of each segment in another order, and the speed claimed while the robot
stands. Beside the network stands the coherence of gprodom, in metres by some validation grounds.

For learned_pair: images laid by a wheel that is wrong by 0.7 to 1.3; "follows" is the slope of
what it says over what the wheel says, both relative to the truth: 1 repeats the wheel, 0 sees the
ground.

    bench/learned_factorial.py networks
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from gprodom import gpr
from gprodom.arrays import Floats, Ints
from gprodom.learned import windows
from gprodom.learned.examples import REACH
from gprodom.learned.grounds import LENGTH, Line, make_line, receive, seeds
from gprodom.learned.model import Network, read_record, to_offset, to_spacing, widening
from gprodom.learned.windows import WINDOW, image, step_at, to_rows
from gprodom.random_streams import stream
from program import exit_with, in_processes, parser_of, print_figures, table_of

SPEEDS = (0.1, 0.2, 0.4, 0.8)  # m/s
RATES = (5.0, 10.0, 20.0, 40.0)  # traces/s
BEFORE_S, DRIVE_S = 3.0, 9.0  # of standing, and of the drive
SEGMENT_S = 4.0
SEGMENTS = ((4.0, 8.0), (8.0, 12.0))  # s; in the first second not all methods have begun
KINDS = ("driven", "shuffled", "standing")
SCALED_ON = 3  # validation grounds
RESAMPLES = 2000
# Of the pairs: the way that the wheel tells over the true one; m/s, traces/s; of each ground.
WHEELS, PAIR_SPEED, PAIR_RATE, PLACES = (0.7, 0.85, 1.0, 1.15, 1.3), 0.4, 20.0, 12


# ---- what says how fast the radar moves ----


@dataclass(frozen=True)
class Drive:
    """Traces at the times (s) of a drive at a constant speed."""

    rate: float  # traces/s
    time: Floats
    traces: Ints
    sample_interval: float


Answers = tuple[Floats, Floats, Floats]  # begin and end, s, and the speed between, m/s
Rival = Callable[[Drive], Answers]


def by_network(folder: Path) -> Rival:
    """learned_sequential."""
    name = "learned_sequential"
    network, widen = Network(folder, name), widening(read_record(folder), name)

    def speeds(drive: Drive) -> Answers:
        rows, step = to_rows(drive.traces, drive.sample_interval), step_at(drive.rate)
        ends = np.arange(WINDOW + step, len(rows) + 1, step)
        before = np.array([rows[end - step - WINDOW : end - step] for end in ends])
        after = np.array([rows[end - WINDOW : end] for end in ends])
        begin, until = drive.time[ends - 1 - step], drive.time[ends - 1]
        spacing = to_spacing(network(before, after), widen).mean
        return begin, until, spacing * step / (until - begin)

    return speeds


def by_coherence(length: float = 1.0) -> Rival:
    """The coherence of gprodom: decorrelation lengths, times the metres of one. Where it says that
    it does not know there is no answer."""

    def speeds(drive: Drive) -> Answers:
        time = np.round(drive.time * 1e9).astype(np.int64) + 10**18
        traces = drive.traces.astype(np.float32)
        found = [
            ((begin - 10**18) * 1e-9, (end - 10**18) * 1e-9, lengths)
            for begin, end, lengths, valid in gpr.coherence(time, traces, drive.sample_interval)
            if valid
        ]
        begin, end, lengths = np.array(found).reshape(-1, 3).T
        return begin, end, length * lengths / np.maximum(end - begin, 1e-9)

    return speeds


def speed_in(answers: Answers, begin: float, end: float) -> float:
    """Mean speed (m/s) of the answers that lie in a segment, by their time; NaN: none does."""
    since, until, speed = answers
    inside = (since >= begin - 0.6) & (until <= end + 0.1) & (since + until > 2 * begin)
    if not inside.any():
        return float("nan")
    return float(np.average(speed[inside], weights=(until - since)[inside]))


# ---- drives, and what is told of them ----


def driven(line: Line, ground: int, kind: str, speed: float, rate: float) -> Drive:
    """One drive over the ground of that seed. shuffled: the same traces, each segment's in another
    order: their number says what it did, their likeness nothing."""
    random = stream(ground, f"{speed} {rate}")
    time = np.arange(0.0, BEFORE_S + DRIVE_S + 0.1, 1 / rate)
    way = (0.0 if kind == "standing" else speed) * np.maximum(time - BEFORE_S, 0.0)
    along = random.uniform(0.0, LENGTH - way[-1] - 0.01) + way
    drive = Drive(rate, time, receive(line, along, rate, random), line.sample_interval)
    for begin, end in SEGMENTS if kind == "shuffled" else ():
        inside = np.flatnonzero((time >= begin) & (time < end))
        drive.traces[inside] = drive.traces[random.permutation(inside)]
    return drive


def scale_of(rival: Rival, ground: int) -> float:
    """True over told way of some 5 m of the ground at 0.6 m/s and 20 traces/s."""
    line, random = make_line(ground), stream(ground, "calibration")
    time = np.arange(0.0, BEFORE_S + DRIVE_S + 0.1, 0.05)
    along = random.uniform(0.0, 6.0) + 0.6 * np.maximum(time - BEFORE_S, 0.0)
    traces = receive(line, along, 20.0, random)
    begin, _, speed = rival(Drive(20.0, time, traces, line.sample_interval))
    told = speed[begin >= SEGMENTS[0][0]]
    return 0.6 / float(told.mean()) if len(told) and told.mean() > 0 else 1.0


def score_ground(folder: Path, length: float, ground: int) -> dict[str, Any]:
    """Of each method its scale, and rows (traces/s, true way, told way; m) by kind of drive; of
    learned_pair see `offsets`."""
    line, found = make_line(ground), {}
    rivals = {"learned_sequential": by_network(folder), "coherence": by_coherence(length)}
    for name, rival in rivals.items():
        rows: dict[str, list[tuple[float, float, float]]] = {kind: [] for kind in KINDS}
        for kind, speed, rate in product(KINDS, SPEEDS, RATES):
            if kind == "standing" and speed != SPEEDS[0]:
                continue
            answers = rival(driven(line, ground, kind, speed, rate))
            true = 0.0 if kind == "standing" else speed * SEGMENT_S
            told = [speed_in(answers, *segment) * SEGMENT_S for segment in SEGMENTS]
            rows[kind] += [(rate, true, each) for each in told]
        found[name] = {"scale": scale_of(rival, ground)}
        found[name] |= {kind: np.array(each) for kind, each in rows.items()}
    return found | {"pairs": offsets(line, ground, folder)}


def offsets(line: Line, ground: int, folder: Path) -> dict[str, Floats]:
    """Rows (the wheel's scale, true offset, what learned_pair tells; m) of pairs of images on one
    ground: of the same pass one after the other, and of another pass over it."""
    network = Network(folder, "learned_pair")
    widen = widening(read_record(folder), "learned_pair")
    made: dict[str, list[Floats]] = {"consecutive": [], "revisit": []}
    for wheel in WHEELS:
        random = stream(ground, f"pairs {wheel}")
        along = np.arange(0.0, LENGTH, PAIR_SPEED / PAIR_RATE)
        passes = [
            to_rows(receive(line, along, PAIR_RATE, random, on), line.sample_interval)
            for on in (0, 1)
        ]
        room = LENGTH - windows.LENGTH - REACH
        here = random.uniform(REACH + windows.LENGTH, room, PLACES)
        true = random.uniform(-REACH, REACH, PLACES) * min(1.0, 1 / wheel)

        def images(rows: Floats, middles: Floats, along: Floats = wheel * along) -> Floats:
            return np.array([image(rows, along, m - windows.LENGTH / 2) for m in middles])

        first = images(passes[0], wheel * here)
        for kind, rows in zip(made, passes, strict=True):
            second = images(rows, wheel * (here + true))
            told = to_offset(network(first, second), widen).offset
            made[kind].append(np.column_stack([np.full(PLACES, wheel), true, told]))
    return {kind: np.concatenate(each) for kind, each in made.items()}


# ---- figures ----


def beyond(rows: Floats) -> float:
    """R2 of what is told (rows: reference, true, told) beyond the best affine function of the
    reference; where nothing is told (NaN) that function's value is taken."""
    reference, true, told = rows.T
    simple = np.polyval(np.polyfit(reference, true, 1), reference)
    told = np.where(np.isfinite(told), told, simple)
    return float(1 - np.sum((true - told) ** 2) / np.sum((true - simple) ** 2))


def interval(grounds: Sequence[Floats]) -> list[float]:
    """R2 beyond the reference, and its 95 % interval from resampled grounds."""
    random, count = np.random.RandomState(0), len(grounds)
    drawn = [
        beyond(np.concatenate([grounds[i] for i in random.randint(count, size=count)]))
        for _ in range(RESAMPLES)
    ]
    return [beyond(np.concatenate(grounds)), *np.percentile(drawn, [2.5, 97.5]).tolist()]


def of_method(name: str, results: Sequence[Any], scaled: bool) -> dict[str, Any]:
    """The row of a method."""

    def told(kind: str) -> list[Floats]:
        scales = [each[name]["scale"] if scaled else 1.0 for each in results]
        return [each[name][kind] * (1, 1, s) for each, s in zip(results, scales, strict=True)]

    standing = np.concatenate(told("standing"))[:, 2]
    return {
        "method": name + (", scaled" if scaled else ""),
        "r2": interval(told("driven")),
        "r2_shuffled": beyond(np.concatenate(told("shuffled"))),
        "valid": float(np.isfinite(np.concatenate(told("driven"))[:, 2]).mean()),
        "standing_mps": float(np.nansum(standing) / (SEGMENT_S * len(standing))),
    }


def of_pairs(kind: str, results: Sequence[Any]) -> dict[str, Any]:
    """The row of a kind of pairs."""
    of_each = [each["pairs"][kind].T for each in results]
    wheel, true, told = np.concatenate(of_each, axis=1)
    far, right = np.abs(true) > 0.1, wheel == 1.0
    return {
        "pairs": kind,
        "follows": float(np.polyfit(wheel[far], np.clip(told / true, -1, 3)[far], 1)[0]),
        "r2_beyond_wheel": interval([np.column_stack([w * t, t, o]) for w, t, o in of_each]),
        "median_mm": 1e3 * float(np.median(np.abs(told - true)[right])),
    }


def main() -> None:
    """Runs the command line."""
    parser = parser_of(__doc__, jobs=1)
    parser.add_argument("folder", type=Path, metavar="DIR", help="of gprodom learn")
    parser.add_argument("--share", type=float, default=1.0, help="of the test grounds (default 1)")
    args = parser.parse_args()
    known = [scale_of(by_coherence(), ground) for ground in seeds("validate")[:SCALED_ON]]
    length = float(np.exp(np.mean(np.log(known))))
    work = partial(score_ground, args.folder, length)
    results = in_processes(args.jobs, "grounds", work, seeds("test", args.share))
    names = [name for name in results[0] if name != "pairs"]
    figures = {
        "ways": [of_method(name, results, scaled) for name in names for scaled in (False, True)],
        "pairs": [of_pairs(kind, results) for kind in results[0]["pairs"]],
    }
    print_figures(args, figures, "\n\n".join(map(table_of, figures.values())))


if __name__ == "__main__":
    exit_with(main)
