"""A map of pipes under a line: where they cross it, and how deep they lie."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from gprodom.arrays import Floats
from gprodom.errors import Error


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


def read_pipes(path: Path) -> PipeMap:
    """A YAML file: `pipes`, a list of {x, depth} in m; if known `wave_speed` in m/s; for a closed
    line its `length` in m."""
    try:
        content: Any = yaml.safe_load(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise Error(f"{path}: {error.strerror}") from None
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        raise Error(f"{path}: {' '.join(str(error).split())}") from None
    if not isinstance(content, dict) or not content.get("pipes"):
        raise Error(f"{path}: expected 'pipes', a list of {{x: M, depth: M}}")
    for key in content:
        if key not in ("pipes", "wave_speed", "length"):
            raise Error(f"{path}: {key}: unknown key; expected pipes, wave_speed or length")
    places = []
    for i, pipe in enumerate(content["pipes"]):
        if not isinstance(pipe, dict) or set(pipe) != {"x", "depth"}:
            raise Error(f"{path}: pipes[{i}]: expected the keys x and depth")
        places.append([_number(pipe[key], f"{path}: pipes[{i}].{key}") for key in ("x", "depth")])
    x, depth = np.array(places).T
    speed = _number(content.get("wave_speed", 1e8), f"{path}: wave_speed")
    length = _number(content.get("length", 0.0), f"{path}: length")
    if np.any(depth <= 0) or not 1e7 < speed < 3e8 or length < 0:
        raise Error(f"{path}: expected depth above 0, wave_speed from 1e7 to 3e8, length 0 or more")
    return PipeMap(x, depth, speed, length)


def _number(value: Any, where: str) -> float:
    try:
        number = float(value)  # YAML 1.1 reads 1e8 as text
    except (TypeError, ValueError):
        number = math.nan
    if not math.isfinite(number):
        raise Error(f"{where}: {value!r}: expected a number")
    return number
