"""Surveyed markers: points of known position that stood under an antenna of the robot for a while.

A CSV with a line of names: `name`, then `x`, `y`, `z` (m, in `site`) or `latitude`, `longitude`,
`height` (deg, deg, m), `sigma` (m), and `from`, `to`, the times between which the antenna stood
over it, in seconds since 1970 or as 2026-05-12T10:30:00. A marker that was visited twice has two
lines. `antenna` (default 0) says which antenna.
"""

import csv
import math
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

import numpy as np

from gprodom.arrays import Floats
from gprodom.errors import Error
from gprodom.fixes.record import Fixes, Frame, Quality, diagonal
from gprodom.times import to_microseconds

_PLACES = {Frame.SITE: ("x", "y", "z"), Frame.GEODETIC: ("latitude", "longitude", "height")}
_OTHERS = ("name", "sigma", "from", "to")
LONGEST_S = 3600.0  # over a marker


@dataclass(frozen=True)
class Marker:
    """One visit of one marker."""

    name: str
    frame: Frame
    position: tuple[float, float, float]
    sigma: float  # m
    begin: int  # us
    end: int
    antenna: int = 0

    @property
    def middle(self) -> int:
        """Time (us) at which the fix is said to be."""
        return (self.begin + self.end) // 2


def read_markers(path: Path) -> list[Marker]:
    """The visits, in order of time."""
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            rows = csv.DictReader(file, skipinitialspace=True)
            frame = _frame(path, tuple(rows.fieldnames or ()))
            found = [_marker(f"{path}:{rows.line_num}", row, frame) for row in rows]
    except (UnicodeDecodeError, csv.Error) as error:
        raise Error(f"{path}: not a CSV: {error}") from None
    if not found:
        raise Error(f"{path}: holds no markers")
    return sorted(found, key=lambda marker: marker.middle)


def _frame(path: Path, names: tuple[str, ...]) -> Frame:
    missing = [name for name in _OTHERS if name not in names]
    frames = [frame for frame, place in _PLACES.items() if set(place) <= set(names)]
    if missing or len(frames) != 1:
        raise Error(
            f"{path}:1: expected columns {', '.join(_OTHERS)} and either x, y, z or latitude, "
            f"longitude, height; got {', '.join(names) or 'none'}"
        )
    unknown = set(names) - {*_OTHERS, *_PLACES[frames[0]], "antenna"}
    if unknown:
        raise Error(f"{path}:1: unknown column {min(unknown)}")
    return frames[0]


def _marker(where: str, row: dict[str, str | None], frame: Frame) -> Marker:
    def number(name: str, low: float = -math.inf, high: float = math.inf) -> float:
        try:
            value = float(row[name] or "")
        except ValueError:
            value = math.nan
        if not low <= value <= high or math.isinf(value):
            raise Error(f"{where}: {name}: expected a number{_span(low, high)}, got {row[name]!r}")
        return value

    most = (90.0, 180.0) if frame == Frame.GEODETIC else (math.inf, math.inf)
    first, second, third = _PLACES[frame]
    begin, end = (_moment(f"{where}: {name}", row[name] or "") for name in ("from", "to"))
    if not 0 <= end - begin <= LONGEST_S * 1e6:
        raise Error(f"{where}: expected `to` after `from`, by an hour at most")
    return Marker(
        row["name"] or "",
        frame,
        (number(first, -most[0], most[0]), number(second, -most[1], most[1]), number(third)),
        number("sigma", 1e-4, 100.0),
        begin,
        end,
        int(number("antenna", 0, 1000)) if row.get("antenna") else 0,
    )


def _span(low: float, high: float) -> str:
    return "" if math.isinf(low) else f" from {low:g} to {high:g}"


def _moment(where: str, text: str) -> int:
    try:
        return to_microseconds(text.strip().encode())
    except ValueError:
        pass
    try:
        time = datetime.fromisoformat(text.strip())
    except ValueError:
        raise Error(f"{where}: expected seconds since 1970 or a date, got {text!r}") from None
    return round((time if time.tzinfo else time.replace(tzinfo=UTC)).timestamp() * 1e6)


def as_fixes(markers: list[Marker]) -> list[Fixes]:
    """A fix of quality SURVEYED for each visit, apart by antenna."""
    made = []
    for antenna in sorted({marker.antenna for marker in markers}):
        ours = [marker for marker in markers if marker.antenna == antenna]
        sigmas: Floats = np.array([[marker.sigma] * 3 for marker in ours])
        made.append(
            Fixes(
                np.array([marker.middle for marker in ours], np.int64),
                ours[0].frame,
                np.array([marker.position for marker in ours]),
                diagonal(sigmas),
                np.full(len(ours), int(Quality.SURVEYED), np.int64),
                antenna,
            )
        )
    return made
