"""Radar processing on numpy arrays: the stages of the C++ front ends, each usable alone.

Traces are arrays (traces, samples), oldest first; feature matrices (rows of depth, columns along
the track). Every function's docstring and its C++ header (include/gprodom/gpr/) state units.
"""

from gprodom._core import (
    Alignment,
    align_bscan,
    align_curves,
    align_sfm,
    build_sfm,
    dominant_energy_curve,
)

__all__ = [
    "Alignment",
    "align_bscan",
    "align_curves",
    "align_sfm",
    "build_sfm",
    "dominant_energy_curve",
]
