"""A part of a map, chosen by run, by distance, by area or by map."""

import argparse

import numpy as np

from gprodom.arrays import Bools, runs
from gprodom.errors import Error
from gprodom.map.ground import MapFile
from gprodom.options import numbers


def parse_runs(text: str) -> set[int]:
    """Numbers and ranges: 0,2-4."""
    chosen: set[int] = set()
    for part in text.split(","):
        first, _, last = part.partition("-")
        if not first.isdecimal() or (last and not last.isdecimal()) or part.endswith("-"):
            raise argparse.ArgumentTypeError(f"{text!r}: expected runs such as 0,2-4")
        if int(last or first) > 10**6:
            raise argparse.ArgumentTypeError(f"{text!r}: no map has so many runs")
        chosen |= set(range(int(first), int(last or first) + 1))
    return chosen


def parse_distance(text: str) -> tuple[float, float]:
    """FROM:TO, either may be missing."""
    first, colon, last = text.partition(":")
    try:
        found = (float(first or 0), float(last or "inf"))
    except ValueError:
        found = (np.nan, np.nan)
    if not colon or not found[0] < found[1]:
        raise argparse.ArgumentTypeError(f"{text!r}: expected FROM:TO in m, FROM below TO")
    return found


parse_area = numbers(
    "XMIN,YMIN,XMAX,YMAX in m",
    lambda values: len(values) == 4 and values[0] < values[2] and values[1] < values[3],
)


def of_runs(file: MapFile, runs: set[int]) -> Bools:
    """The columns of these runs."""
    first, end = file.runs["first"], file.runs["end"]
    missing = runs - set(range(len(first)))
    if missing:
        raise Error(f"{file.path}: has no run {min(missing)}; its runs are 0 to {len(first) - 1}")
    chosen = np.zeros(len(file.columns["x"]), dtype=bool)
    for run in runs:
        chosen[first[run] : end[run]] = True
    return chosen


def of_distance(file: MapFile, between: tuple[float, float]) -> Bools:
    """The columns between two distances along the stored ground."""
    along = file.ground.spacing * np.arange(len(file.columns["x"]))
    return np.asarray((along >= between[0]) & (along < between[1]))


def of_area(file: MapFile, number: int, area: tuple[float, float, float, float]) -> Bools:
    """The columns of a map inside a rectangle of its frame."""
    x, y, maps = (file.columns[name] for name in ("x", "y", "map"))
    x0, y0, x1, y1 = area
    return np.asarray((maps == number) & (x >= x0) & (x <= x1) & (y >= y0) & (y <= y1))


def cut(file: MapFile, chosen: Bools) -> bytes:
    """The file of the columns that are chosen."""
    if not chosen.any():
        raise Error(f"{file.path}: nothing of it lies there")
    if chosen.all():
        return file.data
    return file.ground.part([(int(first), int(end)) for first, end in runs(chosen)]).to_bytes()
