"""The generated LCM message classes, found in one place.

The build runs ``lcm-gen --python --ppath build/python/gprodom/lcmtypes``; an installed package
holds the same files in ``gprodom/lcmtypes``. They are therefore ``gprodom.lcmtypes.gprodom`` and
``gprodom.lcmtypes.bot_core``.

    from gprodom.lcm.messages import message
    imu_t = message("imu_t")
    imu_t.decode(event.data)
"""

from functools import cache
from importlib import import_module
from types import ModuleType
from typing import Any

from gprodom.errors import Error


@cache
def message(name: str, package: str = "gprodom") -> Any:
    """The generated class of the LCM type `package`.`name`."""
    return getattr(_types(package), name)


def _types(package: str) -> ModuleType:
    try:
        return import_module(f"gprodom.lcmtypes.{package}")
    except ModuleNotFoundError:
        raise Error(
            "the generated LCM types are missing: build the project first (scripts/setup, or "
            "cmake --build build), or name its build folder in GPRODOM_BUILD"
        ) from None


@cache
def fingerprint(name: str, package: str = "gprodom") -> bytes:
    """The eight bytes that begin every encoded message of the type."""
    value: bytes = message(name, package)._get_packed_fingerprint()
    return value


@cache
def by_fingerprint() -> dict[bytes, str]:
    """Names of our types by the fingerprint that begins their messages."""
    return {fingerprint(name): name for name in vars(_types("gprodom")) if name.endswith("_t")}
