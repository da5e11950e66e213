"""Any table of a robot's: finds its delimiter, header and columns, and reads one sensor's rows."""

import re
import shutil
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from gprodom.console import warn
from gprodom.convert.layout import SOURCES, TIME_UNITS, Layout, Source
from gprodom.convert.rows import COMMENTS, Picked, Rows, clean_cells, first_lines, moment, read_rows
from gprodom.convert.table import Table, either, is_number
from gprodom.errors import Error
from gprodom.files import temporary_folder

_RANGE = re.compile(r"(\d+)-(\d+)\Z")
_MOST_NAMES = 20  # of a header, that an error lists


def read_source(
    source: Source,
    widths: Sequence[int],
    what: str,
    integers: bool = False,
    strict: bool = False,
    scale: float | None = None,
    keys: int = 0,
) -> Table:
    """The source's columns, in order of time, and warnings of what was found on the way.

    widths: possible numbers of columns, time included; `what` they are. integers: whole numbers of
    32 bits. scale: counts per unit of the values, which are then rounded; but not the
    first `keys` of them.
    """
    path = source.file
    assert path is not None
    if not path.exists() or path.is_dir():
        raise Error(f"{path}: no such file")
    with temporary_folder() as folder:
        file = path
        if not path.is_file():  # a pipe can be read only once
            file = folder / "table"
            with path.open("rb") as pipe, file.open("wb") as spool:
                shutil.copyfileobj(pipe, spool)
        iso = source.time_unit == "iso"
        number, header, cells, delimiter = _first_row(path, file, source.delimiter.encode(), iso)
        where = f"{path}:{number}"
        columns = _columns(cells, source.columns, header is not None, where)
        if not columns:
            columns = list(range(min(len(cells), max(widths))))
        if len(columns) not in widths:
            raise Error(f"{where}: expected {either(widths)} columns ({what}), got {len(columns)}")
        picked = Picked(
            path, file, delimiter, tuple(columns), len(cells), header, iso,
            TIME_UNITS[source.time_unit], scale, integers, keys,
        )  # fmt: skip
        rows = read_rows(picked, strict)
    _tell_faults(path, what, rows)
    if len(rows.utime) < 2:
        raise Error(f"{path}: expected rows of {what}")
    return _in_order(path, what, rows)


def read_named(
    layout: Layout, name: str, widths: Sequence[int], strict: bool, **options: Any
) -> Table:
    """The table of a source, by its name."""
    what = ", ".join(filter(None, ("time", SOURCES[name])))
    return read_source(layout.sources[name], widths, what, strict=strict, **options)


def _first_row(
    path: Path, file: Path, delimiter: bytes, iso: bool
) -> tuple[int, int | None, list[bytes], bytes]:
    """The number of the line with the names, or without one of the first row; the former again or
    None; its cells; the delimiter. Names may stand in a comment before the first row."""
    named: tuple[int, bytes] | None = None
    for number, line in first_lines(file):
        mark = next((mark for mark in COMMENTS if line.startswith(mark)), None)
        if mark is not None:
            named = number, line.lstrip(mark).strip()
            continue
        delimiter = delimiter or _find_delimiter(line)
        cells = clean_cells(line, delimiter)
        if _is_header(cells, iso, f"{path}:{number}"):
            return number, number, cells, delimiter
        if named is not None:
            names = clean_cells(named[1], delimiter)
            if len(names) == len(cells) and not any(map(is_number, names)):
                return named[0], named[0], names, delimiter
        return number, None, cells, delimiter
    raise Error(f"{path}: holds no rows")


def _find_delimiter(line: bytes) -> bytes:
    return next((mark for mark in (b";", b"\t") if mark in line), b",")


def _is_header(cells: list[bytes], iso: bool, where: str) -> bool:
    """Whether the first line names columns. Raises an error if it has numbers too: then it is not
    clear whether it is data."""
    known = [cell for cell in cells if cell]  # a slower sensor's are empty
    numbers = [is_number(cell) or (iso and moment(cell) is not None) for cell in known]
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


def _tell_faults(path: Path, what: str, rows: Rows) -> None:
    """Warns of rows left out; raises `Error` where they are more than the others: then the table is
    read in a wrong way, or this is none of the sensor."""
    if not rows.faults:
        return
    worst = max(rows.faults, key=lambda kind: (kind != "comment", len(rows.faults[kind])))
    number, words = rows.faults[worst][0]
    if rows.unusable > len(rows.utime):
        hint = ""
        if "a whole number" in words:
            hint = "; samples in volts or scaled to 1 become counts by --gpr-scale COUNTS_PER_UNIT"
        raise Error(f"{path}:{number}: {words}{hint}")
    left = sum(map(len, rows.faults.values()))
    comments = len(rows.faults.get("comment", ()))
    warn(
        f"{path}: {left} lines left out, {comments} of them comments, of {left + len(rows.utime)} "
        f"with {what.split(', ', 1)[-1]}; the first: line {number}, {words} (--strict refuses such "
        "a table)"
    )


def _in_order(path: Path, what: str, rows: Rows) -> Table:
    """Sorted by time, without rows that repeat the one before; both are told."""
    order = np.argsort(rows.utime, kind="stable")
    late = int(np.count_nonzero(rows.utime < np.maximum.accumulate(rows.utime)))
    utime, values = rows.utime[order], rows.values[order]
    same = utime[1:] == utime[:-1]
    again = same & (np.all(values[1:] == values[:-1], axis=1) if values.shape[1] else False)
    kept = np.concatenate([[True], ~again])
    shared = int(np.count_nonzero(same & ~again))
    found = [
        (late, "rows stood after later ones: sorted into place"),
        (int(again.sum()), "rows repeat another, time and values: left out"),
        (shared, "rows have the time of another, with other values: kept"),
    ]
    said = [f"{count} {words}" for count, words in found if count]
    if said:
        warn(f"{path}: {what.split(', ', 1)[-1]}: {len(utime)} rows; {'; '.join(said)}")
    return Table(utime[kept], values[kept], late, 0)
