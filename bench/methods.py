#!/usr/bin/env python3
"""`gprodom benchmark`, with its results as rows, and nothing kept of it.

A row for each sequence, method and mode; what follows -- is given to the benchmark.

    bench/methods.py -- ../shared/data/cmu_like/*.zip --methods wheel,sfm -j 2
    bench/methods.py --json -- --simulate 20 --methods wheel,gprodom
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
from contextlib import redirect_stdout
from io import StringIO
from pathlib import Path

from gprodom.cli import main as gprodom
from gprodom.console import add_json_flag, print_json


def main() -> int:
    """Runs the command line."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("arguments", nargs="+", metavar="ARGUMENT", help="of gprodom benchmark")
    add_json_flag(parser)
    args = parser.parse_args()
    said = StringIO()
    with tempfile.TemporaryDirectory(prefix="gprodom-") as folder:
        with redirect_stdout(said):
            code = gprodom(["benchmark", *args.arguments, "-o", folder])
        results = Path(folder) / "results.json"
        if args.json and results.is_file():
            print_json(json.loads(results.read_text(encoding="utf-8"))["records"])
        elif not args.json:
            print(said.getvalue(), end="")
    return code


if __name__ == "__main__":
    sys.exit(main())
