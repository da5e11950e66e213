"""A scene: what lies under a survey line, read from YAML (config/scenes/).

The ground repeats along the line after `length`, so that a closed track of that length sees no
seam. Depths count from the surface downwards. A scene is cut by vertical planes, one for each
survey line, `aside` apart: layers, grain, pipes and stones of neighbouring planes belong together.
"""

from __future__ import annotations  # `read_section` reads them as text

from dataclasses import MISSING, dataclass, fields
from pathlib import Path
from typing import Any, TypeVar

from gprodom.config import read_yaml
from gprodom.errors import Error

Section = TypeVar("Section")


@dataclass(frozen=True)
class Antenna:
    """Transmitter and receiver at `height` over the surface, `separation` apart along the line."""

    frequency: float = 5e8  # Hz, of the Ricker wavelet
    separation: float = 0.16  # m
    height: float = 0.01  # m


@dataclass(frozen=True)
class Layer:
    """A layer; the last one reaches down for ever.

    Permittivity varies by `variation` (relative, standard deviation), conductivity with it, over
    `grain` (m along the line, m in depth); the layer's lower edge by `roughness` (m, standard
    deviation) over `roughness_length` (m).
    """

    name: str
    permittivity: float
    conductivity: float  # S/m
    thickness: float = 0.0  # m
    variation: float = 0.0
    grain: tuple[float, float] = (0.1, 0.05)
    roughness: float = 0.0
    roughness_length: float = 0.5


@dataclass(frozen=True)
class Bars:
    """Metal bars across the line, every `spacing` (m), each off by up to `jitter` (m)."""

    depth: float  # m, of their centres
    spacing: float
    radius: float
    jitter: float = 0.0


@dataclass(frozen=True)
class Pipe:
    """A pipe across the line. `skew` (rad) is its angle from square: it crosses the next line
    tan(skew) * aside further on. Conductivity 0: plastic full of `permittivity`; high: metal."""

    x: float  # m along the first line
    depth: float  # m, of its axis
    radius: float
    permittivity: float = 1.0
    conductivity: float = 0.0  # S/m
    skew: float = 0.0


@dataclass(frozen=True)
class Stones:
    """Ellipsoids half as deep as long, at random places."""

    number: int
    depth: tuple[float, float]  # m, of their centres
    radius: tuple[float, float]  # m, along the line
    permittivity: tuple[float, float]
    conductivity: float = 0.001  # S/m


@dataclass(frozen=True)
class Scene:
    """What to simulate and on what grid."""

    name: str
    layers: tuple[Layer, ...]
    bars: tuple[Bars, ...] = ()
    pipes: tuple[Pipe, ...] = ()
    stones: tuple[Stones, ...] = ()
    antenna: Antenna = Antenna()
    length: float = 10.0  # m; a whole number of `spacing`
    spacing: float = 0.02  # m, between traces; a whole number of `cell`
    aside: tuple[float, ...] = (0.0, 0.06)  # m; of each line
    samples: int = 201
    sample_interval: float = 2e-10  # s
    cell: float = 0.01  # m, of the FDTD
    window: tuple[float, float] = (1.6, 1.15)  # m, along the line and in depth, round each trace
    seed: int = 1  # of grain, roughness, jitter and stones

    def __post_init__(self) -> None:
        if not self.layers:
            raise Error(f"scene {self.name}: layers: expected at least one")
        for what, whole, part in (
            ("length", self.length, self.spacing),
            ("spacing", self.spacing, self.cell),
            ("antenna.separation", self.antenna.separation / 2, self.cell),
        ):
            if abs(whole / part - round(whole / part)) > 1e-6:
                raise Error(
                    f"scene {self.name}: {what}: expected a whole number of {part:g} m steps"
                )

    @property
    def traces(self) -> int:
        """Traces on each line."""
        return round(self.length / self.spacing)


_LISTS: dict[str, Any] = {"layers": Layer, "bars": Bars, "pipes": Pipe, "stones": Stones}


def read_mapping(path: Path) -> dict[str, Any]:
    """A YAML file of keys and values; errors name the file."""
    content = read_yaml(path)
    if not isinstance(content, dict):
        raise Error(f"{path}: expected keys and their values")
    return content


def read_scene(path: Path) -> Scene:
    """The scene of a YAML file; unknown keys and wrong values are errors that name the key."""
    values: dict[str, Any] = {"name": path.stem, **read_mapping(path)}
    for key, kind in _LISTS.items():
        items = values.get(key, [])
        if not isinstance(items, list):
            raise Error(f"{path}: {key}: expected a list")
        values[key] = tuple(
            read_section(kind, v, f"{path}: {key}[{i}]") for i, v in enumerate(items)
        )
    if "antenna" in values:
        values["antenna"] = read_section(Antenna, values["antenna"], f"{path}: antenna")
    return read_section(Scene, values, str(path))


def read_section(kind: type[Section], values: Any, where: str) -> Section:
    """The dataclass `kind` of a mapping; unknown, missing and wrong keys are errors at `where`."""
    if not isinstance(values, dict):
        raise Error(f"{where}: expected a mapping")
    known = {field.name: field for field in fields(kind)}  # type: ignore[arg-type]
    for key in values:
        if key not in known:
            raise Error(f"{where}: {key}: unknown key; expected one of {', '.join(known)}")
    for name, field in known.items():
        if name not in values and field.default is MISSING:
            raise Error(f"{where}: {name} is missing")
    return kind(
        **{key: _value(value, known[key].type, f"{where}: {key}") for key, value in values.items()}
    )


def _value(value: Any, kind: Any, where: str) -> Any:
    """`value` as the field's annotated type, where that is a number, numbers or text."""
    text = str(kind)
    if text in ("float", "int"):
        try:
            number = float(value)  # YAML 1.1 reads 5e8 as text
        except (TypeError, ValueError):
            raise Error(f"{where}: {value!r}: expected a number") from None
        return int(number) if text == "int" else number
    if text.startswith("tuple[float"):
        if not isinstance(value, (list, tuple)):
            raise Error(f"{where}: {value!r}: expected a list of numbers")
        count = None if "..." in text else text.count("float")
        if count is not None and len(value) != count:
            raise Error(f"{where}: expected {count} numbers")
        return tuple(_value(item, "float", where) for item in value)
    return value
