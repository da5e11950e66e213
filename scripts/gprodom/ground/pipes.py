"""A map of pipes under a line: where they cross it, and how deep they lie."""

from __future__ import annotations  # `read_section` reads them as text

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from gprodom.arrays import Floats
from gprodom.errors import Error
from gprodom.ground.scene import read_mapping, read_section


@dataclass(frozen=True)
class PipeMap:
    """x (n,), depth (n,), m; wave_speed: m/s; length: m after which the line closes, 0: it does
    not."""

    x: Floats
    depth: Floats
    wave_speed: float = 1e8
    length: float = 0.0

    def apart(self, difference: Floats) -> Floats:
        """Of places along the line, the shorter way round where it closes."""
        half = self.length / 2
        return (difference + half) % self.length - half if self.length else difference


@dataclass(frozen=True)
class _Crossing:
    x: float
    depth: float


@dataclass(frozen=True)
class _Content:
    pipes: Any
    wave_speed: float = 1e8
    length: float = 0.0


def read_pipes(path: Path) -> PipeMap:
    """A YAML file: `pipes`, a list of {x, depth} in m; if known `wave_speed` in m/s; for a closed
    line its `length` in m."""
    content = read_section(_Content, read_mapping(path), str(path))
    if not isinstance(content.pipes, list) or not content.pipes:
        raise Error(f"{path}: pipes: expected a list of {{x: M, depth: M}}")
    found = [
        read_section(_Crossing, pipe, f"{path}: pipes[{i}]") for i, pipe in enumerate(content.pipes)
    ]
    x, depth = np.array([[pipe.x, pipe.depth] for pipe in found]).T
    numbers = np.array([*x, *depth, content.length])
    if not (np.all(np.isfinite(numbers)) and np.all(depth > 0) and content.length >= 0):
        raise Error(f"{path}: expected finite x, depth above 0, and length 0 or more")
    if not 1e7 < content.wave_speed < 3e8:
        raise Error(f"{path}: wave_speed: expected 1e7 to 3e8 m/s")
    return PipeMap(x, depth, content.wave_speed, content.length)
