#!/usr/bin/env python3
"""`gprodom benchmark`, with its results as rows, and nothing kept of it.

A row for each sequence, method and mode; what follows -- is given to the benchmark.

    bench/methods.py -- ../shared/data/cmu_like/*.zip --methods wheel,sfm -j 2
    bench/methods.py --json -- --simulate 20 --methods wheel,gprodom
"""

from __future__ import annotations

import json
from contextlib import redirect_stdout
from io import StringIO

from gprodom.cli import main as gprodom
from gprodom.console import print_json
from gprodom.files import temporary_folder
from program import exit_with, parser_of


def main() -> int:
    """Runs the command line."""
    parser = parser_of(__doc__)
    parser.add_argument("arguments", nargs="+", metavar="ARGUMENT", help="of gprodom benchmark")
    args = parser.parse_args()
    said = StringIO()
    with temporary_folder() as folder:
        with redirect_stdout(said):
            code = gprodom(["benchmark", *args.arguments, "-o", str(folder)])
        results = folder / "results.json"
        if args.json and results.is_file():
            print_json(json.loads(results.read_text(encoding="utf-8"))["records"])
        elif not args.json:
            print(said.getvalue(), end="")
    return code


if __name__ == "__main__":
    exit_with(main)
