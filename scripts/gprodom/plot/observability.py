"""Does the shift of a time-ordered window measure the displacement?

A window of radar traces and the same window a few traces later share most of their traces, so the
best match shifts by the number of new traces, whatever the robot did. Here that is measured.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from gprodom import canvas
from gprodom.arrays import Floats, Ints
from gprodom.calibrate.k import Shifts, fit_k

MANY = 2000  # windows: beyond, points are pale, so that it is seen where they are dense


@dataclass(frozen=True)
class Observed:
    """Windows with truth: shifts (n,), in the front end's units, and true displacements (n,), m,
    signed by the wheel's direction (the truth has no heading)."""

    shift: Floats
    displacement: Floats


@dataclass(frozen=True)
class Observability:
    """Figures of one front end.

    windows: with truth. commonest_shift: the most frequent integer; commonest_share: its share of
    the windows. correlation: of shift and signed displacement; correlation_size: of their
    sizes; None where one of them never changes. k: metres per unit, fitted on the same windows;
    residual_rms_m: what it leaves; constant_rms_m: what one constant displacement for all leaves.
    displacement_min_m, displacement_max_m: range of the true displacements.
    """

    windows: int
    commonest_shift: int
    commonest_share: float
    shift_std: float
    correlation: float | None
    correlation_size: float | None
    k: float
    residual_rms_m: float
    constant_rms_m: float
    displacement_min_m: float
    displacement_max_m: float


def observe(shifts: Shifts, wheel_time: Ints, wheel: Floats) -> Observed:
    """Joins shifts with true displacements, the latter signed by the wheel."""
    known = np.isfinite(shifts.distance)
    origin = wheel_time[0]
    clock = (wheel_time - origin) * 1e-6
    turned = np.interp((shifts.end - origin) * 1e-6, clock, wheel)
    turned -= np.interp((shifts.start - origin) * 1e-6, clock, wheel)
    return Observed(shifts.shift[known], np.copysign(shifts.distance, turned)[known])


def pool(parts: Sequence[Observed]) -> Observed:
    """The windows of several sequences together."""
    return Observed(
        np.concatenate([part.shift for part in parts]),
        np.concatenate([part.displacement for part in parts]),
    )


def measure(seen: Observed) -> Observability:
    """The figures of one front end's windows."""
    values, counts = np.unique(np.rint(seen.shift).astype(int), return_counts=True)
    size, distance = np.abs(seen.shift), np.abs(seen.displacement)
    index = np.arange(size.size)
    k = fit_k([Shifts(index, index + 1, size, distance)]).k
    return Observability(
        windows=int(size.size),
        commonest_shift=int(values[np.argmax(counts)]),
        commonest_share=float(counts.max() / size.size),
        shift_std=float(seen.shift.std()),
        correlation=_correlation(seen.shift, seen.displacement),
        correlation_size=_correlation(size, distance),
        k=k,
        residual_rms_m=float(np.sqrt(np.mean((distance - k * size) ** 2))),
        constant_rms_m=float(distance.std()),
        displacement_min_m=float(seen.displacement.min()),
        displacement_max_m=float(seen.displacement.max()),
    )


def _correlation(a: Floats, b: Floats) -> float | None:
    if a.std() < 1e-9 or b.std() < 1e-9:
        return None
    return float(np.corrcoef(a, b)[0, 1])


def observability_figure(
    seen: Mapping[str, Observed], figures: Mapping[str, Observability]
) -> canvas.Figure:
    """Shift against true displacement, the front ends side by side."""
    figure, axes = canvas.new_figure(1, len(seen), width=5.0 * len(seen), height=4.4)
    for axis, (name, windows) in zip(axes, seen.items(), strict=True):
        _draw(axis, windows)
        found = figures[name]
        link = "-" if found.correlation is None else f"{found.correlation:.2f}"
        axis.set_title(
            f"{name}: {found.windows} windows, correlation {link},\n"
            f"shift {found.commonest_shift} in {100 * found.commonest_share:.0f} %"
        )
    axes[0].set_ylabel("shift (columns, or traces)")
    return figure


def _draw(axis: canvas.Axes, windows: Observed) -> None:
    axis.plot(
        windows.displacement,
        windows.shift,
        ".",
        color=canvas.COLOURS[0],
        markersize=3,
        alpha=0.3 if len(windows.shift) > MANY else 0.7,
        markeredgewidth=0,
    )
    axis.set_xlabel("true displacement over the window's step (m)")
    axis.margins(0.05)
