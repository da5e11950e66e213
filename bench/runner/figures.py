"""What a bench measures: the one JSON form of all benches."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Literal

from gprodom.console import to_json
from gprodom.files import write_bytes

# "near 2": of a NEES of x and y. "": neither is better, as of a count.
Better = Literal["lower", "higher", "near 2", ""]


@dataclass(frozen=True)
class Figure:
    """A measured number. name: parts with slashes, from the general to the particular. spread: one
    standard deviation by which it differs from run to run; None where it does not."""

    name: str
    value: float | None
    unit: str
    better: Better
    spread: float | None = None


@dataclass(frozen=True)
class Measured:
    """The figures of one job, and of what they are. data: SHA-256 by file. key: the hash of
    program, data and arguments by which it is kept."""

    job: str
    command: str
    commit: str
    date: str
    machine: str
    seconds: float
    data: dict[str, str]
    key: str
    figures: tuple[Figure, ...]

    @classmethod
    def of(cls, content: Mapping[str, Any]) -> Measured:
        """From JSON."""
        figures = tuple(Figure(**each) for each in content["figures"])
        return cls(**{**content, "figures": figures})


@dataclass(frozen=True)
class Report:
    """A bench: its jobs' figures, and what failed of it."""

    name: str
    title: str
    jobs: tuple[Measured, ...]
    failed: dict[str, str]

    def figures(self) -> dict[str, Figure]:
        """By name."""
        return {figure.name: figure for job in self.jobs for figure in job.figures}

    def save(self, folder: Path) -> Path:
        """Writes NAME.json, a figure a line."""
        path = folder / f"{self.name}.json"
        text = _FIGURE.sub(_on_one_line, to_json(_short(asdict(self))))
        write_bytes(path, f"{text}\n".encode())
        return path


_FIGURE = re.compile(r"\{\s*\"name\": [^{}]*\"unit\"[^{}]*\}")


def _on_one_line(match: re.Match[str]) -> str:
    return re.sub(r"\s*\n\s*", " ", match[0])


def _short(content: Any) -> Any:
    """Numbers with seven digits, of which nobody needs more."""
    if isinstance(content, dict):
        return {key: _short(value) for key, value in content.items()}
    if isinstance(content, (list, tuple)):
        return [_short(each) for each in content]
    return float(f"{content:.7g}") if isinstance(content, float) else content


def read_reports(folder: Path) -> dict[str, Report]:
    """What `Report.save` has written there, by the name of the bench."""
    reports = {}
    for path in sorted(folder.glob("*.json")):
        content = json.loads(path.read_text(encoding="utf-8"))
        jobs = tuple(Measured.of(job) for job in content["jobs"])
        name = content["name"]
        reports[name] = Report(name, content["title"], jobs, content["failed"])
    return reports


# ---- from what a bench prints with --json ----


@dataclass(frozen=True)
class Unit:
    """Of a value, and which way is better. spread: key of its standard deviation in the same row,
    or a share of the value (of a time, which differs from run to run)."""

    unit: str
    better: Better
    spread: str | float | None = None


METRES, ERROR_M = Unit("m", ""), Unit("m", "lower")
SECONDS = Unit("s", "lower")
NEES = Unit("", "near 2")
COUNT, FEWER, MORE = Unit("", ""), Unit("", "lower"), Unit("", "higher")
TIME_SPREAD = 0.15  # of a time measured on a machine that does other things besides

Read = Callable[[Any], Iterator[Figure]]


def each(unit: Unit, *keys: str) -> dict[str, Unit]:
    """The same unit of several keys."""
    return dict.fromkeys(keys, unit)


def of_row(name: str, row: Mapping[str, Any], values: Mapping[str, Unit]) -> Iterator[Figure]:
    """NAME/KEY for each of `values` that the row has."""
    for key, unit in values.items():
        if row.get(key) is None:
            continue
        value = float(row[key])
        spread = unit.spread
        if isinstance(spread, str):
            spread = row.get(spread)
        elif spread is not None:
            spread = abs(value) * spread
        yield Figure(f"{name}/{key}" if name else key, value, unit.unit, unit.better, spread)


def one_row(values: Mapping[str, Unit]) -> Read:
    """Figures of a bench that prints one object."""
    return lambda content: of_row("", content, values)


def by_row(name: Callable[[Mapping[str, Any]], str], values: Mapping[str, Unit]) -> Read:
    """Figures of a list of rows, of names that are made of each."""
    return lambda content: (figure for row in content for figure in of_row(name(row), row, values))


def by_name(values: Mapping[str, Unit]) -> Read:
    """Figures of rows by name, and of each that has an error, that it failed."""

    def read(content: Any) -> Iterator[Figure]:
        for name, row in content.items():
            if "error" in row:
                yield Figure(f"{name}/failed", 1.0, "", "lower")
            yield from of_row(name, row, values)

    return read
