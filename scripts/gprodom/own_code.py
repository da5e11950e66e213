"""Identifies the code that made a result."""

import hashlib
from functools import cache
from pathlib import Path

import gprodom

# Modules that only draw, print, parse a command line or hand out work: no result depends on them.
_FOLDERS = {"plot", "status"}
_MODULES = {"__main__.py", "canvas.py", "cli.py", "command.py", "page.py", "pictures.py"}
_MODULES |= {"cluster.py", "executor.py", "options.py", "schedule.py"}


@cache
def digest_of_code(package: Path | None = None) -> str:
    """SHA-256 over the sources of the package (by default gprodom) that compute figures."""
    root = package or Path(gprodom.__file__).parent
    digest = hashlib.sha256()
    for path in sorted(root.rglob("*.py")):
        inside = path.relative_to(root)
        if inside.parts[0] in _FOLDERS or inside.name in _MODULES:
            continue
        digest.update(f"{inside.as_posix()}\n".encode() + path.read_bytes() + b"\0")
    return digest.hexdigest()
