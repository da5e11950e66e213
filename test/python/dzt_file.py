"""GSSI files (DZT) of several channels, made for tests."""

import struct
from collections.abc import Sequence

import numpy as np

HEADER = 1024  # bytes, of each channel


def dzt_file(traces: np.ndarray, windows: Sequence[float], samples: Sequence[int] = ()) -> bytes:
    """traces: (channels, n, samples), counts of 16 bits. windows: ns, of each channel's header;
    0: that header is empty. samples: what each header says of them, where not the truth."""
    channels, _, width = traces.shape
    heads = bytearray(HEADER * channels)
    for channel, window in enumerate(windows):
        if window:
            said = samples[channel] if samples else width
            start = HEADER * channel
            struct.pack_into("<4Hh", heads, start, 255, 1, said, 16, 0)
            struct.pack_into("<5f", heads, start + 10, 0.0, 20.0, 0.0, 0.0, window)
            struct.pack_into("<H", heads, start + 52, channels)
    body = (np.swapaxes(traces, 0, 1) + 32768).astype("<u2")
    return bytes(heads) + body.tobytes()
