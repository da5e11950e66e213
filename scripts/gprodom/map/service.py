"""Maps into and out of the service's folder, which its user alone may enter."""

from __future__ import annotations

import os
import pwd
import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from gprodom.errors import Error
from gprodom.files import write_bytes

USER = "gprodom"
FOLDER = Path("/var/lib/gprodom")
MODE = 0o640  # the group may read
NAME = re.compile(r"[A-Za-z0-9_-][A-Za-z0-9_.-]{0,99}")  # as load_map takes it


@contextmanager
def as_service() -> Iterator[None]:
    """As the service's user: what is made is its own, and a link that it has put into its folder
    leads to nothing that it could not reach itself. Needs root."""
    if os.geteuid() != 0:
        raise Error(f"the folder of the service belongs to the user {USER}: run this as root")
    try:
        user = pwd.getpwnam(USER)
    except KeyError:
        raise Error(
            f"this machine has no user {USER}: install the package gprodom, which makes it"
        ) from None
    group, groups = os.getegid(), os.getgroups()
    os.setgroups([])
    os.setegid(user.pw_gid)
    os.seteuid(user.pw_uid)
    try:
        yield
    finally:
        os.seteuid(0)
        os.setegid(group)
        os.setgroups(groups)


def path_in(folder: Path, name: str) -> Path:
    """The file of the map NAME, with or without its ending."""
    bare = name.removesuffix(".map")
    if not NAME.fullmatch(bare):
        raise Error(f"{name!r}: expected a map's name of letters, digits, '_', '-' and '.'")
    return folder / f"{bare}.map"


def install(data: bytes, path: Path) -> None:
    """Writes a map of the service's, entirely or not at all. A link of that name is replaced: maps
    are in this folder and nowhere else."""
    with as_service():
        if path.is_symlink():
            path.unlink()
        write_bytes(path, data, MODE)


def fetch(path: Path) -> bytes:
    """Reads one."""
    with as_service():
        return path.read_bytes()
