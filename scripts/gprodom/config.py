"""The part of the configuration that Python reads: its file, and the names of the channels.

The C++ programs check the whole configuration; here only the keys that are needed are read.
"""

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any

import gprodom
from gprodom.errors import Error

AUTO = "auto"  # of imu.rpy_body_imu: the estimator finds it
TRUTH_CHANNEL = "TOTAL_STATION"  # position_truth_t in logs; the estimator knows nothing of it


@dataclass(frozen=True)
class Channels:
    """Names of the LCM channels: the configuration's section ``channels``, key by key.

    A key is also the channel's role, by which the data of a log are found.
    """

    gpr_trace: str = "GPR_TRACE"
    imu: str = "IMU"
    wheel: str = "WHEEL"
    wheels: str = "WHEELS"
    displacement_in: str = "GPR_DISPLACEMENT_IN"
    position_fix: str = "POSITION_FIX"
    command: str = "COMMAND"
    displacement: str = "GPR_DISPLACEMENT"
    odometry: str = "ODOMETRY"
    odometry_map: str = "ODOMETRY_MAP"
    pose: str = "POSE"
    correction: str = "CORRECTION"
    status: str = "STATUS"
    sfm: str = "SFM"

    def of(self, *roles: str) -> dict[str, str]:
        """Names by role. With the wheel's role the pair of wheels is returned too, since one can
        replace the other.
        """
        if "wheel" in roles:
            roles = (*roles, "wheels")
        return {role: getattr(self, role) for role in roles}


STANDARD = Channels()


# Files of ``-c``: a later one overrides earlier ones, key by key; none: the defaults.
Configs = Sequence[Path]


def default_config() -> Path:
    """gprodom.yaml of this checkout, else the installed one."""
    checkout = Path(gprodom.__file__).resolve().parents[2]
    for path in (checkout / "config" / "gprodom.yaml", Path("/etc/gprodom/gprodom.yaml")):
        if path.is_file():
            return path
    raise Error("no default configuration found: give one with -c")


def config_files(configs: Configs) -> tuple[Path, ...]:
    """The files that `configs` stands for."""
    return tuple(configs) or (default_config(),)


def config_arguments(configs: Configs) -> list[str]:
    """The same as arguments of gprodomd and gprodom-replay."""
    return [part for path in config_files(configs) for part in ("-c", str(path))]


def read_channels(configs: Configs = (), overrides: Sequence[str] = ()) -> Channels:
    """The channels' names from configurations and KEY=VALUE overrides."""
    channels, prefix = STANDARD, ""
    sections = [(_section(file), f"{file}: channels.") for file in _known_files(configs)]
    for section, where in [*sections, (_overridden(overrides), "--set channels.")]:
        prefix = str(section.pop("prefix", prefix) or "")
        channels = _named(channels, section, where)
    usual = {name: getattr(STANDARD, name) for name in vars(channels)}
    return replace(
        channels,
        **{role: prefix + name for role, name in vars(channels).items() if name == usual[role]},
    )


def read_imu_mounting(configs: Configs = (), overrides: Sequence[str] = ()) -> tuple[float, ...]:
    """`imu.rpy_body_imu`: roll, pitch, yaw (rad); zeros where nothing says it."""
    return mounting_angles(_setting(configs, overrides, "imu.rpy_body_imu", (0.0, 0.0, 0.0)))


def mounting_angles(value: Any) -> tuple[float, ...]:
    """Of a value of `imu.rpy_body_imu`; zeros for `auto`."""
    if value == AUTO:
        return 0.0, 0.0, 0.0
    return _three(value, "imu.rpy_body_imu", f"three angles (rad) or {AUTO}")


def read_antennas(
    configs: Configs = (), overrides: Sequence[str] = (), key: str = "gpr.antennas"
) -> dict[int, tuple[float, float, float]]:
    """`gpr.antennas` or `anchor.antennas`: places in body (m) by id; none where nothing says it."""
    value = _setting(configs, overrides, key, {})
    try:
        places = {int(id_): tuple(float(part) for part in place) for id_, place in value.items()}
        return {id_: (x, y, z) for id_, (x, y, z) in places.items()}
    except (AttributeError, TypeError, ValueError):
        raise Error(f"{key}: expected {{ID: [x, y, z], ...}} in metres, found {value!r}") from None


def read_lever_arm(
    configs: Configs = (), overrides: Sequence[str] = (), key: str = "gpr.lever_arm"
) -> tuple[float, float, float]:
    """`gpr.lever_arm`, m in body; at its origin where nothing says it."""
    value = _setting(configs, overrides, key, [0.0, 0.0, 0.0])
    return _three(value, key, "[x, y, z] in metres")


def read_datum(
    configs: Configs = (), overrides: Sequence[str] = ()
) -> tuple[float, float, float] | None:
    """`anchor.datum`: latitude, longitude (degrees) and height (m); None where it is empty."""
    value = _setting(configs, overrides, "anchor.datum", [])
    return _three(value, "anchor.datum", "[latitude, longitude, height]") if value else None


def _three(value: Any, key: str, expected: str) -> tuple[float, float, float]:
    try:
        x, y, z = (float(part) for part in value)
    except (TypeError, ValueError):
        raise Error(f"{key}: expected {expected}, found {value!r}") from None
    return x, y, z


def _setting(configs: Configs, overrides: Sequence[str], key: str, default: Any) -> Any:
    """The value of SECTION.NAME."""
    import yaml

    section, _, name = key.partition(".")
    value = default
    for file in _known_files(configs):
        value = _section(file, section).get(name, value)
    for override in overrides:
        given, _, text = override.partition("=")
        value = yaml.safe_load(text) if given.strip() == key else value
    return value


def _known_files(configs: Configs) -> tuple[Path, ...]:
    try:
        return config_files(configs)
    except Error:  # the package alone, without the programs
        return ()


def read_yaml(path: Path) -> Any:
    """What a YAML file holds; errors name it."""
    import yaml

    try:
        return yaml.safe_load(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise Error(f"{path}: {error.strerror}") from None
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        raise Error(f"{path}: {' '.join(str(error).split())}") from None


def _section(config: Path, name: str = "channels") -> dict[object, object]:
    content = read_yaml(config)
    section = content.get(name) if isinstance(content, dict) else None
    if section is not None and not isinstance(section, dict):
        what = "the names of channels" if name == "channels" else "settings"
        raise Error(f"{config}: {name}: expected {what} by key")
    return section or {}


def _overridden(overrides: Sequence[str]) -> dict[object, object]:
    pairs = (override.partition("=") for override in overrides)
    return {
        key.strip().removeprefix("channels."): value.strip().strip("'\"")
        for key, _, value in pairs
        if key.strip().startswith("channels.")
    }


def _named(channels: Channels, names: dict[object, object], where: str) -> Channels:
    known = {field.name for field in fields(Channels)}
    for key, name in names.items():
        if key not in known:
            raise Error(f"{where}{key}: unknown key; expected one of {', '.join(sorted(known))}")
        if not isinstance(name, str) or not name:
            raise Error(f"{where}{key}: expected the name of a channel, got {name!r}")
    return replace(channels, **{str(key): str(name) for key, name in names.items()})
