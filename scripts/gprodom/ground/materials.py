"""The cells of a scene: which material is where in each vertical plane, on the grid of the FDTD."""

from dataclasses import dataclass

import numpy as np

from gprodom.arrays import Floats, Ints
from gprodom.ground.scene import Bars, Pipe, Scene, Stones
from gprodom.random_streams import stream

_METAL = 1e6  # S/m; as good as perfect at a cell of a centimetre
_LEVELS = 0.04  # of permittivity, relative: finer differences are one material


@dataclass(frozen=True)
class Section:
    """A vertical plane: `cells` (n along the line, m in depth) of int16 indices into `materials`.

    materials: (relative permittivity, conductivity in S/m) of each.
    """

    cells: Ints
    materials: tuple[tuple[float, float], ...]


def sections(scene: Scene, depth: float) -> list[Section]:
    """One for each line of the scene, down to `depth` (m)."""
    return [_section(scene, depth, number) for number in range(len(scene.aside))]


def _section(scene: Scene, depth: float, number: int) -> Section:
    columns, rows = round(scene.length / scene.cell), round(depth / scene.cell)
    x = (np.arange(columns) + 0.5) * scene.cell
    z = (np.arange(rows) + 0.5) * scene.cell
    permittivity = np.zeros((columns, rows))
    conductivity = np.zeros((columns, rows))
    top = np.zeros(columns)
    for index, layer in enumerate(scene.layers):
        name = f"layer {index}"
        grain = _related(scene, number, name, (columns, rows), layer.grain)
        factor = np.clip(1 + layer.variation * grain, 0.4, 1.8)
        below = z >= top[:, None]
        permittivity = np.where(below, np.maximum(layer.permittivity * factor, 1), permittivity)
        conductivity = np.where(below, layer.conductivity * factor, conductivity)
        lengths = (layer.roughness_length, 1.0)
        rough = _related(scene, number, name + " edge", (columns, 1), lengths)[:, 0]
        top = top + layer.thickness + layer.roughness * rough
    place = _Placer(scene, number, x, z, permittivity, conductivity)
    for i, bars in enumerate(scene.bars):
        place.bars(bars, f"bars {i}")
    for i, stones in enumerate(scene.stones):
        place.stones(stones, f"stones {i}")
    for pipe in scene.pipes:
        place.pipe(pipe)
    return _quantised(permittivity, conductivity)


def _quantised(permittivity: Floats, conductivity: Floats) -> Section:
    """Few materials: both quantities in steps of `_LEVELS`, relative."""
    step = np.log1p(_LEVELS)
    level = np.rint(np.log(permittivity) / step).astype(np.int64)
    loss = np.rint(np.log(np.maximum(conductivity, 1e-6)) / step).astype(np.int64)
    pairs, cells = np.unique(np.stack([level.ravel(), loss.ravel()]), axis=1, return_inverse=True)
    materials = tuple(
        (float(np.exp(a * step)), float(np.exp(b * step)) if np.exp(b * step) > 1.1e-6 else 0.0)
        for a, b in pairs.T.tolist()
    )
    return Section(cells.reshape(permittivity.shape).astype(np.int16), materials)


def _related(
    scene: Scene, number: int, name: str, shape: tuple[int, int], lengths: tuple[float, float]
) -> Floats:
    """A Gaussian random field of unit variance in plane `number`, periodic along the line.

    Fields of planes a distance d aside are correlated by exp(-(d / length)^2).
    """
    field = _field(scene, f"{name} 0", shape, lengths)
    for plane in range(1, number + 1):
        apart = scene.aside[plane] - scene.aside[plane - 1]
        kept = float(np.exp(-((apart / lengths[0]) ** 2)))
        fresh = _field(scene, f"{name} {plane}", shape, lengths)
        field = kept * field + np.sqrt(1 - kept**2) * fresh
    return field


def _field(scene: Scene, name: str, shape: tuple[int, int], lengths: tuple[float, float]) -> Floats:
    """White noise smoothed by Gaussians of the lengths (m), circularly: unit variance."""
    spectrum = np.fft.fft2(stream(scene.seed, name).standard_normal(shape))
    for axis, length in enumerate(lengths):
        frequency = np.fft.fftfreq(shape[axis], scene.cell)
        weight = np.exp(-((np.pi * frequency * length) ** 2) / 2)
        weight /= np.sqrt(np.mean(weight**2))
        spectrum *= weight[:, None] if axis == 0 else weight[None, :]
    return np.asarray(np.fft.ifft2(spectrum).real)


class _Placer:
    """Puts objects into the arrays of one plane."""

    def __init__(
        self, scene: Scene, number: int, x: Floats, z: Floats, permittivity: Floats, loss: Floats
    ) -> None:
        self._scene, self._number = scene, number
        self._x, self._z = x[:, None], z[None, :]
        self._permittivity, self._conductivity = permittivity, loss

    def _ellipse(
        self, x: float, depth: float, radii: tuple[float, float], material: tuple[float, float]
    ) -> None:
        length = self._scene.length
        along = (self._x - x + length / 2) % length - length / 2
        inside = (along / radii[0]) ** 2 + ((self._z - depth) / radii[1]) ** 2 <= 1
        self._permittivity[inside], self._conductivity[inside] = material

    def bars(self, bars: Bars, name: str) -> None:
        random = stream(self._scene.seed, name)
        count = max(round(self._scene.length / bars.spacing), 1)
        places = np.arange(count) * (self._scene.length / count)
        places = places + bars.jitter * random.uniform(-1, 1, count)
        radius = max(bars.radius, 0.75 * self._scene.cell)  # at least a cell
        for x in places.tolist():
            self._ellipse(x, bars.depth, (radius, radius), (1.0, _METAL))

    def pipe(self, pipe: Pipe) -> None:
        x = pipe.x + float(np.tan(pipe.skew)) * self._scene.aside[self._number]
        material = (pipe.permittivity, pipe.conductivity)
        self._ellipse(x, pipe.depth, (pipe.radius, pipe.radius), material)

    def stones(self, stones: Stones, name: str) -> None:
        random = stream(self._scene.seed, name)
        scene = self._scene
        here = scene.aside[self._number]
        for _ in range(stones.number):
            x, depth = random.uniform(0, scene.length), random.uniform(*stones.depth)
            radius, permittivity = (
                random.uniform(*stones.radius),
                random.uniform(*stones.permittivity),
            )
            across = random.uniform(min(scene.aside) - radius, max(scene.aside) + radius)
            cut = 1 - ((here - across) / radius) ** 2
            if cut > 0:
                half = radius * float(np.sqrt(cut))
                self._ellipse(x, depth, (half, half / 2), (permittivity, stones.conductivity))
