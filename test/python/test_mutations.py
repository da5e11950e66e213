"""Foreign files, damaged in many ways: each is either read or refused with one line.

Seeded, so that a failure comes again; GPRODOM_MUTATIONS=100000 runs for longer.
"""

from __future__ import annotations

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

MUTATIONS = int(os.environ.get("GPRODOM_MUTATIONS", "300"))
WORDS = [
    b"nan",
    b"inf",
    b"-1",
    b"1e999",
    b"99999999999",
    b"\0",
    b",",
    b"\r\n",
    b"0x1",
    b"_",
    b"\xff",
]
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
    rows = [1_611_959_465 + 0.05 * i for i in range(12)]
    lines = {
        "imu_meas.csv": ("t,a_x,a_y,a_z,g_x,g_y,g_z,w,x,y,z", "0.1,-0.2,9.79,0.0,0.0,0.0,1,0,0,0"),
        "we_odom_meas.csv": ("Time[s],Range[m]", "0.125"),
        "gpr_meas.csv": ("t_stamp," + ",".join(f"amp_{i}" for i in range(20)), "7," * 19 + "7"),
        "ts_meas.csv": ("Time[s],Px[m],Py[m],Pz[m]", "1.5,-2.25,1.125"),
    }
    return {
        name: "\r\n".join(
            [header, *(f"{t:.6f},{values}" for t in rows for values in [row])]
        ).encode()
        for name, (header, row) in lines.items()
    }


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
DZT = {
    "line.dzt": struct.pack("<4Hh5f", 255, 1024, 32, 16, 0, 20.0, 50.0, 0.0, 0.0, 40.0).ljust(
        1024, b"\0"
    )
    + TRACES
}


PAIR = {"pair.dzt": dzt_file(np.zeros((2, 5, 32)), (40.0, 40.0))}
IDS = {"line.dt": ids_file(np.zeros((5, 128)))}


@pytest.mark.parametrize(
    "read",
    [
        as_folder,
        as_zip,
        survey(DT1),
        survey(RD3),
        survey(IPRB),
        survey(DZT),
        survey(PAIR),
        survey(IDS),
    ],
    ids=["csv", "zip", "dt1", "rd3", "iprb", "dzt", "dzt of two", "dt"],
)
def test_damaged_files_are_read_or_refused(
    read: Callable[[Path, np.random.Generator], None], tmp_path: Path
) -> None:
    refused = 0
    for seed in range(MUTATIONS):
        try:
            read(tmp_path, np.random.default_rng([20261121, seed]))
        except Error as error:
            refused += 1
            assert "\n" not in str(error), (seed, error)
        except Exception as error:
            pytest.fail(f"seed {seed}: {type(error).__name__}: {error}")
    assert 0 < refused < MUTATIONS
