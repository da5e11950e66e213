#!/usr/bin/env python3
"""Revisits on real ground as the system finds them, along the track, one check off at a time.

The lines, the windows and what counts as right are those of the Seal Beach protocol
(revisit_eval.py in the data folder), but each line is driven: a patch every quarter of a metre, as
recorded and reversed, its place expected with one error for the whole pass (odometry's), in the
gate of the protocol. Of all patches, those at the start of a pass among them: how many were told a
place, how many of those the right one. Negatives: the same drives over lines 1 m aside or more.

    bench/revisit_along.py ../shared/data [--aside 2] [--lines 11-20] [--only NAME]
"""

from __future__ import annotations

import importlib.util
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from gprodom import gpr
from gprodom.arrays import Floats
from program import one_by_one, parser_of, print_rows

STEP_M = 0.25  # between patches
PRIOR_M = 0.3  # of the place that is expected
BEFORE = 58  # columns before a patch, in which the memory is looked for in turn


VARIANTS: dict[str, dict[str, float]] = {
    "all checks": {},
    "one patch suffices": {"min_patches": 1},
    "not carried along": {"min_patches": 1, "lost": 1.0},
    "newest patch not asked": {"min_half": -100.0},
    "no patch clear by itself": {"clear_once": False},
    "memory not looked for in turn": {"agree_m": 0.0},
    "certainty 0.99": {"certainty": 0.99},
}


def options_of(variant: str) -> gpr.RevisitSearchOptions:
    """Of the search."""
    options = gpr.RevisitSearchOptions()
    for name, value in VARIANTS[variant].items():
        setattr(options, name, value)
    return options


def load_protocol(path: Path) -> ModuleType:
    """The protocol's module, its lines read once."""
    spec = importlib.util.spec_from_file_location("revisit_eval", path)
    if spec is None or spec.loader is None:
        raise SystemExit(f"{path}: not a Python file")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    module.load = cache(module.load)  # type: ignore[attr-defined]
    return module


@dataclass(frozen=True)
class Told:
    """What one pass was told: errors (m) and their sigma, and how many patches it has."""

    error: Floats
    sigma: Floats
    patches: int


def drive(
    protocol: ModuleType, known: int, driven: int, name: str, error: float, reverse: bool
) -> Told:
    """Drives over a line with another one, as it is known, in the trace memory. error: of the place
    that is expected, m."""
    memory, spacing, interval = protocol.load(known)
    line = protocol.load(driven)[0]
    learnt = gpr.PatchFilter(memory, spacing, interval)
    features = learnt.apply(memory)
    search = gpr.RevisitSearch(learnt, spacing, options_of(name))
    n = min(len(line), len(memory))
    traces = line[:n][::-1] if reverse else line[:n]
    step, patch = round(STEP_M / spacing), search.patch_columns
    errors, sigmas = [], []
    ends = range(patch, n, step)
    for end in ends:
        centre = end - 0.5 * (patch + 1)
        place = n - 1 - centre if reverse else centre
        newest = learnt.apply(traces[:end])[-(patch + BEFORE) :]
        expected = place + error / spacing
        answer = search.look(newest, step * spacing, features, expected, PRIOR_M + 0.3)
        if answer is not None:
            right_way = answer[2].mirrored == reverse
            errors.append((answer[0] - place) * spacing if right_way else np.inf)
            sigmas.append(answer[2].sigma_m)
    return Told(np.array(errors), np.array(sigmas), len(ends))


def run(protocol: ModuleType, name: str, lines: range, aside: int) -> dict[str, Any]:
    """The lines n and n + aside, both directions: shares of patches; of negatives, those that were
    told a place, and of how many."""
    random = np.random.default_rng(1)
    told: list[Told] = []
    wrong: list[Told] = []
    errors = []
    for n in one_by_one(name, lines):

        def passes(*known: int, driven: int = n + aside) -> list[Told]:
            return [
                drive(protocol, each, driven, name, random.uniform(-PRIOR_M, PRIOR_M), reverse)
                for reverse in (False, True)
                for each in known
            ]

        both = passes(n)
        of_both = np.concatenate([each.error for each in both])
        finite = of_both[np.isfinite(of_both)]
        errors.append(of_both - (np.median(finite) if len(finite) else 0.0))
        told += both
        far = random.choice([m for m in range(1, 21) if abs(m - n - aside) >= 5], 2, replace=False)
        wrong += passes(*map(int, far))
    error, sigma = np.concatenate(errors), np.concatenate([each.sigma for each in told])
    right = np.abs(error) <= protocol.RIGHT_M
    known = right.any()
    return {
        "variant": name,
        "told": len(error) / sum(each.patches for each in told),
        "right_told": float(right.mean()) if len(error) else np.nan,
        "rms_cm": 100 * rms(error[right]) if known else np.nan,
        "sigma_ratio": rms(error[right] / sigma[right]) if known else np.nan,
        "false": sum(len(each.error) for each in wrong),
        "negatives": sum(each.patches for each in wrong),
    }


def rms(values: Floats) -> float:
    """Root mean square."""
    return float(np.sqrt(np.mean(values**2)))


def main() -> None:
    """Prints the table."""
    parser = parser_of(__doc__)
    parser.add_argument("data", type=Path, help="folder with revisit_eval.py and real_ground/")
    parser.add_argument("--aside", type=int, default=1, help="lines between memory and query (1)")
    parser.add_argument("--lines", default="11-20", help="FIRST-LAST (11-20)")
    parser.add_argument("--only", choices=list(VARIANTS), help="one variant")
    arguments = parser.parse_args()
    protocol = load_protocol(arguments.data / "revisit_eval.py")
    first, last = (int(n) for n in arguments.lines.split("-"))
    names = [arguments.only] if arguments.only else list(VARIANTS)
    lines = range(first, last + 1 - arguments.aside)
    print_rows(arguments, [run(protocol, name, lines, arguments.aside) for name in names])


if __name__ == "__main__":
    main()
