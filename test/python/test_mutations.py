"""Foreign files, damaged in many ways: each is either read or refused with one line.

Seeded, so that a failure comes again; GPRODOM_MUTATIONS=100000 runs for longer.
"""

import os
import struct
import zipfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from dzt_file import dzt_file
from gprodom.convert.cmu import read_recording
from gprodom.convert.survey_files import read_line
from gprodom.errors import Error
from ids_file import ids_file
from test_convert import tables

MUTATIONS = int(os.environ.get("GPRODOM_MUTATIONS", "300"))
WORDS = [*b"nan inf -1 1e999 99999999999 , 0x1 _".split(), b"\0", b"\r\n", b"\xff"]
Files = dict[str, bytes]


def mutated(data: bytes, rng: np.random.Generator) -> bytes:
    """One to four changes: bytes turned, cut out, doubled or replaced by words that hurt."""
    changed = bytearray(data)
    for _ in range(rng.integers(1, 5)):
        at = int(rng.integers(0, len(changed) + 1))
        length = int(2 ** rng.uniform(0, 8))
        kind = rng.integers(0, 6)
        if kind == 0 and at < len(changed):
            changed[at] ^= 1 << int(rng.integers(0, 8))
        elif kind == 1:
            del changed[at : at + length]
        elif kind == 2:
            changed[at:at] = changed[at : at + length]
        elif kind == 3:
            changed[at : at + int(rng.integers(0, 8))] = WORDS[rng.integers(0, len(WORDS))]
        elif kind == 4:
            changed[at : at + 4] = struct.pack("<i", int(rng.choice([-1, 0, 2**31 - 1, -(2**31)])))
        else:
            del changed[at:]
    return bytes(changed)


def sequence() -> Files:
    """A short sequence in the dataset's format."""
    return {name: "\r\n".join(lines).encode() for name, lines in tables().items()}


def write(folder: Path, files: Files) -> Path:
    for name, data in files.items():
        (folder / name).write_bytes(data)
    return folder


def as_folder(folder: Path, rng: np.random.Generator) -> None:
    files = sequence()
    name = sorted(files)[rng.integers(0, len(files))]
    read_recording(write(folder, {**files, name: mutated(files[name], rng)}))


def as_zip(folder: Path, rng: np.random.Generator) -> None:
    path = folder / "sequence.zip"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in sequence().items():
            archive.writestr(f"a/{name}", data)
    path.write_bytes(mutated(path.read_bytes(), rng))
    read_recording(path)


def survey(files: Files) -> Callable[[Path, np.random.Generator], None]:
    def read(folder: Path, rng: np.random.Generator) -> None:
        name = list(files)[rng.integers(0, len(files))]
        write(folder, {**files, name: mutated(files[name], rng)})
        read_line(folder / next(iter(files)))

    return read


TRACES = bytes(range(256)) * 8
DT1 = {
    "line.dt1": TRACES,
    "line.hd": b"NUMBER OF PTS/TRC = 32\r\nTOTAL TIME WINDOW = 40.0\r\nSTEP SIZE USED = 0.02\r\n"
    b"POSITION UNITS = m\r\nTIMEZERO AT POINT = 3\r\n",
}
RD3 = {
    "line.rd3": TRACES,
    "line.rad": b"SAMPLES:32\r\nFREQUENCY:5000.0\r\n"
    b"DISTANCE INTERVAL:0.02\r\nSIGNAL POSITION:2\r\n",
}
IPRB = {
    "line.iprb": TRACES,
    "line.iprh": b"SAMPLES: 32\r\nFREQUENCY: 5000\r\nDISTANCE INTERVAL: 0.02\r\n"
    b"DATA VERSION: 16\r\nZERO LEVEL: 2\r\n",
}
DZT = {"line.dzt": dzt_file(np.zeros((1, 32, 32)), (40.0,))}
PAIR = {"pair.dzt": dzt_file(np.zeros((2, 5, 32)), (40.0, 40.0))}
IDS = {"line.dt": ids_file(np.zeros((5, 128)))}


READERS: dict[str, Callable[[Path, np.random.Generator], None]] = {
    "csv": as_folder,
    "zip": as_zip,
    "dt1": survey(DT1),
    "rd3": survey(RD3),
    "iprb": survey(IPRB),
    "dzt": survey(DZT),
    "dzt of two": survey(PAIR),
    "dt": survey(IDS),
}


@pytest.mark.parametrize("kind", READERS)
def test_damaged_files_are_read_or_refused(kind: str, tmp_path: Path) -> None:
    refused = 0
    for seed in range(MUTATIONS):
        try:
            READERS[kind](tmp_path, np.random.default_rng([20261121, seed]))
        except Error as error:
            refused += 1
            assert "\n" not in str(error), (seed, error)
        except Exception as error:
            pytest.fail(f"seed {seed}: {type(error).__name__}: {error}")
    assert 0 < refused < MUTATIONS
