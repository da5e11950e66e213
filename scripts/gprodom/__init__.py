"""gprodom: odometry from ground-penetrating radar, IMU and wheel encoder.

The command line is ``gprodom`` (see `gprodom.cli`). The estimator itself is C++ and is reached
through ``gprodom.Odometry`` and its companions, which come from the extension ``gprodom._core``.

In a checkout the compiled parts (``_core``, ``lcmtypes``) lie in the build folder, under
``build/python/gprodom``; GPRODOM_BUILD names another build folder. An installed package holds them
itself.
"""

import os as _os
from importlib import import_module as _import_module
from pathlib import Path as _Path
from typing import TYPE_CHECKING
from typing import Any as _Any


def _build_folder() -> _Path | None:
    """The build folder of the checkout that this package runs from; None where it is installed."""
    named = _os.environ.get("GPRODOM_BUILD")
    if named:
        return _Path(named).resolve()
    checkout = _Path(__file__).resolve().parents[2]
    return checkout / "build" if (checkout / "CMakeLists.txt").is_file() else None


_build = _build_folder()
if _build is not None:
    __path__.append(str(_build / "python" / "gprodom"))


def _find_version() -> str:
    """The version, which stands once, in scripts/pyproject.toml; the build and pip carry it on."""
    metadata = _Path(__file__).resolve().parents[1] / "pyproject.toml"
    if metadata.is_file():
        import tomllib

        return str(tomllib.loads(metadata.read_text(encoding="utf-8"))["project"]["version"])
    try:
        return str(_import_module("gprodom._version").VERSION)  # the Debian package's
    except ModuleNotFoundError:
        from importlib.metadata import version

        return version("gprodom")


# What of the extension is offered here, and the module `gpr`, which is made of it. Other names are
# modules, which need no extension.
_OFFERED = {
    "RESET_ALL",
    "CommandName",
    "ConfigError",
    "FileError",
    "Odometry",
    "Outputs",
    "describe_config",
    "gpr",
}

if TYPE_CHECKING:
    __version__: str
    from gprodom._core import RESET_ALL as RESET_ALL
    from gprodom._core import CommandName as CommandName
    from gprodom._core import ConfigError as ConfigError
    from gprodom._core import FileError as FileError
    from gprodom._core import Odometry as Odometry
    from gprodom._core import Outputs as Outputs
    from gprodom._core import describe_config as describe_config
else:

    def __getattr__(name: str) -> _Any:
        """``gprodom.Odometry`` and the like: the extension is loaded when first asked for."""
        if name == "__version__":
            return _find_version()
        if name not in _OFFERED:
            raise AttributeError(f"module 'gprodom' has no attribute {name!r}")
        try:
            core = _import_module("gprodom._core")
            if name == "gpr":
                return _import_module("gprodom.gpr")
        except ModuleNotFoundError as error:
            if error.name != "gprodom._core":
                raise
            raise AttributeError(
                f"module 'gprodom' has no attribute {name!r}: its extension gprodom._core is not "
                "built (cmake --build build) or not installed"
            ) from None
        return getattr(core, name)

    def __dir__() -> list[str]:
        """With what is loaded only when asked for, so that completion offers it."""
        return sorted({*globals(), *_OFFERED, "__version__"})
