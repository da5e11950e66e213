"""Figures by name, and how numbers and tables are written."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from statistics import fmean

from figures import Report

Row = Sequence[object]


class Figures:
    """Values by bench and name."""

    def __init__(self, reports: Mapping[str, Report]) -> None:
        self._values = {
            name: {key: figure.value for key, figure in report.figures().items()}
            for name, report in reports.items()
        }

    def of(self, bench: str, name: str) -> float | None:
        """None where it was not measured."""
        return self._values.get(bench, {}).get(name)

    def each(self, bench: str, *names: str) -> list[float | None]:
        """Of several names."""
        return [self.of(bench, name) for name in names]

    def parts(self, bench: str, number: int = 0) -> list[str]:
        """The parts of that number of the names of a bench's figures, in their order."""
        names = [name.split("/") for name in self._values.get(bench, {})]
        return list(dict.fromkeys(parts[number] for parts in names if len(parts) > number))

    def all(self, bench: str, names: Iterable[str]) -> list[float]:
        """Those of the names that were measured."""
        return [value for value in self.each(bench, *names) if value is not None]

    def mean(self, bench: str, rows: Iterable[str], key: str) -> float | None:
        """Of a key over rows."""
        found = self.all(bench, (f"{row}/{key}" for row in rows))
        return fmean(found) if found else None

    def total(self, bench: str, rows: Iterable[str], key: str) -> float:
        """Of a key over rows."""
        return sum(self.all(bench, (f"{row}/{key}" for row in rows)))

    def greatest(self, bench: str, rows: Iterable[str], key: str) -> float | None:
        """Of a key over rows."""
        return max(self.all(bench, (f"{row}/{key}" for row in rows)), default=None)


def metres(value: float | None) -> str:
    """With millimetres."""
    return "" if value is None else f"{value:.3f}"


def plain(value: float | None, digits: int = 2) -> str:
    """With so many digits after the point."""
    return "" if value is None else f"{value:.{digits}f}"


def whole(value: float | None) -> str:
    """A count."""
    return "" if value is None else f"{value:.0f}"


def table(header: Row, rows: Iterable[Row]) -> str:
    """In Markdown."""
    lines = [header, ["---"] * len(header), *rows]
    return "\n".join(f"| {' | '.join(str(cell) for cell in line)} |" for line in lines)
