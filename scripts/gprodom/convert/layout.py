"""The layout of a robot's own tables (what each column is), from a YAML file and from options."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from gprodom.config import read_yaml
from gprodom.convert.sampling import fault_of_interval
from gprodom.errors import Error
from gprodom.files import also_read
from gprodom.fixes.trust import CODES

# Sources of data, each a table's columns: the time, then the values named here.
SOURCES = {
    "imu": "acceleration x, y, z and angular rate x, y, z",
    "accelerometer": "acceleration x, y, z",
    "gyroscope": "angular rate x, y, z",
    "wheel_speed": "speed, a column a wheel",
    "wheel_distance": "distance driven, a column a wheel, m",
    "wheel_counts": "encoder counts, a column a wheel",
    "gpr": "samples of a trace; several tables: an antenna each",
    "gpr_times": "nothing more; a row for each trace of the survey file given as gpr",
    "position": "the truth: x, y, z, or latitude, longitude, height",
    "fix": "positions for the estimator (see below)",
}
TIME_UNITS = {"s": 1, "ms": 1_000, "us": 1_000_000, "ns": 1_000_000_000, "iso": 1}  # a second
CHOICES: dict[str, dict[str, float]] = {
    "acceleration_unit": {"m/s2": 1.0, "g": 9.80665},
    "rate_unit": {"rad/s": 1.0, "deg/s": 0.017453292519943295},
    "speed_unit": {"m/s": 1.0, "km/h": 1 / 3.6},
    "position_unit": {"m": 1.0, "degrees": 1.0},
    "fix_unit": {"m": 1.0, "degrees": 1.0},
    "fix_quality_code": dict.fromkeys(CODES, 1.0),
}
NUMBERS = ("counts_per_metre", "gpr_scale", "sample_interval", "fix_sigma")


@dataclass(frozen=True)
class Source:
    """A table and its columns by name or number from 1, the time first; () means in order."""

    file: Path | None = None
    columns: tuple[str, ...] = ()
    time_unit: str = "s"
    delimiter: str = ""  # "": comma, semicolon or tab, whichever the first line has
    more: tuple[Path, ...] = ()  # of the radar: tables of further antennas
    antenna: str = ""  # of the radar: the column of antenna_id, by name or number; "": none
    channels: tuple[int, ...] = ()  # of the radar's survey file; (): all


@dataclass
class Layout:
    """All sources, and the settings that hold for them together."""

    sources: dict[str, Source] = field(default_factory=dict)
    settings: dict[str, Any] = field(default_factory=dict)

    def factor(self, key: str) -> float:
        """What values in the unit set by `key` are multiplied by to be SI."""
        choices = CHOICES[key]
        return choices[self.settings.get(key, next(iter(choices)))]


def read_layout(path: Path | None, options: Mapping[str, Any], table: Path | None) -> Layout:
    """The layout of a YAML file, if any, with `options` (keys as in the file) over it.

    table: the file of all sources that name none. Files named in the YAML are relative to it.
    """
    content = {} if path is None else _read_yaml(path)
    where = str(path) if path is not None else "options"
    merged = dict(content)
    for key, value in options.items():
        if value is None:
            continue
        if isinstance(value, dict):
            value = {**merged.get(key, {}), **value}
        merged[key] = value
    settings = {k: v for k, v in merged.items() if k not in SOURCES}
    for key, value in settings.items():
        _check_setting(where, key, value)
    layout = Layout(settings=settings)
    for name in SOURCES:
        if name in merged:
            layout.sources[name] = _source(where, name, merged[name], settings, path, table)
    return layout


def _read_yaml(path: Path) -> dict[str, Any]:
    content = read_yaml(path)
    if not isinstance(content, dict):
        raise Error(f"{path}: expected keys and values, such as imu: {{columns: [...]}}")
    for name in SOURCES:
        if name in content and not isinstance(content[name], dict):
            raise Error(f"{path}: {name}: expected {{file: NAME, columns: [...]}}")
    return content


def _check_setting(where: str, key: str, value: Any) -> None:
    if key in CHOICES or key == "time_unit":
        choices = CHOICES.get(key, TIME_UNITS)
        if value not in choices:
            raise Error(f"{where}: {key}: {value!r}: expected one of {', '.join(choices)}")
    elif key in NUMBERS:
        if isinstance(value, bool) or not isinstance(value, (int, float)) or not 0 < value < 1e12:
            raise Error(f"{where}: {key}: {value!r}: expected a number above 0")
        if key == "sample_interval" and (wrong := fault_of_interval(value)):
            raise Error(f"{where}: {key}: {wrong}")
    elif key == "delimiter":
        if not isinstance(value, str) or len(value) != 1:
            raise Error(f"{where}: delimiter: {value!r}: expected one character")
    else:
        known = ", ".join((*SOURCES, *CHOICES, *NUMBERS, "time_unit", "delimiter"))
        raise Error(f"{where}: unknown key {key}; expected one of {known}")


def _source(
    where: str,
    name: str,
    content: dict[str, Any],
    settings: dict[str, Any],
    layout: Path | None,
    table: Path | None,
) -> Source:
    for key in content:
        known = ("file", "columns", "time_unit", "delimiter")
        if key not in (*known, *(("antenna", "channels") if name == "gpr" else ())):
            raise Error(f"{where}: {name}: unknown key {key}")
    own = {key: content[key] for key in ("time_unit", "delimiter") if key in content}
    for key, value in own.items():
        _check_setting(f"{where}: {name}", key, value)
    columns = content.get("columns", [])
    if not isinstance(columns, (list, tuple)):
        raise Error(f"{where}: {name}: columns: expected a list, the time first")
    channels = content.get("channels", [])
    if not isinstance(channels, list) or not all(type(n) is int and n >= 0 for n in channels):
        raise Error(f"{where}: {name}: channels: expected a list of numbers from 0")
    named = content.get("file")
    several = named if name == "gpr" and isinstance(named, list) and named else [named]
    files = [_file(each, layout, table) for each in several]
    if None in files:
        raise Error(f"{where}: {name}: which table? Give its file")
    file, *more = [each for each in files if each is not None]
    also_read(file, *more)
    return Source(
        file,
        tuple(str(column).strip() for column in columns),
        str(own.get("time_unit", settings.get("time_unit", "s"))),
        str(own.get("delimiter", settings.get("delimiter", ""))),
        tuple(more),
        str(content.get("antenna", "")).strip(),
        tuple(channels),
    )


def _file(named: Any, layout: Path | None, table: Path | None) -> Path | None:
    """One that a source names; of a layout relative to it."""
    if isinstance(named, str) and layout is not None:
        return layout.parent / named
    return table if named is None else Path(named)
