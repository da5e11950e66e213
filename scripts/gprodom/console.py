"""What commands print: progress on stderr, JSON and tables on stdout."""

import argparse
import json
import math
import sys
import time
from collections.abc import Sequence
from typing import Any, TextIO


class Progress:
    """Progress of long work, on stderr.

    On a terminal one line is redrawn a few times a second and removed at the end. Elsewhere (a
    pipe, a CI log) a plain line is written every ten seconds, so short work prints nothing.

        with Progress("writing", total=len(rows)) as progress:
            for row in rows:
                ...
                progress.advance()
    """

    def __init__(self, what: str, total: float, stream: TextIO | None = None) -> None:
        self._what = what
        self._total = max(total, 1e-9)
        self._stream = sys.stderr if stream is None else stream
        self._terminal = self._stream.isatty()
        self._interval = 0.1 if self._terminal else 10.0
        self._done = 0.0
        self._start = time.monotonic()
        self._due = self._start + self._interval
        self._drawn = False

    def __enter__(self) -> "Progress":
        return self

    def __exit__(self, *_: object) -> None:
        if self._terminal and self._drawn:
            self._stream.write("\r\x1b[K")
            self._stream.flush()

    def advance(self, amount: float = 1.0) -> None:
        """Counts `amount` more of the total as done."""
        self.update(self._done + amount)

    def update(self, done: float) -> None:
        """Sets what is done of the total."""
        self._done = done
        now = time.monotonic()
        if now < self._due:
            return
        self._due = now + self._interval
        share = min(done / self._total, 1.0)
        elapsed = now - self._start
        left = f", {elapsed * (1 - share) / share:.0f} s left" if share > 0.01 else ""
        text = f"{self._what} {100 * share:.0f} %{left}"
        self._stream.write(f"\r{text}\x1b[K" if self._terminal else f"{text}\n")
        self._stream.flush()
        self._drawn = True


def warn(text: str) -> None:
    """One line on stderr about something doubtful that does not end the command."""
    in_place_of_progress = "\r\x1b[K" if sys.stderr.isatty() else ""
    print(f"{in_place_of_progress}gprodom: warning: {text}", file=sys.stderr)


def add_json_flag(parser: argparse.ArgumentParser) -> None:
    """``--json``, for commands that print figures."""
    parser.add_argument("--json", action="store_true", help="print the figures as JSON")


def _plain(value: Any) -> Any:
    """`value` in JSON's own types; what is not finite becomes null."""
    if isinstance(value, dict):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(item) for item in value]
    if hasattr(value, "tolist"):  # numpy arrays and scalars
        return _plain(value.tolist())
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value


def to_json(value: Any) -> str:
    """Standard JSON (no NaN), keys in the order given."""
    return json.dumps(_plain(value), indent=2, ensure_ascii=False, allow_nan=False)


def print_json(value: Any) -> None:
    """Prints `value` as JSON on stdout."""
    print(to_json(value))


def tell(as_json: bool, figures: Any, text: str) -> None:
    """Prints figures, as JSON where that is asked for, else in words."""
    print(to_json(figures) if as_json else text)


def format_table(header: Sequence[str], rows: Sequence[Sequence[object]]) -> str:
    """A text table: first column to the left, the others to the right."""
    cells = [list(header), *([_cell(value) for value in row] for row in rows)]
    widths = [max(len(row[column]) for row in cells) for column in range(len(header))]
    lines = []
    for row in cells:
        padded = [
            text.ljust(width) if column == 0 else text.rjust(width)
            for column, (text, width) in enumerate(zip(row, widths, strict=True))
        ]
        lines.append("  ".join(padded).rstrip())
    lines.insert(1, "  ".join("-" * width for width in widths))
    return "\n".join(lines)


def _cell(value: object) -> str:
    if value is None or (isinstance(value, float) and not math.isfinite(value)):
        return "-"
    if isinstance(value, float):
        return f"{value:.3f}"
    return str(value)
