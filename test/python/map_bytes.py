"""Map files byte by byte, to make ones that are not sound: docs/map_format.md."""

import struct
from collections.abc import Iterator
from functools import partial

import numpy as np


def sealed(version: int, body: bytes) -> bytes:
    """A file with the checksum of its contents: FNV-1a by words of eight bytes."""
    total = 14695981039346656037
    for i in range(0, len(body), 8):
        word = int.from_bytes(body[i : i + 8], "little")
        total = ((total ^ word) * 1099511628211) % 2**64
    head = b"gprodom ground map %d\n" % version
    return head + struct.pack("<QQ", len(body), total) + body


def patched(body: bytes, at: int, form: str, value: float) -> bytes:
    """`body` with another value there."""
    new = struct.pack("<" + form, value)
    return body[:at] + new + body[at + len(new) :]


def bodies(whole: bytes) -> Iterator[tuple[str, bytes]]:
    """Files with a right checksum that make no sense, and what is said of each."""
    body = whole[len(b"gprodom ground map 4\n") + 16 :]
    assert sealed(4, body) == whole
    parents = 24
    (count,) = struct.unpack_from("<I", body, parents)
    ancestors = parents + 4 + 8 * count
    (count,) = struct.unpack_from("<I", body, ancestors)
    step = ancestors + 4 + 16 * count + 1
    (samples,) = struct.unpack_from("<Q", body, 8)
    rows = -(-samples // struct.unpack_from("<I", body, step)[0])
    antenna = step + 8
    (letters,) = struct.unpack_from("<I", body, antenna + 24)
    robot = antenna + 28 + letters
    (more,) = struct.unpack_from("<I", body, robot)
    errors = robot + 4 + more
    low_cut = errors + 24
    deviation = low_cut + 16
    runs = deviation + 4 * rows
    times = runs + 8 + 8 + 4 + 1 + 8
    assert struct.unpack_from("<I", body, step + 4) == (1,)  # session

    changed = partial(patched, body)
    yield "another spacing", changed(0, "d", 0.05)
    yield "too long", changed(8, "Q", 2**40)
    yield "columns make no sense", changed(8, "Q", 2**17)
    yield "columns make no sense", changed(8, "Q", 8)
    yield "sample interval", changed(16, "d", np.nan)
    yield "ends too early", changed(parents, "I", 2**31)
    yield "ends too early", changed(ancestors, "I", 2**31)
    yield "columns make no sense", changed(step, "I", 0)
    yield "columns make no sense", changed(step, "I", 1)
    yield "has no session", changed(step + 4, "I", 0)
    yield "ends too early", changed(step + 4, "I", 2**31)
    yield "not finite", changed(antenna, "d", np.inf)
    yield "ends too early", changed(antenna + 24, "I", 2**31)
    yield "too long", changed(antenna + 24, "I", 1000)
    yield "too long", changed(robot, "I", 1000)
    yield "out of range", changed(errors, "d", 0.0)
    yield "out of range", changed(errors + 8, "d", np.nan)
    yield "out of range", changed(errors + 16, "d", 11.0)
    yield "out of range", changed(low_cut, "d", 0.0)
    yield "out of range", changed(low_cut, "d", np.nan)
    yield "out of range", changed(low_cut + 8, "d", 1e9)
    yield "out of range", changed(deviation, "f", 0.0)
    yield "out of range", changed(deviation, "f", np.nan)
    yield "", changed(runs, "Q", 2**60)  # what follows the runs is no run
    yield "ends too early", changed(runs + 8, "Q", 2**60)
    yield "do not agree", changed(runs + 16, "I", 1)
    yield "not finite", changed(runs + 21, "d", np.nan)
    yield "go back", changed(times, "q", 2**62)
    yield "a place of it makes no sense", changed(len(body) - 44 + 8, "d", np.nan)
    yield "a place of it makes no sense", changed(len(body) - 44, "Q", 2**40)
    yield "more than it should", body + b"\0"


def bodies_of_version_1(body: bytes) -> Iterator[tuple[str, bytes]]:
    """The same of version 1."""
    rows, samples = struct.unpack_from("<II", body, 25)
    projection = 33
    after = projection + 4 * rows * samples + 4 * 8
    times = after + 8 + 8 + 1 + 8

    changed = partial(patched, body)
    yield "too long", changed(25, "I", 2**31)
    yield "ends too early", changed(25, "I", 2**19)
    yield "out of range", changed(projection, "f", np.inf)
    yield "", changed(after, "Q", 2**60)  # what follows the runs is no run
    yield "ends too early", changed(after + 8, "Q", 2**60)
    yield "not finite", changed(after + 17, "d", np.nan)
    yield "go back", changed(times, "q", 2**62)
    yield "a place of it makes no sense", changed(len(body) - 44, "Q", 2**40)
    yield "more than it should", body + b"\0"


def version_1(columns: int = 200) -> bytes:
    """What follows the seal in a file of version 1: a run of noise, and two places."""
    random, rows, samples = np.random.default_rng(1), 8, 32
    parts = [struct.pack("<dQdBII", 0.02, samples, 4e-10, 1, rows, samples)]
    parts.append(random.standard_normal((rows, samples)).astype("<f4").tobytes())
    parts.append(struct.pack("<4d", 1.6e-9, 3e8, 25.0, 2.0))
    parts.append(struct.pack("<QQbd", 1, columns, 1, 0.0))
    parts.append((1_700_000_000 * 10**9 + 10**8 * np.arange(columns)).astype("<i8").tobytes())
    parts.append(random.integers(-60, 61, (columns, rows), dtype=np.int8).tobytes())
    parts.append(struct.pack("<Q", 2))
    parts.extend(struct.pack("<Qddddi", i, 0.02 * i, 0.02 * i, 0.0, 0.0, 0) for i in (0, 150))
    return b"".join(parts)
