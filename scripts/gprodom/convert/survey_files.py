"""Survey files of radar makers: lines of traces at even spacing.

Read here: Sensors & Software (DT1 with HD), GSSI (DZT), MALA (RD3 or RD7 with RAD) and Impulse
(IPRB with IPRH), whose layouts are the makers' published ones; and IDS (DT), whose layout is read
off files. Headers are trusted where they do not contradict themselves. A file with fewer traces
than its header states, or with a part of one, was cut short and is refused. One with more was
extended after its header was written, and is read completely.

A DZT may hold several channels, whose traces lie in turn, each with a header of its own. Those who
give each antenna a file of its own (Sensors & Software, MALA, Impulse) need nothing here.
"""

import math
import re
import struct
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from gprodom.arrays import Ints
from gprodom.console import warn
from gprodom.errors import Error
from gprodom.files import also_read
from gprodom.options import numbers

_FOOT = 0.3048  # m
_MAX_SAMPLES = 16_384  # of a trace; the estimator takes no more


@dataclass(frozen=True)
class Line:
    """traces: (n, samples) int32, counts. spacing: m between traces. sample_interval: s.

    time_zero: s from the first sample to when the file says that the wave leaves.
    contradictions: of `spacing` or `sample_interval`, what the header says of it, where it says one
    thing and another.
    """

    traces: Ints
    spacing: float
    sample_interval: float
    time_zero: float
    contradictions: Mapping[str, str] = field(default_factory=dict)


def decide(line: Line, path: Path, **given: float | None) -> Line:
    """The line with what is `given` of it (`spacing`, `sample_interval`; None: nothing) in place of
    what its header says. Of what the header contradicts itself in, something must be given."""
    for name, value in given.items():
        said = line.contradictions.get(name)
        option = f"--{name.replace('_', '-')}"
        if said and value is None:
            raise Error(f"{path}: the header contradicts itself: {said}; decide with {option}")
        if said:
            warn(f"{path}: the header contradicts itself: {said}; {option} {value:g} decides")
    known: dict[str, Any] = {name: value for name, value in given.items() if value is not None}
    return replace(line, **known)


def mean_frequency(lines: Ints, sample_interval: float) -> float:
    """Hz, by energy: of the echoes in (..., n, samples), the traces without the mean one."""
    echoes = lines - lines.mean(axis=-2, keepdims=True)
    energy = (np.abs(np.fft.rfft(echoes)) ** 2).reshape(-1, lines.shape[-1] // 2 + 1).mean(axis=0)
    frequency = np.fft.rfftfreq(lines.shape[-1], sample_interval)
    return float(energy @ frequency / max(energy.sum(), 1e-300))


def read_line(path: Path) -> Line:
    """Reads a line, the first of its file's channels, as `read_lines` does."""
    return read_lines(path)[0]


def chosen(path: Path, channels: Sequence[int]) -> dict[int, Line]:
    """The lines of these channels of a file, by channel, in the order given."""
    lines = read_lines(path)
    if max(channels) >= len(lines):
        counted = f"{len(lines)} channels" if len(lines) > 1 else "one channel"
        raise Error(
            f"{path}: holds {counted}, 0 to {len(lines) - 1}; --channels asks for {max(channels)}"
        )
    return {channel: lines[channel] for channel in channels}


channel_numbers = numbers(  # the argument of --channels
    "channels from 0, each once: 0,1",
    lambda values: min(values) >= 0 and len(set(values)) == len(values),
    int,
)


def read_lines(path: Path) -> list[Line]:
    """Reads the lines of all channels in the format of the file name's ending; the header is
    expected beside the file."""
    reader = _READERS.get(path.suffix.lower())
    if reader is None:
        known = ", ".join(sorted(_READERS)).upper()
        raise Error(f"{path}: unknown kind {path.suffix or '(none)'}; expected one of {known}")
    if not path.is_file():
        raise Error(f"{path}: no such file")
    read = reader(path)
    lines = read if isinstance(read, list) else [read]
    for line in lines:
        if len(line.traces) < 2:
            raise Error(f"{path}: expected at least two traces, got {len(line.traces)}")
        for name in ("spacing", "sample_interval"):
            if not 0 < getattr(line, name) < math.inf:
                raise Error(f"{path}: the header gives no {name.replace('_', ' ')}")
    return lines


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
    return _by_frequency(path, header, path.suffix.lower() == ".rd7", "SIGNAL POSITION")


def _read_impulse(path: Path) -> Line:
    header = _Header(_beside(path, ".iprh"))
    return _by_frequency(path, header, header.number("DATA VERSION", 16) == 32, "ZERO LEVEL")


def _by_frequency(path: Path, header: _Header, wide: bool, zero: str) -> Line:
    """wide: samples of 32 bits. zero: key of the sample at which the wave leaves."""
    samples = header.samples("SAMPLES")
    interval = 1e-6 / header.positive("FREQUENCY")  # of sampling, MHz
    time_zero = header.number(zero, 0.0) * interval
    spacing = header.number("DISTANCE INTERVAL")
    traces = _rows(path, "<i4" if wide else "<i2", samples, header.number("LAST TRACE", 0))
    return Line(traces, spacing, interval, time_zero)


_GSSI_HEADER = 1024  # bytes, of each channel


def _read_dzt(path: Path) -> list[Line]:
    data = path.read_bytes()
    if len(data) < _GSSI_HEADER:
        raise Error(f"{path}: expected a GSSI header of 1024 bytes, got {len(data)} bytes")
    _, offset, samples, bits, _ = struct.unpack_from("<4Hh", data, 0)
    _, per_metre, _, _, window = struct.unpack_from("<5f", data, 10)
    (channels,) = struct.unpack_from("<H", data, 52)
    kinds = {8: "<u1", 16: "<u2", 32: "<i4"}
    if bits not in kinds or not 2 <= samples <= _MAX_SAMPLES:
        raise Error(f"{path}: not a GSSI file: {bits} bits, {samples} samples a trace")
    channels = max(channels, 1)
    start = offset if offset >= _GSSI_HEADER else _GSSI_HEADER * max(offset, 1)
    # Files with several channels have as many headers, then their traces in turn.
    start = max(start, _GSSI_HEADER * channels)
    if start > len(data):
        raise Error(f"{path}: the header says that traces begin beyond the end of the file")
    width = samples * bits // 8 * channels
    count = _whole_traces(path, len(data) - start, width)
    body = np.frombuffer(data, kinds[bits], count * width * 8 // bits, start)
    spacing = 1 / per_metre if per_metre > 0 else 0.0
    lines = []
    for channel in range(channels):
        traces = body.reshape(count, channels, samples)[:, channel].astype(np.int64)
        if bits < 32:
            traces = traces - (1 << (bits - 1))
        traces[:, :2] = traces[:, 2:3]  # the first two are marks, not samples
        if channel:
            window = _dzt_window(path, data, channel, samples, bits, window)
        lines.append(Line(traces.astype(np.int32), spacing, window * 1e-9 / samples, 0.0))
    return lines


def _dzt_window(
    path: Path, data: bytes, channel: int, samples: int, bits: int, before: float
) -> float:
    """Of a further channel, ns, by its own header; that of the channel before, where it is empty.

    Antennas of two frequencies in one case have a window each.
    """
    start = _GSSI_HEADER * channel
    _, _, own_samples, own_bits, _ = struct.unpack_from("<4Hh", data, start)
    if not own_samples:
        return before
    if (own_samples, own_bits) != (samples, bits):
        raise Error(
            f"{path}: channel {channel} has {own_samples} samples of {own_bits} bits a trace, "
            f"channel 0 {samples} of {bits}: they cannot lie in turn"
        )
    (window,) = struct.unpack_from("<f", data, start + 26)
    return float(window)


# Of an IDS file's row H: where the numbers begin, and the characters of each; which they are, read
# off files whose settings are known.
_IDS_NUMBERS, _IDS_WIDTH, _IDS_COUNT = 48, 16, 10
_IDS_WINDOW, _IDS_PER_METRE, _IDS_STEP, _IDS_NOMINAL, _IDS_INTERVAL = 2, 4, 5, 6, 9


def _read_ids(path: Path) -> Line:
    """Rows of one width, which the first row tells. Each begins with its kind: R is a trace of
    int16, H the numbers, A... the antennas, S the settings in words."""
    data = path.read_bytes()
    width = int.from_bytes(data[4:6], "little")
    if data[:1] != b"V" or width < _IDS_NUMBERS + _IDS_COUNT * _IDS_WIDTH:
        raise Error(f"{path}: not an IDS file: it does not begin with a row V that tells its width")
    count = _whole_traces(path, len(data), width)
    rows = np.frombuffer(data[: count * width], np.uint8).reshape(count, width)
    texts = [bytes(row) for row in rows if row[0] != ord("R")]
    head = next((text for text in texts if text[:1] == b"H"), None)
    if head is None:
        raise Error(f"{path}: not an IDS file: it has no row H with the number of samples")
    counted, samples = struct.unpack_from("<2I", head, 8)
    channels = re.search(rb"N_CHANNEL= *(\d+)", b" ".join(texts))
    if channels is not None and int(channels[1]) != 1:
        raise Error(f"{path}: {int(channels[1])} channels; only files of one channel are read")
    if not 2 <= samples <= _MAX_SAMPLES or 4 + 2 * samples != width:
        raise Error(
            f"{path}: rows of {width} bytes cannot hold the {samples} samples of the header"
        )
    traces = np.ascontiguousarray(rows[rows[:, 0] == ord("R"), 4:]).view("<i2").astype(np.int32)
    if len(traces) < counted:
        raise Error(
            f"{path}: cut short: the header counts {counted} traces, the file holds {len(traces)}; "
            "copy it anew"
        )
    if len(traces) < 2:
        raise Error(f"{path}: expected at least two traces, got {len(traces)}")
    numbers = _ids_numbers(path, head)
    per_metre = numbers[_IDS_PER_METRE]
    steps = {
        f"{per_metre:g} traces a metre ({1e3 / per_metre:.4g} mm)": 1 / per_metre,
        f"a step of {1e3 * numbers[_IDS_STEP]:.4g} mm": numbers[_IDS_STEP],
        f"a nominal step of {1e3 * numbers[_IDS_NOMINAL]:.4g} mm": numbers[_IDS_NOMINAL],
    }
    by_window, interval = numbers[_IDS_WINDOW] / samples, numbers[_IDS_INTERVAL]
    at_window, at_interval = (mean_frequency(traces, each) * 1e-9 for each in (by_window, interval))
    intervals = {
        f"{samples} samples in {1e9 * numbers[_IDS_WINDOW]:g} ns ({by_window:g} s)": by_window,
        f"a sample interval of {interval:g} s": interval,
    }
    contradictions = {
        "spacing": _differing(steps),
        "sample_interval": _differing(intervals, _ids_antenna(texts, at_window, at_interval)),
    }
    return Line(traces, 1 / per_metre, by_window, 0.0, contradictions)


def _ids_numbers(path: Path, head: bytes) -> list[float]:
    numbers = []
    for i in range(_IDS_COUNT):
        start = _IDS_NUMBERS + i * _IDS_WIDTH
        try:
            numbers.append(float(head[start : start + _IDS_WIDTH]))
        except ValueError:
            numbers.append(math.nan)
    for i in (_IDS_WINDOW, _IDS_PER_METRE, _IDS_STEP, _IDS_NOMINAL, _IDS_INTERVAL):
        if not 0 < numbers[i] < math.inf:
            raise Error(f"{path}: number {i + 1} of row H: expected more than 0")
    return numbers


def _ids_antenna(texts: list[bytes], at_window: float, at_interval: float) -> str:
    """What the echoes' frequencies (GHz), with the one interval and the other, say beside that of
    the antenna (its row ends with MHz)."""
    row = next((text for text in texts if text[:3] == b"ATX"), b"")
    stated = re.search(rb"(\d+)[ \0]*$", row)
    antenna = f", of an antenna of {int(stated[1]) * 1e-3:g} GHz" if stated else ""
    return f" (echoes of {at_window:.2g} or {at_interval:.2g} GHz{antenna})"


def _differing(stated: Mapping[str, float], more: str = "") -> str:
    """What is stated, where it differs by more than its digits do; otherwise nothing."""
    values = list(stated.values())
    return "" if max(values) < 1.001 * min(values) else " beside ".join(stated) + more


_READERS: dict[str, Callable[[Path], Line | list[Line]]] = {
    ".dt1": _read_dt1,
    ".dzt": _read_dzt,
    ".rd3": _read_mala,
    ".rd7": _read_mala,
    ".iprb": _read_impulse,
    ".dt": _read_ids,
}
SUFFIXES = frozenset(_READERS)  # of files that `read_lines` reads
