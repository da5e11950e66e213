"""Files that a command writes: never over one that it reads, and entirely or not at all; zips and
npz whose bytes depend only on what is in them.

`gprodom.cli` names the inputs of a command with `reading`; what is found to be read later (a header
beside a survey file) is added with `also_read`. `check_output` refuses to write over one of them by
any name or link, and everything here that writes asks it.
"""

import io
import os
import shutil
import tempfile
import zipfile
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path, PosixPath

import numpy as np

from gprodom.arrays import Floats
from gprodom.errors import Error, UsageError

PICTURES = (".png", ".svg", ".pdf")
_EPOCH = (1980, 1, 1, 0, 0, 0)  # of the members

_inputs: list[Path] = []  # of the command that runs: files, and folders with all that is in them


class Output(PosixPath):
    """As the `type` of an argument: a file or folder that the command writes.

    Arguments that are paths of any other type count as inputs.
    """


class OutputFile(Output):
    """A file that the command writes."""


class PictureFile(OutputFile):
    """A picture, whose format its ending tells; PNG where it has none."""


class OutputFolder(Output):
    """A folder into which the command writes."""


@contextmanager
def reading(inputs: Iterable[Path]) -> Iterator[None]:
    """While a command runs: its inputs, which nothing is written over."""
    before = _inputs[:]
    _inputs.extend(inputs)
    try:
        yield
    finally:
        _inputs[:] = before


def also_read(*paths: Path) -> None:
    """More inputs of the command that runs."""
    _inputs.extend(paths)


def check_outputs(outputs: Iterable[Output]) -> None:
    """Before a command begins its work: can all of its outputs be written, each to a place of its
    own? Raises `UsageError` or `Error`."""
    files = [path for path in outputs if not isinstance(path, OutputFolder)]
    for folder in (path for path in outputs if isinstance(path, OutputFolder)):
        if folder.exists() and not folder.is_dir():
            raise UsageError(f"{folder}: expected a folder to write into, got a file")
    for i, path in enumerate(files):
        if isinstance(path, OutputFile) or not path.is_dir():
            check_output(path)
        if isinstance(path, PictureFile) and path.suffix.lower() not in (*PICTURES, ""):
            raise UsageError(f"{path}: expected a picture's name, ending in {', '.join(PICTURES)}")
        for other in files[:i]:
            if _is_plain(path) and os.path.realpath(path) == os.path.realpath(other):
                raise UsageError(f"{path}: two outputs in one file; give each its own")


def check_output(path: Path) -> None:
    """Raises `UsageError` where `path` is one of the command's inputs, by any name or link, or a
    folder; `Error` where its folder does not exist."""
    if path.is_dir():
        raise UsageError(f"{path}: expected a file to write, got a directory")
    folder = Path(os.path.realpath(path)).parent
    if not folder.is_dir():
        raise Error(f"{path}: the folder {path.parent} does not exist")
    if not _is_plain(path):
        return
    for known in _inputs:
        if _same(path, known):
            raise UsageError(f"{path}: is an input of this command; name another file to write")
        if path.exists() and known.is_dir() and any(_same(up, known) for up in _parents(path)):
            raise UsageError(
                f"{path}: exists already, in the folder {known} that this command reads; name "
                "another file to write"
            )


def _parents(path: Path) -> Iterable[Path]:
    return Path(os.path.realpath(path)).parents


def _same(one: Path, other: Path) -> bool:
    try:
        return one.samefile(other)
    except OSError:  # one of them does not exist
        return os.path.realpath(one) == os.path.realpath(other)


def _is_plain(path: Path) -> bool:
    """Whether a new file can take the place of `path`: not of a device or a pipe, nor of what a
    shell has opened as /dev/stdout."""
    if str(path.absolute()).startswith(("/dev/", "/proc/")):
        return False
    return path.is_file() or not path.exists()


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """A new file beside `path`: renamed to it when all went well, removed when not. Where `path` is
    a link, the file that it leads to is replaced; a device or a pipe is written to at the end."""
    check_output(path)
    plain = _is_plain(path)
    target = Path(os.path.realpath(path)) if plain else path
    try:
        handle, name = tempfile.mkstemp(
            prefix=f".{path.name}.", suffix=".part", dir=target.parent if plain else None
        )
    except OSError as error:
        raise Error(f"{path}: cannot be written: {error.strerror}") from None
    os.close(handle)
    part = Path(name)
    try:
        yield part
        if plain:
            _settle(part)
            part.replace(target)
            _sync(target.parent)
        else:
            with part.open("rb") as written, target.open("wb") as sink:
                shutil.copyfileobj(written, sink)
    except OSError as error:
        if error.filename not in (None, name):
            raise
        raise Error(f"{path}: cannot be written: {error.strerror}") from None
    finally:
        part.unlink(missing_ok=True)


def _settle(part: Path) -> None:
    """The mode that the umask leaves, and the content on the disk: after a power cut the name must
    not stand for an empty file."""
    umask = os.umask(0)
    os.umask(umask)
    part.chmod(0o666 & ~umask)
    _sync(part)


def _sync(path: Path) -> None:
    handle = os.open(path, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


@contextmanager
def temporary_folder() -> Iterator[Path]:
    """A folder that is removed at the end."""
    with tempfile.TemporaryDirectory(prefix="gprodom-") as name:
        yield Path(name)


def write_bytes(path: Path, data: bytes) -> None:
    """Writes a file entirely or not at all."""
    with replacing(path) as part:
        part.write_bytes(data)


def write_text(path: Path, text: str) -> None:
    """Writes a text in UTF-8, entirely or not at all."""
    write_bytes(path, text.encode())


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
