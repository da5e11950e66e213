"""A map file as arrays. Its reader, with all its checks, is the estimator's own."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from gprodom import rotation
from gprodom.arrays import Bools, Floats, Ints
from gprodom.errors import Error, UsageError
from gprodom.export.paths import moment
from gprodom.map.site import site_facts
from gprodom.trajectory import Trajectory

if TYPE_CHECKING:
    from gprodom._core import GroundMap

PATH_ERRORS = ("m_per_root_m", "rad_per_root_m", "scale")
NOT_IN_VERSION_1 = ("identity", "parents", "sessions")


@dataclass(frozen=True)
class MapFile:
    """A map file that was read whole and found sound."""

    path: Path
    data: bytes
    ground: GroundMap

    @cached_property
    def runs(self) -> dict[str, Any]:
        """Stretches driven one way: first, end (columns), direction, distance (m)."""
        return dict(self.ground.runs())

    @cached_property
    def places(self) -> dict[str, Any]:
        """Poses of the body: column, time (ns), distance (m), x, y (m), yaw (rad), map."""
        return dict(self.ground.places())

    @cached_property
    def columns(self) -> dict[str, Any]:
        """Of each column x, y (m; NaN: not known) and map (-1: not known)."""
        return dict(self.ground.columns())

    @cached_property
    def maps(self) -> list[int]:
        """Numbers of the maps in the file, whose frames are not related."""
        return [int(number) for number in np.unique(self.places["map"])]

    @property
    def length_m(self) -> float:
        """Metres of ground that are stored."""
        return len(self.columns["x"]) * self.ground.spacing

    def one_map(self, number: int | None) -> int:
        """`number`, where the file has it; else the only map of the file."""
        if not self.maps:
            raise Error(f"{self.path}: holds no ground whose place is known")
        if number is None and len(self.maps) > 1:
            raise UsageError(
                f"{self.path}: holds {len(self.maps)} maps whose frames are not related: give "
                f"--map, one of {', '.join(map(str, self.maps))}"
            )
        if number is not None and number not in self.maps:
            raise Error(f"{self.path}: holds no map {number}; it has {self.maps}")
        return self.maps[0] if number is None else number

    def paths(self, number: int) -> list[Trajectory]:
        """The paths of one map, in the order driven."""
        chosen = np.flatnonzero(self.places["map"] == number)
        if not chosen.size:
            return []
        breaks = np.flatnonzero(~self._continued(chosen)) + 1
        return [self._path(piece) for piece in np.split(chosen, breaks)]

    def _continued(self, chosen: Ints) -> Bools:
        """Whether a path goes on from each place to the next: a metre at most, in time order."""
        step = {name: np.diff(self.places[name][chosen]) for name in ("time", "distance", "x", "y")}
        near = np.maximum(np.abs(step["distance"]), np.hypot(step["x"], step["y"])) <= 1.0
        return np.asarray(near & (step["time"] >= 0))

    def _path(self, chosen: Ints) -> Trajectory:
        x, y, yaw, time = (self.places[name][chosen] for name in ("x", "y", "yaw", "time"))
        position = np.column_stack([x, y, np.zeros(len(x))])
        return Trajectory(time // 1000, position, rotation.from_yaw(yaw))


def read_map(path: Path) -> MapFile:
    """Reads a file, and checks all of it. What its estimator has added since, in a file NAME.new
    beside it, is part of it."""
    data = path.read_bytes()
    try:
        from gprodom._core import FileError, GroundMap
    except ModuleNotFoundError:
        raise Error("the extension gprodom._core is not built or not installed") from None
    try:
        if not path.with_suffix(".new").is_file():
            return MapFile(path, data, GroundMap(str(path), data))
        ground = GroundMap.read(str(path))
    except FileError as error:
        raise Error(str(error)) from None
    return MapFile(path, ground.to_bytes() if int(ground.identity, 16) == 0 else data, ground)


def facts(file: MapFile) -> dict[str, Any]:
    """What is in a file; None for what its version does not hold."""
    ground = file.ground
    metres = file.length_m
    origin: dict[str, Any] = {
        "identity": ground.identity,
        "parents": ground.parents,
        "sessions": [_session_facts(session) for session in ground.sessions()],
    }
    if ground.version == 1:
        origin = dict.fromkeys(NOT_IN_VERSION_1)
    return {
        "file": str(file.path),
        "version": ground.version,
        "sha256": hashlib.sha256(file.data).hexdigest(),
        **origin,
        "samples": ground.samples,
        "sample_interval_s": ground.sample_interval,
        "centre_frequency_hz": ground.centre_frequency or None,
        "features": ground.rows,
        "spacing_m": ground.spacing,
        "bytes": len(file.data),
        "length_m": metres,
        "kb_per_m": len(file.data) / 1000 / metres if metres else None,
        "maps": [_map_facts(file, number) for number in file.maps],
        "runs": _run_facts(file),
    }


def _session_facts(session: dict[str, Any]) -> dict[str, Any]:
    stored = session["from"] <= session["to"]  # else none of its ground is in the file any more
    times = [moment(session[name] // 1000).isoformat() for name in ("from", "to")]
    return {
        "from": times[0] if stored else None,
        "to": times[1] if stored else None,
        "antenna_id": session["antenna_id"],
        "antenna_m": session["antenna"],
        "program": session["program"],
        "robot": session["robot"] or None,
        "path_errors": dict(zip(PATH_ERRORS, session["path_errors"], strict=True)),
    }


def _map_facts(file: MapFile, number: int) -> dict[str, Any]:
    chosen = file.places["map"] == number
    times = file.places["time"][chosen] // 1000
    x, y = file.places["x"][chosen], file.places["y"][chosen]
    stored = np.count_nonzero(file.columns["map"] == number)
    return {
        "map": number,
        "from": moment(times.min()).isoformat(),
        "to": moment(times.max()).isoformat(),
        "paths": len(file.paths(number)),
        "places": len(times),
        "length_m": float(stored * file.ground.spacing),
        "x_m": [float(x.min()), float(x.max())],
        "y_m": [float(y.min()), float(y.max())],
        "site": site_facts(file.ground, number),
    }


def _run_facts(file: MapFile) -> list[dict[str, Any]]:
    times: Ints = file.ground.times()
    maps: Ints = file.columns["map"]
    runs = zip(*(file.runs[name] for name in ("first", "end", "direction")), strict=True)
    found = []
    for number, (first, end, direction) in enumerate(runs):
        known = maps[first:end][maps[first:end] >= 0]
        found.append({
            "run": number,
            "map": int(known[0]) if known.size else None,
            "from_m": float(first * file.ground.spacing),
            "to_m": float(end * file.ground.spacing),
            "driven": "ahead" if direction > 0 else "back",
            "from": moment(times[first] // 1000).isoformat(),
            "to": moment(times[end - 1] // 1000).isoformat(),
        })  # fmt: skip
    return found


def stored_positions(file: MapFile, number: int) -> Floats:
    """Position (n, 2), m, of each stored column of a map."""
    chosen = file.columns["map"] == number
    return np.column_stack([file.columns["x"][chosen], file.columns["y"][chosen]])
