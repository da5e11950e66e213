"""Radar traces over synthetic ground: point scatterers and wavy layers, by travel time.

The trace depends on the position of the antenna only: over the same spot it is the same, up to
noise. No wave physics beyond travel time, spreading and attenuation.
"""

from dataclasses import dataclass

import numpy as np

from gprodom.arrays import Floats, Ints
from gprodom.random_streams import Random

_REACH = 1.5  # m; scatterers further aside are not seen
_HALF_WAVELET = 3e-9  # s; the wavelet is nothing beyond


@dataclass(frozen=True)
class GroundSpec:
    """The ground and the wavelet that it is seen with."""

    samples: int = 201
    sample_interval: float = 2e-10  # s
    frequency: float = 5e8  # Hz, of the wavelet
    wave_speed: float = 1e8  # m/s
    surface_time: float = 4e-9  # s, when the ground's surface is seen
    scatterers: float = 8.0  # per m^2
    depth: tuple[float, float] = (0.08, 1.5)  # m, of scatterers
    layers: tuple[float, ...] = (0.45, 1.1)  # m, mean depths
    waviness: float = 1.0  # of the layers, along the ground; 0: even, alike everywhere
    attenuation: float = 1.2  # 1/m, of amplitude over depth
    amplitude: float = 12000.0  # counts, of a scatterer near the surface
    direct: float = 14000.0  # counts, of the wave that goes straight across
    # Relative change of the permittivity, evenly from the surface to `depth`'s end; (): none.
    permittivity: tuple[float, ...] = ()
    pipes: tuple[tuple[float, float], ...] = ()  # m: x, depth of each; they lie along y


def _wavelet(t: Floats, frequency: float) -> Floats:
    """Ricker wavelet, 1 at its middle."""
    a = (np.pi * frequency * t) ** 2
    return np.asarray((1 - 2 * a) * np.exp(-a))


class Ground:
    """Ground around the positions `x`, `y` (m) that the antenna will see."""

    def __init__(self, spec: GroundSpec, x: Floats, y: Floats, random: Random) -> None:
        self._spec = spec
        low = np.array([x.min(), y.min()]) - _REACH
        size = np.array([x.max(), y.max()]) + _REACH - low
        count = round(spec.scatterers * float(size.prod()))
        self._position = low + size * random.uniform(size=(count, 2))
        self._depth = random.uniform(*spec.depth, size=count)
        self._strength = random.uniform(0.3, 1.0, count) * random.choice([-1.0, 1.0], count)
        # Each layer: four waves of depth and of reflectivity across the ground.
        shape = (len(spec.layers), 4)
        angle, length = random.uniform(0, np.pi, shape), random.uniform(0.4, 3.0, shape)
        self._waves = 2 * np.pi / length * np.stack([np.cos(angle), np.sin(angle)])
        self._phase = random.uniform(0, 2 * np.pi, shape)

    def traces(self, x: Floats, y: Floats) -> Floats:
        """Noise-free traces (n, samples), counts, at the positions `x`, `y` (n,), m."""
        spec = self._spec
        time = np.arange(spec.samples) * spec.sample_interval
        result = np.tile(
            spec.direct * _wavelet(time - 0.75 * spec.surface_time, spec.frequency)
            - 0.6 * spec.direct * _wavelet(time - spec.surface_time, spec.frequency),
            (len(x), 1),
        )
        for start in range(0, len(x), 256):  # bounds the memory
            part = slice(start, start + 256)
            result[part] += self._reflections(x[part], y[part])
        return result

    def _reflections(self, x: Floats, y: Floats) -> Floats:
        spec = self._spec
        aside = np.hypot(x[:, None] - self._position[:, 0], y[:, None] - self._position[:, 1])
        trace, which = np.nonzero(aside < _REACH)
        near = aside[trace, which]
        distance = np.hypot(near, self._depth[which])
        # The antenna looks downwards; nothing may jump where a scatterer comes into reach.
        beam = (self._depth[which] / distance) ** 2 * (1 - (near / _REACH) ** 2) ** 2
        strength = self._strength[which] * beam
        echoes = [(trace, distance, strength)]
        for place, depth in spec.pipes:
            off = np.abs(x - place)
            over = np.flatnonzero(off < _REACH)
            distance = np.hypot(off[over], depth)
            beam = (depth / distance) ** 2 * (1 - (off[over] / _REACH) ** 2) ** 2
            echoes.append((over, distance, beam))
        for layer, mean in enumerate(spec.layers):
            kx, ky = self._waves[:, layer]
            wave = np.sin(np.outer(x, kx) + np.outer(y, ky) + self._phase[layer]).sum(axis=1)
            wave = spec.waviness * wave
            reflectivity = 0.35 + 0.1 * np.sin(1.7 * wave + layer)
            echoes.append((np.arange(len(x)), mean * (1 + 0.04 * wave), reflectivity))
        rows, distances, strengths = (np.concatenate(parts) for parts in zip(*echoes, strict=True))
        fading = np.exp(-spec.attenuation * distances) / (distances + 0.3) * 0.35
        arrival = spec.surface_time + self._travel_time(distances)
        return self._place(rows, arrival, spec.amplitude * strengths * fading, len(x))

    def _travel_time(self, distance: Floats) -> Floats:
        """There and back, s. Changed permittivity changes it as a path straight down has it."""
        spec = self._spec
        as_it_was = 2 * distance / spec.wave_speed
        if not spec.permittivity:
            return as_it_was
        depth = np.linspace(0, spec.depth[1], 200)
        knots = np.linspace(0, spec.depth[1], len(spec.permittivity))
        slower = np.sqrt(1 + np.interp(depth, knots, spec.permittivity))
        mean = np.cumsum(slower) / np.arange(1, len(depth) + 1)
        return np.asarray(as_it_was * np.interp(distance, depth, mean))

    def _place(self, rows: Ints, arrival: Floats, amplitude: Floats, count: int) -> Floats:
        """Sums wavelets of `amplitude` at the times `arrival` into the traces `rows`."""
        spec = self._spec
        half = int(np.ceil(_HALF_WAVELET / spec.sample_interval))
        first = np.rint(arrival / spec.sample_interval).astype(np.int64) - half
        column = first[:, None] + np.arange(2 * half + 1)
        late = column * spec.sample_interval - arrival[:, None]
        value = amplitude[:, None] * _wavelet(late, spec.frequency)
        inside = (column >= 0) & (column < spec.samples)
        cell = (rows[:, None] * spec.samples + column)[inside]
        total = np.bincount(cell, weights=value[inside], minlength=count * spec.samples)
        return total.reshape(count, spec.samples)
