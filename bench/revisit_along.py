#!/usr/bin/env python3
"""Revisits on real ground as the system finds them, along the track, one check off at a time.

The lines, the windows and what counts as right are those of the Seal Beach protocol
(revisit_eval.py in the data folder), but each line is driven: a patch every quarter of a metre, as
recorded and reversed, its place expected with one error for the whole pass (odometry's), in the
gate of the protocol. With --slip L what the wheel calls a metre is e^L of one all along; with
--slip-sigma S the search reckons with slips of such a standard deviation. Of all patches, those at
the start of a pass among them: how many were told a place, how many of those the right one.
Negatives: the same drives over lines 1 m aside or more.

    bench/revisit_along.py ../shared/data [--aside 2] [--prior 3] [--lines 11-20] [--only NAME]
                           [--slip L] [--slip-sigma S]
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
from gprodom.console import Progress
from program import parser_of, print_rows

STEP_M = 0.25  # between patches
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
class Slip:
    """ln of true over reported distance; what the search reckons with."""

    size: float
    sigma: float


@dataclass(frozen=True)
class Told:
    """What one pass was told: errors (m) and their sigma, and how many patches it has."""

    error: Floats
    sigma: Floats
    patches: int


def drive(
    memory: Floats, line: Floats, spacing: float, interval: float, prior: float, error: float,
    options: gpr.RevisitSearchOptions, reverse: bool, slip: Slip,
) -> Told:  # fmt: skip
    """Drives over `line`, traces (n, samples), with `memory`, the same, in the trace memory."""
    learnt = gpr.PatchFilter(memory, spacing, interval)
    features = learnt.apply(memory)
    search = gpr.RevisitSearch(learnt, spacing, options)
    n = min(len(line), len(memory))
    driven = line[:n][::-1] if reverse else line[:n]
    column = np.exp(slip.size)  # of `driven`, from one trace to the next
    at = np.arange(0.0, n - 1, column)
    below = at.astype(int)
    share = (at - below)[:, None].astype(line.dtype)
    traces = (1 - share) * driven[below] + share * driven[below + 1]
    step, patch = round(STEP_M / spacing), search.patch_columns
    errors, sigmas = [], []
    ends = range(patch, len(traces) + 1, step)
    for end in ends:
        centre = column * (end - 0.5 * (patch + 1))
        place = n - 1 - centre if reverse else centre
        newest = learnt.apply(traces[:end])[-(patch + BEFORE) :]
        answer = search.look(newest, step * spacing, features, place + error / spacing, prior + 0.3,
                             slip.sigma, 0.25 * slip.sigma)  # fmt: skip
        if answer is not None:
            right_way = answer[2].mirrored == reverse
            errors.append((answer[0] - place) * spacing if right_way else np.inf)
            sigmas.append(answer[2].sigma_m)
    return Told(np.array(errors), np.array(sigmas), len(ends))


def run(
    protocol: ModuleType, name: str, pairs: list[int], prior: float, aside: int, slip: Slip,
    progress: Progress,
) -> dict[str, Any]:  # fmt: skip
    """The pairs of lines n and n + aside, both directions: shares of patches; of negatives, those
    that were told a place, and of how many."""
    random = np.random.default_rng(1)
    errors, sigmas, patches, false, negatives = [], [], 0, 0, 0
    for n in pairs:
        memory, spacing, interval = protocol.load(n)
        line = protocol.load(n + aside)[0]
        passes = [
            drive(memory, line, spacing, interval, prior, random.uniform(-prior, prior),
                  options_of(name), reverse, slip)
            for reverse in (False, True)
        ]  # fmt: skip
        all_errors = np.concatenate([told.error for told in passes])
        finite = all_errors[np.isfinite(all_errors)]
        errors.append(all_errors - (np.median(finite) if len(finite) else 0.0))
        sigmas.append(np.concatenate([told.sigma for told in passes]))
        patches += sum(told.patches for told in passes)
        far = random.choice([m for m in range(1, 21) if abs(m - n - aside) >= 5], 2, replace=False)
        for reverse in (False, True):
            for other in far:
                told = drive(
                    protocol.load(int(other))[0], line, spacing, interval, prior,
                    random.uniform(-prior, prior), options_of(name), reverse, slip,
                )  # fmt: skip
                false += len(told.error)
                negatives += told.patches
        progress.advance()
    error, sigma = np.concatenate(errors), np.concatenate(sigmas)
    right = np.abs(error) <= protocol.RIGHT_M
    off = error[right]
    return {
        "variant": name,
        "told": len(error) / patches,
        "right_told": float(right.mean()) if len(error) else np.nan,
        "rms_cm": 100 * float(np.sqrt(np.mean(off**2))) if right.any() else np.nan,
        "sigma_ratio": float(np.sqrt(np.mean((off / sigma[right]) ** 2)))
        if right.any() else np.nan,
        "false": false,
        "negatives": negatives,
    }  # fmt: skip


def main() -> None:
    """Prints the table."""
    parser = parser_of(__doc__)
    parser.add_argument("data", type=Path, help="folder with revisit_eval.py and real_ground/")
    parser.add_argument("--prior", type=float, default=0.3, help="m (0.3)")
    parser.add_argument("--aside", type=int, default=1, help="lines between memory and query (1)")
    parser.add_argument("--lines", default="11-20", help="FIRST-LAST (11-20)")
    parser.add_argument("--slip", metavar="L", type=float, default=0.0, help="of the wheel (0)")
    parser.add_argument("--slip-sigma", metavar="S", type=float, default=0.0, help="allowed (0)")
    parser.add_argument("--only", choices=list(VARIANTS), help="one variant")
    arguments = parser.parse_args()
    protocol = load_protocol(arguments.data / "revisit_eval.py")
    first, last = (int(n) for n in arguments.lines.split("-"))
    pairs = list(range(first, last + 1 - arguments.aside))
    outcomes = []
    for name in [arguments.only] if arguments.only else list(VARIANTS):
        with Progress(name, len(pairs)) as progress:
            slip = Slip(arguments.slip, arguments.slip_sigma)
            outcomes.append(
                run(protocol, name, pairs, arguments.prior, arguments.aside, slip, progress)
            )
    print_rows(arguments, outcomes)


if __name__ == "__main__":
    main()
