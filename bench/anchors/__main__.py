"""What positions from outside give, and what they must not take: fixes made from the truth.

    ends     DIR [--only NAME]...  recordings of robots, with fixes in the first and the last tenth
                                   of the way only: the error in between, with and without
    withheld DIR                   the Husky with its own /fix, 60 s of which are withheld
    scale                          two fixes of 2 cm, 90 m apart: the wheel's scale and its limit
    faults   DIR [--only NAME]...  each fault of a receiver: the error over that without fixes, what
                                   STATUS says, and after how long
    days                           two days on different ground, tied to one datum: do maps merge?

Errors are root mean squares in the plane, in metres: aligned by se2 over the same points for both;
`placed`: the estimate without fixes as a user would place it who has the same fixes, by se2 over
the points where there are any; `site`: of the estimate with fixes, as it is. The truth is of an
antenna whose place on the robot nobody tells: with fixes the smoothed estimate finds it, and its
antenna is compared; `body`, and all others: the body.

    python bench/anchors ends ../shared/data/robots --only wid02
    python bench/anchors --json scale --seeds 20
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

sys.path.append(str(Path(__file__).resolve().parents[1]))

import ends
import receiver_faults
import scale
import two_days
import withheld

from gprodom.options import add_overrides_option
from program import add_seeds, exit_with, parser_of, print_rows

PARTS: dict[str, Callable[[argparse.Namespace], list[dict[str, Any]]]] = {
    "ends": ends.run,
    "withheld": withheld.run,
    "scale": scale.run,
    "faults": receiver_faults.run,
    "days": two_days.run,
}
OF_RECORDINGS = ("ends", "withheld", "faults")


def parser() -> argparse.ArgumentParser:
    """The command line."""
    made = parser_of(__doc__)
    parts = made.add_subparsers(metavar="PART", dest="part", required=True)
    for name in PARTS:
        part = parts.add_parser(name)
        if name in OF_RECORDINGS:
            part.add_argument("data", type=Path, metavar="DIR")
        if name in ("ends", "faults"):
            part.add_argument("--only", action="append", metavar="NAME", default=[])
        add_seeds(part, "--seeds", 1)
        add_overrides_option(part)
    return made


def main() -> None:
    """Runs a part."""
    args = parser().parse_args()
    print_rows(args, PARTS[args.part](args))


if __name__ == "__main__":
    exit_with(main)
