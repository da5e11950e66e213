"""Maps into and out of the service's folder, which its user alone may enter."""

import os
import pwd
import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from gprodom.errors import Error
from gprodom.map.ground import MapFile, read_map

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


def install(data: bytes, path: Path) -> list[str]:
    """Writes a map of the service's, entirely or not at all; returns what to say of a file that was
    kept under another name. A link of that name is replaced: maps are in this folder and nowhere
    else. Raises `Error` for the service's own ground while it runs."""
    from gprodom._core import FileError, install_map

    with as_service():
        if path.is_symlink():
            path.unlink()
        umask = os.umask(0o777 & ~MODE)
        try:
            return install_map(str(path.parent), path.stem, data)
        except FileError as error:
            raise Error(str(error)) from None
        finally:
            os.umask(umask)


def fetch(path: Path) -> MapFile:
    """Reads one."""
    with as_service():
        return read_map(path)
