"""Survey files of IDS, made for tests."""

import struct

import numpy as np


def ids_file(traces: np.ndarray, counted: int | None = None, channels: int = 1) -> bytes:
    """With a header that agrees with itself: 2 cm, 0.2 ns."""
    count, samples = traces.shape
    width = 4 + 2 * max(samples, 110)
    numbers = [2e8, 1e8, samples * 2e-10, 0, 50, 0.02, 0.02, 0, 0, 2e-10]
    head = b"H\x15\x04\0" + struct.pack("<3I", width, counted or count, samples)
    head = head.ljust(48, b"\0") + b"".join(b"%16.6E" % number for number in numbers)
    rows = [b"V\x03\0\0" + struct.pack("<H", width), b"S\0\0\0RT N_CHANNEL= %d" % channels, head]
    rows += [b"R\0\0\0" + trace.astype("<i2").tobytes() for trace in traces]
    return b"".join(row.ljust(width, b"\0") for row in rows)
