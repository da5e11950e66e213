"""Rows of a large table, read block by block: the columns of one sensor, as loggers write them.

A row that cannot be used (a comment, a cell without a number, a last line that a power cut has
shortened) is left out and counted. A row whose cells of this sensor are all empty is none of its
own: in a table of all sensors the slower ones leave their cells empty.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path

import numpy as np

from gprodom.arrays import Floats, Ints
from gprodom.console import Progress
from gprodom.convert.table import is_number, shown
from gprodom.errors import Error
from gprodom.times import to_microseconds

BLOCK_BYTES = 1 << 22
COMMENTS = (b"#", b"%", b"//")
INT32 = 1 << 31
# A time (s since 1970) from which it is of another unit: the year 5138. Those of today have in the
# units below a thousand times as much each.
LATEST_S = 1e11
_SMALLER_UNITS = (("ms", 1e3), ("us", 1e6), ("ns", 1e9))


@dataclass(frozen=True)
class Picked:
    """Which cells of a table's rows are wanted, and what they are."""

    path: Path  # for messages
    file: Path  # what is read: of a pipe, what came through it
    delimiter: bytes
    columns: tuple[int, ...]  # of the time, then of the values, from 0
    width: int  # cells of a whole row
    header: int | None  # number of the line with the names, from 1
    iso: bool = False  # the time is a date
    per_second: int = 1  # of the time's unit
    scale: float | None = None  # counts per unit of the values; None: they are as they are
    integers: bool = False  # values must be whole numbers of 32 bits, once scaled
    keys: int = 0  # so many of the first values are no measurements: they are not scaled


@dataclass
class Rows:
    """What was read, in the order of the file, and what was not."""

    utime: Ints  # (n,), us since 1970
    values: Floats  # (n, columns after the time); int32 where integers are wanted
    faults: dict[str, list[tuple[int, str]]] = field(default_factory=dict)  # by kind: line, words

    @property
    def unusable(self) -> int:
        """Rows left out for what is in them; a comment is no row."""
        return sum(len(found) for kind, found in self.faults.items() if kind != "comment")


class _UnusableError(Exception):
    def __init__(self, kind: str, words: str) -> None:
        super().__init__(words)
        self.kind = kind


def read_rows(picked: Picked, strict: bool = False) -> Rows:
    """All rows of the picked columns. With `strict` the first unusable one raises `Error`."""
    blocks = _Blocks(picked, strict)
    with (
        Progress(f"reading {picked.path.name}", picked.file.stat().st_size) as progress,
        picked.file.open("rb") as file,
    ):
        number = 1
        while lines := file.readlines(BLOCK_BYTES):
            blocks.add(lines, number)
            number += len(lines)
            progress.advance(sum(map(len, lines)))
    return blocks.rows()


class _Blocks:
    """Collects blocks of lines. One in which every line is a row of numbers is read by numpy."""

    def __init__(self, picked: Picked, strict: bool) -> None:
        self._picked, self._strict = picked, strict
        self._utime: list[Ints] = []
        self._values: list[Floats] = []
        self._faults: dict[str, list[tuple[int, str]]] = {}
        self._gaps = False  # cells of this sensor have been found empty

    def rows(self) -> Rows:
        """All of them together."""
        wide = len(self._picked.columns) - 1
        values = self._values or [np.zeros((0, wide))]
        utime = self._utime or [np.zeros(0, np.int64)]
        return Rows(np.concatenate(utime), np.concatenate(values), self._faults)

    def add(self, lines: list[bytes], first: int) -> None:
        """`first`: number of the first of these lines, from 1."""
        if first == 1:
            lines[0] = lines[0].removeprefix(b"\xef\xbb\xbf")
        header = self._picked.header
        plain = header is None or not first <= header < first + len(lines)
        if plain and lines[-1].endswith(b"\n"):  # else the last may have been cut short
            if not self._gaps and self._add_whole(lines):
                return
            if self._add_whole(self._filled(lines)):
                self._gaps = True
                return
        self._add_each(lines, first)

    def _filled(self, lines: list[bytes]) -> list[bytes]:
        """Those with something in a cell of this sensor."""
        mark, values = self._picked.delimiter, self._picked.columns[1:]
        if not values:
            return lines
        last = max(values)
        kept = []
        for line in lines:
            cells = line.split(mark, last + 1)
            if len(cells) <= last or any(cells[i].strip() for i in values):
                kept.append(line)
        return kept

    def _add_whole(self, lines: list[bytes]) -> bool:
        """Whether all of `lines` are rows of numbers; then they are taken."""
        if not lines:
            return True
        picked = self._picked
        time, values = picked.columns[0], picked.columns[1:]
        try:
            utime = [self._utime_of(line.split(picked.delimiter, time + 1)[time]) for line in lines]
            if picked.delimiter != b",":
                lines = [line.replace(b",", b".") for line in lines]
            if any(b"_" in line for line in lines):
                return False
            numbers = np.loadtxt(
                lines, delimiter=picked.delimiter.decode("latin-1"), usecols=values, ndmin=2,
                comments=None,
            ) if values else np.zeros((len(lines), 0))  # fmt: skip
            numbers = self._scaled(numbers)
        except (ValueError, IndexError, _UnusableError):
            return False
        if len(numbers) != len(utime):  # numpy passes over blank lines
            return False
        self._utime.append(np.array(utime, np.int64))
        self._values.append(numbers)
        return True

    def _add_each(self, lines: list[bytes], first: int) -> None:
        utime: list[int] = []
        values: list[list[float]] = []
        for number, line in enumerate(lines, start=first):
            if number == self._picked.header or not line.strip():
                continue
            try:
                row = self._row(line)
            except _UnusableError as fault:
                if self._strict or fault.kind == "unit":
                    raise Error(f"{self._picked.path}:{number}: {fault}") from None
                self._faults.setdefault(fault.kind, []).append((number, str(fault)))
                continue
            if row is not None:
                utime.append(row[0])
                values.append(row[1])
        if utime:
            self._utime.append(np.array(utime, np.int64))
            wide = len(self._picked.columns) - 1
            self._values.append(
                self._scaled(np.array(values, np.float64).reshape(len(utime), wide))
            )

    def _row(self, line: bytes) -> tuple[int, list[float]] | None:
        """Time and values; None where the row has none of this sensor."""
        picked = self._picked
        if line.lstrip().startswith(COMMENTS):
            raise _UnusableError("comment", "expected numbers, got a comment")
        cells = clean_cells(line, picked.delimiter)
        most = max(picked.columns) + 1
        if len(cells) < (picked.width if not line.endswith(b"\n") else most):
            raise _UnusableError("short", f"expected at least {most} columns, got {len(cells)}")
        chosen = [cells[i] for i in picked.columns]
        if len(chosen) > 1 and not any(chosen[1:]):
            return None
        utime = self._utime_of(chosen[0])
        values: list[float] = []
        for column, cell in zip(picked.columns[1:], chosen[1:], strict=True):
            value = float(cell) if is_number(cell) and b"_" not in cell else math.nan
            wrong = "" if math.isfinite(value) else "a finite number"
            scale = picked.scale if len(values) >= picked.keys else None
            if not wrong and picked.integers and not _is_count(value, scale):
                wrong = "a whole number of 32 bits"
            if wrong:
                where = f"in column {column + 1}"
                raise _UnusableError("number", f"expected {wrong} {where}, got {shown(cell)}")
            values.append(value)
        return utime, values

    def _utime_of(self, cell: bytes) -> int:
        picked = self._picked
        if picked.iso:
            cell = iso_seconds(cell)
        try:
            utime = to_microseconds(cell.strip(b' "'), picked.per_second)
        except ValueError:
            _check_unit(cell, picked.per_second)
            unit = "seconds" if picked.per_second == 1 else f"1/{picked.per_second} s"
            raise _UnusableError(
                "time",
                f"expected a time in {unit} since 1970 in column {picked.columns[0] + 1}, got "
                f"{shown(cell)}",
            ) from None
        if utime > LATEST_S * 1e6:
            _check_unit(cell, picked.per_second)
        return utime

    def _scaled(self, values: Floats) -> Floats:
        """Values as they are wanted. Raises an error where one is not."""
        picked = self._picked
        if picked.scale is not None:
            keys = values[:, : picked.keys]
            values = np.hstack([keys, np.rint(values[:, picked.keys :] * picked.scale)])
        if not np.all(np.isfinite(values)):
            raise ValueError("not finite")
        if not picked.integers:
            return values
        if np.any(values != np.rint(values)) or np.any((values < -INT32) | (values >= INT32)):
            raise ValueError("not whole numbers of 32 bits")
        return values.astype(np.int32)


def _is_count(value: float, scale: float | None) -> bool:
    count = value if scale is None else float(np.rint(value * scale))
    return count.is_integer() and -INT32 <= count < INT32


def _check_unit(cell: bytes, per_second: int) -> None:
    """Raises an error that ends the reading where a time is that of today in a smaller unit."""
    value = float(cell) / per_second if is_number(cell) else 0.0
    for unit, factor in _SMALLER_UNITS:
        if 1e8 * factor < value < LATEST_S / 10 * factor:
            raise _UnusableError(
                "unit",
                f"the time {shown(cell)} is far beyond today: is it in "
                f"{unit if per_second == 1 else 'a smaller unit'}? Give --time-unit "
                + (unit if per_second == 1 else "UNIT")
                + " (in a layout time_unit, also of one source)",
            )


def clean_cells(line: bytes, delimiter: bytes) -> list[bytes]:
    """The cells of a line, without blanks and quotes."""
    cells = [cell.strip().strip(b'"').strip() for cell in line.split(delimiter)]
    if delimiter != b",":  # if the comma does not separate columns, it is the decimal point
        cells = [cell.replace(b",", b".") for cell in cells]
    return cells


def iso_seconds(text: bytes) -> bytes:
    """Seconds since 1970 of a date and time; without a zone, of UTC."""
    when = moment(text.strip().strip(b'"'))
    if when is None:
        raise _UnusableError("time", "expected a date and time such as 2026-01-31T12:00:00.25")
    since = when - datetime(1970, 1, 1, tzinfo=UTC)
    return f"{since.days * 86400 + since.seconds}.{since.microseconds:06d}".encode()


def moment(text: bytes) -> datetime | None:
    """A date and time in ISO 8601; None where it is none."""
    try:
        when = datetime.fromisoformat(text.decode())
    except (ValueError, UnicodeDecodeError):
        return None
    return when if when.tzinfo is not None else when.replace(tzinfo=UTC)


def first_lines(path: Path) -> Iterator[tuple[int, bytes]]:
    """Number and content of the lines that are not blank, the first ones."""
    with path.open("rb") as file:
        for number, line in enumerate(file, start=1):
            text = line.removeprefix(b"\xef\xbb\xbf") if number == 1 else line
            if text.strip():
                yield number, text.strip()
