"""``gprodom simulate``: a sequence in the format of CMU-GPR, from a seed."""

from __future__ import annotations

import argparse
from pathlib import Path

from gprodom.cli import Subparsers, add_command
from gprodom.console import Progress, add_json_flag, print_json
from gprodom.errors import UsageError
from gprodom.simulate.files import write_sequence
from gprodom.simulate.random import stream
from gprodom.simulate.routes import ROUTES, make_route
from gprodom.simulate.sequence import Spec, simulate

EXAMPLES = """\
  gprodom simulate --seed 7 -o 1700000000-0-yard-cmu-gpr.zip
  gprodom simulate --route loop --distance 60 --slips 4 -o 1700000000-0-loop-cmu-gpr
"""

DESCRIPTION = """\
Simulates a drive and writes it in the format of the CMU-GPR dataset, for `gprodom convert cmu`:
IMU, wheel encoder and total station with the errors of the estimator's default configuration, and
radar traces over scatterers and layers. OUT is a zip where so named, else a directory; the truth
comes beside it as OUT.truth.npz and OUT.json. The same arguments give the same bytes.
"""


def add_parser(subparsers: Subparsers) -> None:
    """Adds ``simulate``."""
    parser = add_command(
        subparsers, "simulate", "make a sequence from a seed", DESCRIPTION, EXAMPLES
    )
    parser.add_argument("-o", "--output", metavar="OUT", type=Path, required=True)
    parser.add_argument(
        "--seed", type=int, default=0, help="0 or more; draws all errors (default: %(default)s)"
    )
    parser.add_argument(
        "--route", choices=ROUTES, default="line", help="default: %(default)s, with reversals"
    )
    parser.add_argument(
        "--distance", metavar="M", type=float, default=30.0, help="default: %(default)s"
    )
    parser.add_argument(
        "--speed", metavar="M/S", type=float, default=0.6, help="top speed (default: %(default)s)"
    )
    parser.add_argument(
        "--standstill", metavar="S", type=float, default=6.0, help="at first (default: %(default)s)"
    )
    parser.add_argument(
        "--slips", metavar="N", type=int, default=0, help="slip or skid episodes (default: 0)"
    )
    add_json_flag(parser)
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Simulates and writes."""
    for name, low, high in (
        ("seed", 0, 2**63),
        ("distance", 1, 5000),
        ("speed", 0.05, 5),
        ("standstill", 0, 3600),
        ("slips", 0, 1000),
    ):
        if not low <= getattr(args, name) <= high:
            raise UsageError(f"--{name} {getattr(args, name)}: expected {low} to {high}")
    drive = make_route(
        args.route, args.distance, args.speed, args.standstill, stream(args.seed, "route")
    )
    with Progress("simulating", 2) as progress:
        simulated = simulate(Spec(drive, slips=args.slips, kind=args.route), args.seed)
        progress.advance()
        paths = write_sequence(simulated, args.output)
        progress.advance()
    facts = {
        "files": [str(path) for path in paths],
        "duration_s": simulated.drive.duration,
        "distance_m": float(simulated.truth.travelled[-1]),
        "wheel_scale": float(simulated.wheel.scale[0]),
        "slips": len(simulated.spec.wheel.slips),
        "traces": len(simulated.gpr_utime),
    }
    if args.json:
        print_json(facts)
    else:
        print(
            f"{paths[0]}: {facts['distance_m']:.1f} m in {facts['duration_s']:.1f} s, "
            f"{facts['traces']} traces, wheel scale {facts['wheel_scale']:.4f}, "
            f"{facts['slips']} slips"
        )
    return 0
