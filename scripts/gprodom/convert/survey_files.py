"""Survey files of radar makers: lines of traces at even spacing.

Read here: Sensors & Software (DT1 with HD), GSSI (DZT), MALA (RD3 or RD7 with RAD) and Impulse
(IPRB with IPRH); the layouts are the makers' published ones. Headers are trusted. A file
with fewer traces than its header states, or with a part of one, was cut short and is refused. One
with more was extended after its header was written, and is read completely.
"""

from __future__ import annotations

import math
import re
import struct
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from gprodom.arrays import Ints
from gprodom.errors import Error
from gprodom.files import also_read

_FOOT = 0.3048  # m
_MAX_SAMPLES = 16_384  # of a trace; the estimator takes no more


@dataclass(frozen=True)
class Line:
    """traces: (n, samples) int32, counts. spacing: m between traces. sample_interval: s.

    time_zero: s from the first sample to when the file says that the wave leaves.
    """

    traces: Ints
    spacing: float
    sample_interval: float
    time_zero: float


def read_line(path: Path) -> Line:
    """Reads a line in the format of its file name's ending; the header is expected beside it."""
    reader = _READERS.get(path.suffix.lower())
    if reader is None:
        known = ", ".join(sorted(_READERS)).upper()
        raise Error(f"{path}: unknown kind {path.suffix or '(none)'}; expected one of {known}")
    if not path.is_file():
        raise Error(f"{path}: no such file")
    line = reader(path)
    if len(line.traces) < 2:
        raise Error(f"{path}: expected at least two traces, got {len(line.traces)}")
    for name in ("spacing", "sample_interval"):
        if not 0 < getattr(line, name) < math.inf:
            raise Error(f"{path}: the header gives no {name.replace('_', ' ')}")
    return line


def _beside(path: Path, suffix: str) -> Path:
    for candidate in (path.with_suffix(suffix), path.with_suffix(suffix.upper())):
        if candidate.is_file():
            also_read(candidate)
            return candidate
    raise Error(f"{path}: expected its header {path.with_suffix(suffix).name} beside it")


class _Header:
    """Lines of KEY = VALUE or KEY: VALUE, numbers asked for by key."""

    def __init__(self, path: Path) -> None:
        self._path = path
        text = path.read_text(encoding="latin-1")
        found = re.findall(r"^\s*([^=:\r\n]+?)\s*[=:]\s*(.*?)\s*$", text, re.MULTILINE)
        self._values: dict[str, str] = {key.upper(): value for key, value in found}

    def text(self, key: str) -> str:
        return self._values.get(key, "")

    def number(self, key: str, default: float | None = None) -> float:
        value = self._values.get(key)
        if value is None:
            if default is None:
                raise Error(f"{self._path}: {key} is missing")
            return default
        try:
            number = float(value.split()[0])
        except (ValueError, IndexError):
            number = math.nan
        if not math.isfinite(number):
            raise Error(f"{self._path}: {key}: {value!r}: expected a number")
        return number

    def positive(self, key: str) -> float:
        value = self.number(key)
        if value <= 0:
            raise Error(f"{self._path}: {key}: {value:g}: expected more than 0")
        return value

    def samples(self, key: str) -> int:
        value = self.number(key)
        if not 2 <= value <= _MAX_SAMPLES:
            raise Error(f"{self._path}: {key}: {value:g}: expected 2 to {_MAX_SAMPLES}")
        return int(value)


def _whole_traces(path: Path, size: int, width: int, counted: float = 0) -> int:
    """Number of traces of `width` bytes in `size` bytes; the header states `counted`.

    Refuses a file that ends before its last trace does.
    """
    count, rest = divmod(size, width)
    if count < counted:
        raise Error(
            f"{path}: cut short: the header counts {counted:.0f} traces, the file holds {count}; "
            "copy it anew, or correct the count in the header"
        )
    if count and rest:
        raise Error(
            f"{path}: cut short: after {count} traces of {width} bytes there are {rest} bytes more"
        )
    return count


def _rows(path: Path, kind: str, samples: int, counted: float = 0, header_bytes: int = 0) -> Ints:
    """Traces (n, samples) as they lie in the file, each after `header_bytes`."""
    width = header_bytes + samples * np.dtype(kind).itemsize
    data = path.read_bytes()
    count = _whole_traces(path, len(data), width, counted)
    table = np.frombuffer(data[: count * width], np.uint8).reshape(count, width)
    values = np.ascontiguousarray(table[:, header_bytes:]).view(kind)
    return np.asarray(values, np.int64).astype(np.int32)


def _read_dt1(path: Path) -> Line:
    header = _Header(_beside(path, ".hd"))
    samples = header.samples("NUMBER OF PTS/TRC")
    unit = _FOOT if header.text("POSITION UNITS").lower().startswith("f") else 1.0
    interval = header.number("TOTAL TIME WINDOW") * 1e-9 / samples
    return Line(
        _rows(path, "<i2", samples, header.number("NUMBER OF TRACES", 0), header_bytes=128),
        abs(header.number("STEP SIZE USED")) * unit,
        interval,
        header.number("TIMEZERO AT POINT", 0.0) * interval,
    )


def _read_mala(path: Path) -> Line:
    header = _Header(_beside(path, ".rad"))
    samples = header.samples("SAMPLES")
    kind = "<i4" if path.suffix.lower() == ".rd7" else "<i2"
    interval = 1e-6 / header.positive("FREQUENCY")  # of sampling, MHz
    zero = header.number("SIGNAL POSITION", 0.0) * interval
    spacing = header.number("DISTANCE INTERVAL")
    traces = _rows(path, kind, samples, header.number("LAST TRACE", 0))
    return Line(traces, spacing, interval, zero)


def _read_impulse(path: Path) -> Line:
    header = _Header(_beside(path, ".iprh"))
    samples = header.samples("SAMPLES")
    kind = "<i4" if header.number("DATA VERSION", 16) == 32 else "<i2"
    interval = 1e-6 / header.positive("FREQUENCY")
    zero = header.number("ZERO LEVEL", 0.0) * interval
    spacing = header.number("DISTANCE INTERVAL")
    traces = _rows(path, kind, samples, header.number("LAST TRACE", 0))
    return Line(traces, spacing, interval, zero)


def _read_dzt(path: Path) -> Line:
    data = path.read_bytes()
    if len(data) < 1024:
        raise Error(f"{path}: expected a GSSI header of 1024 bytes, got {len(data)} bytes")
    _, offset, samples, bits, _ = struct.unpack_from("<4Hh", data, 0)
    _, per_metre, _, _, window = struct.unpack_from("<5f", data, 10)
    (channels,) = struct.unpack_from("<H", data, 52)
    kinds = {8: "<u1", 16: "<u2", 32: "<i4"}
    if bits not in kinds or not 2 <= samples <= _MAX_SAMPLES:
        raise Error(f"{path}: not a GSSI file: {bits} bits, {samples} samples a trace")
    channels = max(channels, 1)
    start = offset if offset >= 1024 else 1024 * max(offset, 1)
    # Files with several channels have as many headers, then their traces in turn.
    start = max(start, 1024 * channels)
    if start > len(data):
        raise Error(f"{path}: the header says that traces begin beyond the end of the file")
    width = samples * bits // 8 * channels
    count = _whole_traces(path, len(data) - start, width)
    body = np.frombuffer(data, kinds[bits], count * width * 8 // bits, start)
    traces = body.reshape(count, channels, samples)[:, 0].astype(np.int64)
    if bits < 32:
        traces = traces - (1 << (bits - 1))
    traces[:, :2] = traces[:, 2:3]  # the first two are marks, not samples
    spacing = 1 / per_metre if per_metre > 0 else 0.0
    return Line(traces.astype(np.int32), spacing, window * 1e-9 / samples, 0.0)


_READERS: dict[str, Callable[[Path], Line]] = {
    ".dt1": _read_dt1,
    ".dzt": _read_dzt,
    ".rd3": _read_mala,
    ".rd7": _read_mala,
    ".iprb": _read_impulse,
}
SUFFIXES = frozenset(_READERS)  # of files that `read_line` reads
