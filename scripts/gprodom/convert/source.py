"""A CMU-GPR sequence as files that are read by name: a directory or the dataset's zip.

Nothing is extracted from a zip to disk. A file in it whose stated size is above `MAX_BYTES` is not
read, and never more than the stated size is read.
"""

import re
import zipfile
import zlib
from dataclasses import dataclass
from pathlib import Path, PurePosixPath

from gprodom.errors import Error

MAX_BYTES = 1 << 30  # of one file; the longest recordings of the dataset have some 30 MB
MAX_MEMBERS = 200_000  # a sequence has a few files and one picture per camera frame

GPR = "gpr_meas.csv"
IMU = "imu_meas.csv"
WHEEL = ("we_odom_meas.csv", "we_odom.csv")
TRUTH = "ts_meas.csv"
RADAR_FACTS = "gpr_meas.json"  # of ours, not of the dataset: {"sample_interval_s": S}
_KNOWN = (GPR, IMU, *WHEEL, TRUTH, RADAR_FACTS)
# gpr_meas_1.csv, ...: traces of further antennas, by antenna_id; gpr_meas.csv is antenna 0.
_MORE_GPR = re.compile(r"gpr_meas_([1-9][0-9]?)\.csv")


@dataclass(frozen=True)
class File:
    """One file of a sequence. `label` names it in messages."""

    label: str
    data: bytes


def antenna_of(name: str) -> int | None:
    """The antenna_id whose traces a further file of traces holds; None for any other file."""
    found = _MORE_GPR.fullmatch(name)
    return int(found.group(1)) if found else None


def _is_known(name: str) -> bool:
    return name in _KNOWN or antenna_of(name) is not None


def read_files(sequence: Path) -> dict[str, File]:
    """The sequence's known files by name, those that exist."""
    if sequence.is_dir():
        return _from_directory(sequence)
    if not sequence.exists():
        raise Error(f"{sequence}: no such sequence")
    if not zipfile.is_zipfile(sequence):
        raise Error(f"{sequence}: expected a directory or a zip, got neither")
    try:
        return _from_zip(sequence)
    except (zipfile.BadZipFile, NotImplementedError, EOFError, OSError, zlib.error) as error:
        raise Error(f"{sequence}: damaged or unreadable zip: {error}") from None


def _from_directory(sequence: Path) -> dict[str, File]:
    folders = [sequence, *sorted(path for path in sequence.iterdir() if path.is_dir())]
    known = [[path for path in sorted(f.iterdir()) if _is_known(path.name)] for f in folders]
    holding = {str(f): paths for f, paths in zip(folders, known, strict=True) if paths}
    files = {}
    for path in holding[_single(sequence, list(holding))]:
        if path.is_file():
            if path.stat().st_size > MAX_BYTES:
                raise Error(f"{path}: {path.stat().st_size} bytes, at most {MAX_BYTES} expected")
            files[path.name] = File(str(path), path.read_bytes())
    return files


def _from_zip(sequence: Path) -> dict[str, File]:
    with zipfile.ZipFile(sequence) as archive:
        members = archive.infolist()
        if len(members) > MAX_MEMBERS:
            raise Error(f"{sequence}: {len(members)} files in the zip, at most {MAX_MEMBERS}")
        wanted: dict[str, list[tuple[str, zipfile.ZipInfo]]] = {}
        for member in members:
            path = PurePosixPath(member.filename)
            if not _is_known(path.name) or path.parts[0] == "__MACOSX":
                continue
            if path.is_absolute() or ".." in path.parts or "\\" in member.filename:
                raise Error(f"{sequence}: refused, the zip has the unsafe path {path}")
            if len(path.parts) <= 2:
                wanted.setdefault(str(path.parent), []).append((path.name, member))
        folder = _single(sequence, list(wanted))
        files = {}
        for name, member in wanted[folder]:
            label = f"{sequence}/{member.filename}"
            if name in files:
                raise Error(f"{label}: twice in the zip")
            files[name] = File(label, _read_member(archive, member, label))
        return files


def _read_member(archive: zipfile.ZipFile, member: zipfile.ZipInfo, label: str) -> bytes:
    if member.flag_bits & 1:
        raise Error(f"{label}: encrypted; unpack the sequence and give its directory")
    if member.file_size > MAX_BYTES:
        raise Error(f"{label}: refused, unpacks to more than {MAX_BYTES} bytes")
    with archive.open(member) as stream:
        return stream.read()


def _single(sequence: Path, folders: list[str]) -> str:
    if not folders:
        raise Error(f"{sequence}: not a CMU-GPR sequence, expected {IMU}, {GPR} and {WHEEL[0]}")
    if len(folders) > 1:
        raise Error(f"{sequence}: expected one sequence, got {len(folders)}: {', '.join(folders)}")
    return folders[0]
