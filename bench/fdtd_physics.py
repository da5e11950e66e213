#!/usr/bin/env python3
"""The FDTD ground against physics: small scenes whose answer is known in closed form.

    direct wave   in air, receiver at two separations: arrivals differ by the way over c
    pipe          a metal pipe in even ground: its hyperbola, transmitter to pipe to receiver over
                  v, against its apex, 40 cm to either side with the antenna in the ground
    pipe seen     the same with the antenna on the surface, 20 cm to either side: further aside the
    from above    way leaves the surface beyond the critical angle, where the wave's phase turns
    layer         two depths of a layer's edge: arrivals differ by the way over v
    attenuation   the deeper echo against the same without loss: exp(-path sigma/2 sqrt(mu/epsilon))

Arrivals are compared by the peak of the cross-correlation, interpolated. Half a sample is 0.1 ns.
Needs the extra `fdtd`; takes about 20 s. Exit code 1 where a figure is off by more than its bound.

    bench/fdtd_physics.py
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.optimize import minimize_scalar

from gprodom.arrays import Floats
from gprodom.console import format_table
from gprodom.ground.fdtd import SPEED_OF_LIGHT, simulate_line
from gprodom.ground.materials import sections
from gprodom.ground.scene import Antenna, Layer, Pipe, Scene
from program import exit_with, parser_of, print_figures

INTERVAL = 2e-10  # s
CELL = 0.01  # m
HALF_SAMPLE_NS = 0.1
PERMITTIVITY, BELOW = 6.0, 9.0
LOSS = 0.01  # S/m
IMPEDANCE = 376.73  # ohm, of free space
PIPE = Pipe(x=2.0, depth=0.35, radius=0.03, conductivity=1e6)
BURIED = 0.25  # m, the antenna under the surface, so that what comes back from that is late
DEPTHS = (0.25, 0.45)  # m, of the layer's edge
# Bounds, and what of them is known beforehand: dispersion on the grid is under half a sample.
BOUNDS = {
    "direct_wave_ns": HALF_SAMPLE_NS,
    "pipe_ns": HALF_SAMPLE_NS,
    "pipe_from_above_ns": HALF_SAMPLE_NS,
    "layer_ns": HALF_SAMPLE_NS,
    "attenuation_pct": 8.0,
}


def ground(*layers: Layer, pipes: tuple[Pipe, ...] = ()) -> Scene:
    """A scene of one line in which nothing is drawn."""
    return Scene(
        "physics",
        layers,
        pipes=pipes,
        length=4.0,
        aside=(0.0,),
        window=(1.5, 0.9),
        samples=110,
        cell=CELL,
    )


def traces(scene: Scene, places: Floats) -> Floats:
    """(n, samples), V/m, at `places` (n,), m."""
    return simulate_line(scene, sections(scene, scene.window[1])[0], places)


def delay(later: Floats, earlier: Floats) -> float:
    """Seconds by which `later` (samples,) comes after `earlier`."""
    finer = 16
    n = 2 * len(later)
    product = np.fft.rfft(later, n) * np.conj(np.fft.rfft(earlier, n))
    correlation = np.fft.irfft(product, n * finer)
    shift = int(np.argmax(correlation))
    if shift > n * finer // 2:
        shift -= n * finer
    a, b, c = (correlation[(shift + k) % len(correlation)] for k in (-1, 0, 1))
    return float((shift + 0.5 * (a - c) / (a - 2 * b + c)) * INTERVAL / finer)


def hyperbola(plain: Scene, pipe: Pipe, offsets: Floats) -> float:
    """The largest error of its arrivals against those over its middle, s."""
    places = pipe.x + offsets
    apex = int(np.argmin(np.abs(offsets)))
    empty = traces(plain, places[apex : apex + 1])[0]
    echoes = traces(replace(plain, pipes=(pipe,)), places) - empty
    paths = np.array([pipe_path(x, plain.antenna, pipe) for x in places.tolist()])
    expected = (paths - paths[apex]) * np.sqrt(PERMITTIVITY) / SPEED_OF_LIGHT
    return float(np.abs([delay(echo, echoes[apex]) for echo in echoes] - expected).max())


def pipe_path(x: float, antenna: Antenna, pipe: Pipe) -> float:
    """Metres from transmitter to pipe to receiver with the antenna's middle at `x` (m)."""
    # Where the FDTD has it (`gprodom.ground.fdtd`): half a cell back along the line, and half a
    # cell further from an antenna in the ground.
    middle = pipe.x - CELL / 2
    below = pipe.depth + antenna.height + CELL / 2

    def length(angle: float) -> float:
        px, pz = middle + pipe.radius * np.sin(angle), below - pipe.radius * np.cos(angle)
        legs = (np.hypot(x + side * antenna.separation / 2 - px, pz) for side in (-1, 1))
        return float(sum(legs))

    return float(minimize_scalar(length, bounds=(-1.5, 1.5), method="bounded").fun)


def measure() -> dict[str, float]:
    """The largest error of each kind."""
    speed = SPEED_OF_LIGHT / np.sqrt(PERMITTIVITY)
    middle = np.array([PIPE.x])
    air = ground(Layer("air", 1.0, 0.0))
    near, far = (replace(air, antenna=Antenna(separation=d)) for d in (0.2, 0.5))
    direct = delay(traces(far, middle)[0], traces(near, middle)[0])

    even = Layer("even", PERMITTIVITY, 0.0)
    plain = ground(even)
    empty = traces(plain, middle)[0]
    above = hyperbola(plain, PIPE, np.arange(-0.2, 0.21, 0.1))
    buried = replace(plain, antenna=Antenna(height=-BURIED))
    pipe = hyperbola(buried, replace(PIPE, depth=PIPE.depth + BURIED), np.arange(-0.4, 0.41, 0.1))

    def edge(depth: float, loss: float) -> Floats:
        upper = Layer("upper", PERMITTIVITY, loss, thickness=depth)
        whole = empty if not loss else traces(ground(replace(even, conductivity=loss)), middle)[0]
        return traces(ground(upper, Layer("lower", BELOW, loss)), middle)[0] - whole

    upper, lower = (edge(depth, 0.0) for depth in DEPTHS)
    half = plain.antenna.separation / 2
    ways = [2 * float(np.hypot(depth, half)) for depth in DEPTHS]
    layer = delay(lower, upper) - (ways[1] - ways[0]) / speed

    lossy = [
        float(np.ptp(edge(depth, LOSS)) / np.ptp(a))
        for depth, a in zip(DEPTHS, (upper, lower), strict=True)
    ]
    # Between the two depths, so that what loss does to the antenna's own field drops out.
    expected = np.exp(-(ways[1] - ways[0]) * LOSS / 2 * IMPEDANCE / np.sqrt(PERMITTIVITY))
    return {
        "direct_wave_ns": abs(direct - 0.3 / SPEED_OF_LIGHT) * 1e9,
        "pipe_ns": pipe * 1e9,
        "pipe_from_above_ns": above * 1e9,
        "layer_ns": abs(layer) * 1e9,
        "attenuation_pct": float(abs(lossy[1] / lossy[0] / expected - 1)) * 100,
    }


def main() -> int:
    """Measures and prints."""
    args = parser_of(__doc__).parse_args()
    errors = measure()
    rows = [[name, error, BOUNDS[name]] for name, error in errors.items()]
    print_figures(args, errors, format_table(["error", "measured", "bound"], rows))
    return 0 if all(error < BOUNDS[name] for name, error in errors.items()) else 1


if __name__ == "__main__":
    exit_with(main)
