"""Files written entirely or not at all; zips and npz whose bytes depend only on what is in them."""

from __future__ import annotations

import io
import os
import tempfile
import zipfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from gprodom.arrays import Floats
from gprodom.errors import Error

_EPOCH = (1980, 1, 1, 0, 0, 0)  # of the members


@contextmanager
def replacing(path: Path, mode: int | None = None) -> Iterator[Path]:
    """A new file beside `path`: renamed to it when all went well, removed when not.

    mode: of the file; by default what the umask leaves.
    """
    try:
        handle, name = tempfile.mkstemp(prefix=f".{path.name}.", suffix=".part", dir=path.parent)
    except FileNotFoundError:
        raise Error(f"{path}: the folder {path.parent} does not exist") from None
    os.close(handle)
    part = Path(name)
    try:
        yield part
        if mode is None:
            umask = os.umask(0)
            os.umask(umask)
            mode = 0o666 & ~umask
        part.chmod(mode)
        part.replace(path)
    finally:
        part.unlink(missing_ok=True)


def write_bytes(path: Path, data: bytes, mode: int | None = None) -> None:
    """Writes a file entirely or not at all."""
    with replacing(path, mode) as part:
        part.write_bytes(data)


def zip_bytes(members: Mapping[str, bytes]) -> bytes:
    """A zip of the members, in their order."""
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as archive:
        for name, data in members.items():
            member = zipfile.ZipInfo(name, _EPOCH)
            member.compress_type = zipfile.ZIP_DEFLATED
            member.external_attr = 0o644 << 16
            archive.writestr(member, data, compresslevel=9)
    return buffer.getvalue()


def write_npz(path: Path, arrays: Mapping[str, Floats]) -> None:
    """What ``numpy.load`` reads."""
    write_bytes(path, zip_bytes({f"{key}.npy": _npy(array) for key, array in arrays.items()}))


def _npy(array: Floats) -> bytes:
    buffer = io.BytesIO()
    np.lib.format.write_array(buffer, np.asarray(array, order="C"), allow_pickle=False)
    return buffer.getvalue()
