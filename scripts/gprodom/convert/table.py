"""CSV files of a recording: a time in decimal seconds, then numbers; strict, with line numbers."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from gprodom.arrays import Floats, Ints
from gprodom.convert.source import File
from gprodom.errors import Error
from gprodom.times import to_microseconds


@dataclass(frozen=True)
class Table:
    """Rows sorted by time; rows of equal time keep the order of the file."""

    utime: Ints  # (n,), us since 1970
    values: Floats  # (n, columns after the time)
    out_of_order: int  # rows that stood after a later one
    decimals: int  # most digits after the point in the first value column


def is_number(text: bytes) -> bool:
    """Whether Python can read it as a number."""
    try:
        float(text)
    except ValueError:
        return False
    return True


def _rows(file: File) -> Iterator[tuple[int, list[bytes]]]:
    """Line number and cells of each row that is neither blank nor the header."""
    for number, line in enumerate(file.data.removeprefix(b"\xef\xbb\xbf").splitlines(), start=1):
        if not line.strip():
            continue
        cells = line.split(b",")
        if number == 1 and not is_number(cells[0]):
            continue
        yield number, cells


def shown(text: bytes) -> str:
    """A cell, for an error."""
    whole = text.decode("ascii", "backslashreplace")
    return repr(whole if len(whole) <= 40 else whole[:37] + "...")


def parse(file: File, columns: Sequence[int], what: str, integers: bool = False) -> Table:
    """Reads `file`, whose rows have one of the numbers of columns in `columns`, time included.

    All rows have as many as the first. `what` describes a row in errors. With `integers`, values
    must be whole numbers of 32 bits. Rows whose time goes back are sorted into place and counted.
    """
    times: list[int] = []
    values: list[list[float]] = []
    width = 0
    decimals = 0
    for number, cells in _rows(file):
        where = f"{file.label}:{number}"
        if not width:
            if len(cells) not in columns:
                wanted = either(columns)
                raise Error(f"{where}: expected {wanted} columns ({what}), got {len(cells)}")
            width = len(cells)
        if len(cells) != width:
            raise Error(f"{where}: expected {width} columns ({what}), got {len(cells)}")
        try:
            times.append(to_microseconds(cells[0]))
        except ValueError:
            expected = "a time in seconds since 1970"
            raise Error(f"{where}: expected {expected}, got {shown(cells[0])}") from None
        values.append(_numbers(cells[1:], where, integers))
        decimals = max(decimals, len(cells[1].strip().partition(b".")[2]))
    utime = np.array(times, np.int64)
    order = np.argsort(utime, kind="stable")
    table = np.array(values, np.float64).reshape(len(times), max(width - 1, 0))
    late = int(np.count_nonzero(utime < np.maximum.accumulate(utime))) if len(utime) else 0
    return Table(utime[order], table[order], late, decimals)


def either(counts: Sequence[int]) -> str:
    """Numbers of columns, in words."""
    return f"{counts[0]} or more" if len(counts) > 9 else " or ".join(map(str, counts))


def _numbers(cells: list[bytes], where: str, integers: bool) -> list[float]:
    try:
        row = [float(cell) for cell in cells]
    except ValueError:
        row = []
    if row and math.isfinite(sum(row)) and not any(b"_" in cell for cell in cells):
        if not integers:
            return row
        if all(value.is_integer() and -(2**31) <= value < 2**31 for value in row):
            return row
    for position, cell in enumerate(cells, start=2):
        expected = "a whole number of 32 bits" if integers else "a finite number"
        value = float(cell) if is_number(cell) and b"_" not in cell else math.nan
        whole = value.is_integer() and -(2**31) <= value < 2**31
        if not math.isfinite(value) or (integers and not whole):
            raise Error(f"{where}: expected {expected} in column {position}, got {shown(cell)}")
    return row  # finite numbers whose sum is not
