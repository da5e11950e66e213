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
from functools import partial
from pathlib import Path

sys.path.append(str(Path(__file__).resolve().parents[1]))

import sequences
from on_grounds import lengths_of_coherence, rivals, score_ground
from rivals import ByCoherence
from table import tables

import pairs
from gprodom.learned.grounds import make_line, seeds
from gprodom.learned.model import read_record
from program import in_processes, one_by_one, parser_of, print_figures


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
