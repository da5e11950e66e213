#!/usr/bin/env python3
"""Revisits on real ground by the Seal Beach protocol, with one part of the matcher off at a time.

The protocol (revisit_eval.py in the data folder) fits a threshold on lines 1-10, the lowest that
keeps 98 % right, and scores lines 11-20. Beside its figures stand those of the matcher's own rule
(RevisitMatch.accepted), for which nothing is fitted, and how the errors compare with sigma_m.

    bench/revisit_protocol.py ../shared/data [--json] [--only NAME] [--aside 2] [--prior 3]
"""

from __future__ import annotations

import importlib.util
from dataclasses import asdict, dataclass
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from gprodom import gpr
from gprodom.arrays import Bools, Floats
from program import parser_of, print_rows

# name -> (matcher options, filter options)
VARIANTS: dict[str, tuple[dict[str, Any], dict[str, Any]]] = {
    "all": ({}, {}),
    "no whitening over frequency": ({}, {"spectrum_floor": 1e6}),
    "one depth block": ({"depth_blocks": 1}, {}),
    "no shift in time": ({"time_shift": 0.0}, {}),
    "no scale search": ({"scales": [1.0]}, {}),
    "second place inside the bound only": ({"surround_m": 0.0}, {}),
    "halves need not agree": ({"min_half": 0.0}, {}),
    "score from correlation alone": ({}, {}),
}


@dataclass(frozen=True)
class Outcome:
    """Shares; n: queries; sigma_ratio: RMS of error over sigma_m of what the own rule accepts."""

    variant: str
    fit_right: float
    fit_accepted: float
    right: float
    accepted: float
    right_accepted: float
    negatives: int
    false: int
    bound: float
    own_accepted: float
    own_right: float
    own_false: int
    rms_cm: float
    sigma_ratio: float


def load_protocol(path: Path) -> ModuleType:
    """The protocol's module, its lines read once."""
    spec = importlib.util.spec_from_file_location("revisit_eval", path)
    if spec is None or spec.loader is None:
        raise SystemExit(f"{path}: not a Python file")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    read, seen = module.load, {}

    def load(n: int, folder: Path = module.FOLDER) -> Any:
        if n not in seen:
            seen[n] = read(n, folder)
        return seen[n]

    module.load = load  # type: ignore[attr-defined]
    return module


class Matcher:
    """The protocol's matcher; keeps what is learnt of each memory, and every answer."""

    def __init__(self, variant: str) -> None:
        self.by_correlation = variant.startswith("score from")
        self.options, self.filter_options = gpr.RevisitOptions(), gpr.PatchFilterOptions()
        for target, values in zip(
            (self.options, self.filter_options), VARIANTS[variant], strict=True
        ):
            for key, value in values.items():
                setattr(target, key, value)
        self.learnt: dict[int, Any] = {}
        self.answers: dict[float, Any] = {}

    def __call__(
        self, memory: Floats, query: Floats, dx: float, dt: float, prior: float, bound: float
    ) -> tuple[float, bool, float]:
        """(Position of the query's centre on the memory (m), mirrored, score)."""
        if id(memory) not in self.learnt:
            patch_filter = gpr.PatchFilter(memory, dx, dt, self.filter_options)
            matcher = gpr.PatchMatcher(patch_filter, dx, self.options)
            self.learnt[id(memory)] = patch_filter, patch_filter.apply(memory), matcher
        patch_filter, features, matcher = self.learnt[id(memory)]
        middle = 0.5 * len(memory) * dx
        found = matcher.match(features, patch_filter.apply(query), prior - middle, bound)
        score = found.correlation if self.by_correlation else found.score
        # The matcher's own verdict and sigma ride along, found again by the score.
        self.answers[float(score)] = found
        return middle + found.offset_m, found.mirrored, float(score)


def fitted_threshold(right: Bools, score: Floats) -> float:
    """The protocol's: the lowest that keeps 98 % right."""
    order = np.argsort(-score)
    share = np.cumsum(right[order]) / np.arange(1, len(order) + 1)
    keep = np.flatnonzero(share >= 0.98)
    return float(score[order[keep[-1]]]) if len(keep) else np.inf


def run(protocol: ModuleType, variant: str, prior: float, aside: int) -> Outcome:
    """One row: the protocol, and the matcher's own rule on the same answers."""
    matcher = Matcher(variant)
    folder = protocol.FOLDER
    right, _, score, _ = protocol.collect(matcher, range(1, 11), prior, aside, folder, 1)
    threshold = fitted_threshold(right, score)
    fit_right, fit_accepted = float(right.mean()), float((score >= threshold).mean())
    right, error, score, negative = protocol.collect(
        matcher, range(11, 21), prior, aside, folder, 2
    )
    ok = score >= threshold
    false = int((negative >= threshold).sum())
    own = np.array([matcher.answers[float(s)].accepted for s in score])
    sigma = np.array([matcher.answers[float(s)].sigma_m for s in score])
    good = own & right
    return Outcome(
        variant,
        fit_right,
        fit_accepted,
        float(right.mean()),
        float(ok.mean()),
        float(right[ok].mean()) if ok.any() else np.nan,
        len(negative),
        false,
        (false + 1.96 * np.sqrt(false + 1) + 2) / len(negative),
        float(own.mean()),
        float(right[own].mean()) if own.any() else np.nan,
        sum(matcher.answers[float(s)].accepted for s in negative),
        100 * float(np.sqrt(np.mean(error[good] ** 2))) if good.any() else np.nan,
        float(np.sqrt(np.mean((error[good] / sigma[good]) ** 2))) if good.any() else np.nan,
    )


def main() -> None:
    """Prints the table."""
    parser = parser_of(__doc__)
    parser.add_argument("data", type=Path, help="folder with revisit_eval.py and real_ground/")
    parser.add_argument("--prior", type=float, default=0.3, help="m (0.3)")
    parser.add_argument("--aside", type=int, default=1, help="lines between memory and query (1)")
    parser.add_argument("--only", choices=list(VARIANTS), help="one variant")
    arguments = parser.parse_args()
    protocol = load_protocol(arguments.data / "revisit_eval.py")
    names = [arguments.only] if arguments.only else list(VARIANTS)
    outcomes = [run(protocol, name, arguments.prior, arguments.aside) for name in names]
    print_rows(arguments, [asdict(outcome) for outcome in outcomes])


if __name__ == "__main__":
    main()
