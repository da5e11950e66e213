#!/usr/bin/env python3
"""A place on kilometres of simulated ground, without a prior: how often, how falsely, how fast.

The memory: stretches of 50 m of simulated ground, a trace every 2 cm. Queries: parts of it driven
again, some centimetres aside, either way, by a wheel whose scale has changed by up to a hundredth,
with other noise; and as many of ground that the memory does not hold. Prints the shares found (the
right place, within half a metre, accepted) and falsely accepted, and the time of a search.

    bench/global_search.py --km 10 --queries 200
"""

from __future__ import annotations

import time

import numpy as np

from gprodom import gpr
from gprodom.arrays import Floats
from gprodom.simulate.ground import Ground, GroundSpec
from gprodom.simulate.robot import WANDER
from program import list_of, one_by_one, parser_of, print_figures

SPACING = 0.02  # m
STRETCH = 50.0  # m
NOISE = 30.0  # counts, of each sample
SCALE = 0.01  # by which the wheel's scale has changed at most


def traces(spec: GroundSpec, seed: int, x: Floats, y: Floats, noise: int) -> Floats:
    """Traces (n, samples) at `x`, `y` (n,), m, over the stretch of ground `seed`."""
    corners = np.array([0.0, STRETCH])
    ground = Ground(spec, corners, np.zeros(2), np.random.RandomState(seed))
    clean = ground.traces(x, y)
    return clean + NOISE * np.random.RandomState(noise).standard_normal(clean.shape)


def main() -> None:
    """Prints the figures."""
    parser = parser_of(__doc__)
    parser.add_argument("--km", type=float, default=10.0, help="of memory (10)")
    parser.add_argument("--queries", type=int, default=200, help="of each kind (200)")
    parser.add_argument("--metres", type=float, default=10.0, help="of a query (10)")
    parser.add_argument(
        "--aside",
        type=float,
        metavar="M",
        default=2**0.5 * WANDER,
        help="standard deviation between the tracks (%(default).3f, two passes of the simulator)",
    )
    parser.add_argument("--rows", type=int, default=0, help="of depth that are kept (the default)")
    arguments = parser.parse_args()
    spec, random = GroundSpec(), np.random.RandomState(1)
    stretches = round(1e3 * arguments.km / STRETCH)
    along = np.arange(0.0, STRETCH, SPACING)
    first = traces(spec, 0, along, np.zeros_like(along), 1)
    learnt = gpr.PatchFilter(first, SPACING, spec.sample_interval)
    options = gpr.GlobalSearchOptions()
    if arguments.rows:
        options.rows = arguments.rows
    search = gpr.GlobalSearch(learnt, SPACING, options)
    for seed in one_by_one("memory", range(stretches)):
        measured = traces(spec, seed, along, np.zeros_like(along), 10_000 + seed)
        search.add_run(seed * len(along), learnt.apply(measured))

    found, right, false, margins, seconds = 0, 0, 0, [], []
    for k in one_by_one("queries", range(2 * arguments.queries)):
        known = k < arguments.queries
        seed = int(random.randint(stretches)) + (0 if known else stretches)
        half = 0.5 * arguments.metres * (1 + SCALE)
        middle = random.uniform(half, STRETCH - half)
        step = SPACING * (1 + random.uniform(-SCALE, SCALE)) * random.choice([-1, 1])
        count = round(arguments.metres / SPACING)
        x = middle + (np.arange(count) - 0.5 * (count - 1)) * step
        y = np.full(count, arguments.aside * random.standard_normal())
        query = learnt.apply(traces(spec, seed, x, y, 1_000_000 + k))
        begin = time.process_time()
        match = search.find(query)
        seconds.append(time.process_time() - begin)
        margins.append(match.margin)
        place = seed * len(along) + middle / SPACING
        at_place = abs(match.column - place) * SPACING < 0.5 and match.mirrored == (step < 0)
        found += known and match.accepted and at_place
        right += known and at_place
        false += match.accepted and not (known and at_place)
    figures = {
        "km": arguments.km,
        "metres": arguments.metres,
        "aside_m": arguments.aside,
        "queries": arguments.queries,
        "best_place_right": right / arguments.queries,
        "found": found / arguments.queries,
        "false": false / (2 * arguments.queries),
        "median_margin_known": float(np.median(margins[: arguments.queries])),
        "highest_margin_unknown": float(np.max(margins[arguments.queries :])),
        "search_ms": 1e3 * float(np.median(seconds)),
        "memory_bytes_per_metre": search.bytes / (1e3 * arguments.km),
    }
    print_figures(arguments, figures, list_of(figures))


if __name__ == "__main__":
    main()
