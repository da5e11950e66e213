"""Picks columns of any table by name or number, in the form that the strict reader expects."""

from __future__ import annotations

import re
from collections.abc import Sequence
from datetime import UTC, datetime

from gprodom.convert.layout import TIME_UNITS, Source
from gprodom.convert.source import File
from gprodom.convert.table import Table, is_number, parse
from gprodom.errors import Error

_RANGE = re.compile(r"(\d+)-(\d+)\Z")
_MOST_NAMES = 20  # of a header, that an error lists


def read_source(source: Source, widths: Sequence[int], what: str, integers: bool = False) -> Table:
    """The source's columns; `widths` and `what` as for `table.parse`."""
    assert source.file is not None
    file = File(str(source.file), source.file.read_bytes())
    picked = _pick(file, source, max(widths))
    table = parse(picked, widths, what, integers, TIME_UNITS[source.time_unit])
    if len(table.utime) < 2:
        raise Error(f"{source.file}: expected rows of {what}")
    return table


def _pick(file: File, source: Source, most: int) -> File:
    """The file with only the source's columns, comma separated; lines keep their numbers."""
    lines = file.data.removeprefix(b"\xef\xbb\xbf").splitlines()
    first = next((i for i, line in enumerate(lines) if line.strip()), len(lines))
    if first == len(lines):
        return File(file.label, b"")
    delimiter = source.delimiter.encode() or _find_delimiter(lines[first])
    header = _cells(lines[first], delimiter)
    where = f"{file.label}:{first + 1}"
    named = _is_header(header, source.time_unit == "iso", where)
    columns = _columns(header, source.columns, named, where) or range(min(len(header), most))
    rows = []
    for number, line in enumerate(lines):
        if not line.strip() or (named and number == first):
            rows.append(b"")
            continue
        cells = _cells(line, delimiter)
        if len(cells) <= max(columns):
            raise Error(
                f"{file.label}:{number + 1}: expected at least {max(columns) + 1} columns, got "
                f"{len(cells)}"
            )
        chosen = [cells[column] for column in columns]
        if source.time_unit == "iso":
            chosen[0] = _iso_seconds(chosen[0], f"{file.label}:{number + 1}")
        rows.append(b",".join(chosen if len(chosen) > 1 else [*chosen, b"0"]))
    return File(file.label, b"\n".join(rows) + b"\n")


def _find_delimiter(line: bytes) -> bytes:
    return next((mark for mark in (b";", b"\t") if mark in line), b",")


def _cells(line: bytes, delimiter: bytes) -> list[bytes]:
    cells = [cell.strip().strip(b'"').strip() for cell in line.split(delimiter)]
    if delimiter != b",":  # if the comma does not separate columns, it is the decimal point
        cells = [cell.replace(b",", b".") for cell in cells]
    return cells


def _is_header(cells: list[bytes], iso: bool, where: str) -> bool:
    """Whether the first line names columns. Raises an error if it has numbers too: then it is not
    clear whether it is data."""
    numbers = [is_number(cell) or (iso and _moment(cell) is not None) for cell in cells]
    if all(numbers):
        counted = [cell.decode() for cell in cells]
        if len(cells) > 2 and counted in (
            [str(i) for i in range(len(cells))],
            [str(i + 1) for i in range(len(cells))],
        ):
            raise Error(f"{where}: the numbers of columns, expected their names or data: delete it")
        return False
    if any(numbers):
        raise Error(
            f"{where}: both numbers and words: expected a header line with names only, or data"
        )
    return True


def _columns(header: list[bytes], wanted: Sequence[str], named: bool, where: str) -> list[int]:
    """Indices of the wanted columns; a name, a number from 1, or a range of numbers."""
    names = [cell.decode("utf-8", "replace") for cell in header] if named else []
    found: list[int] = []
    for text in wanted:
        span = _RANGE.match(text)
        if text in names:
            if names.count(text) > 1:
                raise Error(f"{where}: several columns named {text}: give its number")
            found.append(names.index(text))
        elif span is not None and int(span[1]) <= int(span[2]):
            found.extend(range(int(span[1]) - 1, int(span[2])))
        elif text.isdecimal():
            found.append(int(text) - 1)
        else:
            having = ", ".join(names[:_MOST_NAMES]) or f"{len(header)} without names"
            raise Error(f"{where}: no column {text!r}; it has {having}")
    outside = [column + 1 for column in found if not 0 <= column < len(header)]
    if outside:
        raise Error(f"{where}: no column {outside[0]}; it has {len(header)}")
    return found


def _iso_seconds(text: bytes, where: str) -> bytes:
    """Seconds since 1970 of a date and time; without a zone, of UTC."""
    moment = _moment(text)
    if moment is None:
        raise Error(f"{where}: expected a date and time such as 2026-01-31T12:00:00.25")
    since = moment - datetime(1970, 1, 1, tzinfo=UTC)
    return f"{since.days * 86400 + since.seconds}.{since.microseconds:06d}".encode()


def _moment(text: bytes) -> datetime | None:
    try:
        moment = datetime.fromisoformat(text.decode())
    except (ValueError, UnicodeDecodeError):
        return None
    return moment if moment.tzinfo is not None else moment.replace(tzinfo=UTC)
