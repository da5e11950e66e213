"""How far an estimate is from surveyed markers, visit by visit."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from gprodom import canvas
from gprodom.arrays import Floats
from gprodom.errors import Error
from gprodom.fixes.markers import Marker
from gprodom.fixes.record import Frame
from gprodom.geodesy import Datum
from gprodom.score.align import fit_planar
from gprodom.trajectory import Trajectory, interpolate

Places = dict[int, tuple[float, float, float]]  # of antennas in body, m
MOST_SAMPLES = 50  # of the estimate over one visit


@dataclass(frozen=True)
class Residual:
    """Estimate less marker at a visit, m. sigma_m: of the larger axis, of both together; None where
    the estimate tells none."""

    name: str
    utime: int
    marker: tuple[float, float]
    x_m: float
    y_m: float
    off_m: float
    sigma_m: float | None


@dataclass(frozen=True)
class Survey:
    """The residuals, the path in the markers' frame, and the visits that it does not cover."""

    residuals: list[Residual]
    path: Trajectory
    uncovered: list[str]

    @property
    def rms_m(self) -> float:
        """Over the visits."""
        return float(np.sqrt(np.mean([each.off_m**2 for each in self.residuals])))

    def facts(self) -> dict[str, Any]:
        """For --json."""
        return {
            "markers": [asdict(each) for each in self.residuals],
            "rms_m": self.rms_m,
            "uncovered": self.uncovered,
        }


def in_site(markers: Sequence[Marker], datum: Datum | None) -> Floats:
    """Positions (n, 3), m."""
    positions = np.array([marker.position for marker in markers])
    if markers[0].frame == Frame.SITE:
        return positions
    if datum is None:
        raise Error(
            "the markers are in degrees, and nothing tells where site lies: give --datum "
            "LAT,LON,HEIGHT (or anchor.datum in the configuration)"
        )
    return datum.to_local(positions)


def compare(
    path: Trajectory, markers: Sequence[Marker], places: Floats, antennas: Places, align: bool
) -> Survey:
    """places: of the markers in site (n, 3), m. align: turns and moves the path by se2 to fit."""
    kept, found, variances = [], [], []
    for i, marker in enumerate(markers):
        if not path.time[0] <= marker.begin <= marker.end <= path.time[-1]:
            continue
        times = np.unique(np.linspace(marker.begin, marker.end, MOST_SAMPLES).astype(np.int64))
        stood = interpolate(path, times)
        lever = np.array(antennas.get(marker.antenna, (0.0, 0.0, 0.0)))
        kept.append(i)
        found.append((stood.moved(lever) if lever.any() else stood).position.mean(axis=0))
        variances.append(
            np.nan
            if stood.covariance is None
            else float(np.linalg.eigvalsh(stood.covariance[len(times) // 2, :2, :2])[-1])
        )
    if not kept:
        raise Error("none of the markers was visited while there was an estimate")
    seen, known = np.array(found), places[kept]
    if align:
        if len(np.unique(known[:, :2], axis=0)) < 2:
            raise Error("--align se2 wants two markers at different places")
        fit = fit_planar(seen, known)
        seen = seen @ fit.matrix.T + fit.translation
        path = path.transformed(fit.matrix, fit.translation)
    residuals = []
    for i, off, variance, place in zip(kept, seen - known, variances, known, strict=True):
        marker = markers[i]
        sigma = float(np.sqrt(variance + marker.sigma**2))
        residuals.append(
            Residual(
                marker.name,
                marker.middle,
                (float(place[0]), float(place[1])),
                float(off[0]),
                float(off[1]),
                float(np.hypot(*off[:2])),
                sigma if np.isfinite(sigma) else None,
            )
        )
    uncovered = [marker.name for i, marker in enumerate(markers) if i not in kept]
    return Survey(residuals, path, uncovered)


def survey_figure(survey: Survey) -> canvas.Figure:
    """The path with the markers, and beside it the residuals."""
    figure, axes = canvas.new_figure(1, 2, width=12.0, height=5.5)
    way, off = axes
    way.plot(*survey.path.position[:, :2].T, color=canvas.COLOURS[0], lw=1.0, label="path")
    places = np.array([each.marker for each in survey.residuals])
    way.plot(*places.T, "^", color=canvas.COLOURS[1], ms=7, label="markers")
    names: dict[tuple[float, float], str] = {each.marker: each.name for each in survey.residuals}
    for place, name in names.items():
        way.annotate(name, place, xytext=(4, 4), textcoords="offset points")
    way.set_title("Path and markers, in site")
    for each in survey.residuals:
        off.plot(each.x_m, each.y_m, "o", color=canvas.COLOURS[0], ms=5)
        off.annotate(each.name, (each.x_m, each.y_m), xytext=(4, 4), textcoords="offset points")
    reach = 1.2 * max([each.off_m for each in survey.residuals] + [1e-3])
    off.set(xlim=(-reach, reach), ylim=(-reach, reach))
    off.set_title(f"Estimate less marker: RMS {survey.rms_m:.3f} m")
    for axis in axes:
        axis.set(xlabel="x (m)", ylabel="y (m)")
        axis.set_aspect("equal")
        axis.grid(True, alpha=0.3)
    canvas.legend_below(way, 2)
    return figure
