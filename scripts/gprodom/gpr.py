"""Radar processing on numpy arrays: the stages of the C++ front ends, each usable alone.

Traces are arrays (traces, samples), oldest first; feature matrices (rows of depth, columns along
the track). Every function's docstring and its C++ header (include/gprodom/gpr/) state units.
"""

from gprodom._core import (
    Alignment,
    DetailsRetention,
    FilterConfig,
    align_bscan,
    align_curves,
    align_sfm,
    band_pass,
    build_sfm,
    check_traces,
    design_band_pass,
    dewow,
    dominant_energy_curve,
    gain_curve,
    iswt,
    keep_details,
    remove_background,
    standstills,
    swt,
    track_time_zero,
)

__all__ = [
    "Alignment",
    "DetailsRetention",
    "FilterConfig",
    "align_bscan",
    "align_curves",
    "align_sfm",
    "band_pass",
    "build_sfm",
    "check_traces",
    "design_band_pass",
    "dewow",
    "dominant_energy_curve",
    "gain_curve",
    "iswt",
    "keep_details",
    "remove_background",
    "standstills",
    "swt",
    "track_time_zero",
]
