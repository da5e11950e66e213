"""Survey lines of a scene by gprMax: 2-D FDTD, one model for each trace, round the antenna.

A node of gprMax's grid belongs to the cell that follows it. So the ground is shifted back by half a
cell along the line, and its surface is half a cell below the plane of `Antenna.height`.
"""

import contextlib
import io
import json
import logging
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from gprodom.arrays import Floats
from gprodom.errors import need_module
from gprodom.files import temporary_folder
from gprodom.ground.materials import Section, sections
from gprodom.ground.scene import Scene

SPEED_OF_LIGHT = 299_792_458.0  # m/s
_AIR = 0.14  # m, over the surface, absorbing boundary included
_PML = 10  # cells
_DATABASE = "scene"  # the materials' file
_AT_ONCE = 20  # models for one call of gprMax


def simulate_lines(scene: Scene, on_trace: Callable[[], None] = lambda: None) -> Floats:
    """Traces (lines, traces, samples) of all lines, V/m. `on_trace` is called after each."""
    places = np.arange(scene.traces) * scene.spacing
    depth = scene.window[1]
    return np.stack(
        [simulate_line(scene, section, places, on_trace) for section in sections(scene, depth)]
    )


def simulate_line(
    scene: Scene, section: Section, places: Floats, on_trace: Callable[[], None] = lambda: None
) -> Floats:
    """Traces (n, samples), V/m, with the antenna's middle at `places` (n,), m, in `section`.

    Sample 0 is when the source starts: the middle of its wavelet is `source_delay` later. Needs
    gprMax, the extra `fdtd` of the package.
    """
    with contextlib.redirect_stdout(io.StringIO()):
        gprmax = need_module("gprMax", "fdtd")
    result = np.zeros((len(places), scene.samples))
    for start in range(0, len(places), _AT_ONCE):
        part = places[start : start + _AT_ONCE]
        with temporary_folder() as folder:
            _write_materials(section, folder)
            models = [
                _model(gprmax, scene, section, float(x), folder / f"cells{i}.h5")
                for i, x in enumerate(part)
            ]
            _run(gprmax, models, folder / "field")
            for i in range(len(part)):
                # gprMax numbers its files only where there are several.
                number = str(i + 1) if len(part) > 1 else ""
                result[start + i] = _read_trace(scene, folder / f"field{number}.h5")
                on_trace()
    return result


def source_delay(scene: Scene) -> float:
    """Seconds from the first sample to the middle of gprMax's Ricker wavelet at the source."""
    return float(np.sqrt(2) / scene.antenna.frequency)


def cells_per_wavelength(scene: Scene) -> float:
    """In the layer of the slowest wave, at twice the wavelet's middle frequency (10 % of its peak).

    At 8 the phase velocity is 2 % low, at 16, the middle frequency, 0.6 %.
    """
    slowest = max(layer.permittivity for layer in scene.layers)
    speed = SPEED_OF_LIGHT / float(np.sqrt(slowest))
    return speed / (2 * scene.antenna.frequency) / scene.cell


def _run(gprmax: Any, models: list[Any], output: Path) -> None:
    logging.getLogger("gprMax").setLevel(logging.ERROR)
    with contextlib.redirect_stdout(io.StringIO()):
        gprmax.run(
            scenes=models,
            n=len(models),
            outputfile=str(output),
            log_level=logging.ERROR,
            hide_progress_bars=True,
            allow_underresolved=True,  # metal is; `cells_per_wavelength` looks after the rest
        )


def _model(gprmax: Any, scene: Scene, section: Section, x: float, cells: Path) -> Any:
    """The model of one trace. The plane is y (along the line) and z (up); x is one cell thick:
    gprMax's arrays run fastest along z."""
    cell, antenna = scene.cell, scene.antenna
    width = round(scene.window[0] / cell)
    rows = section.cells.shape[1]
    height = rows + round(_AIR / cell)
    _write_cells(section, scene, x, (width, height), cells)
    model = gprmax.Scene()
    model.add(gprmax.Domain(p1=(cell, width * cell, height * cell)))
    model.add(gprmax.Discretisation(p1=(cell, cell, cell)))
    model.add(gprmax.TimeWindow(time=(scene.samples + 2) * scene.sample_interval))
    model.add(gprmax.OMPThreads(n=1))
    model.add(gprmax.PMLThickness(thickness=(0, _PML, _PML, 0, _PML, _PML)))
    model.add(
        gprmax.GeometryObjectsRead(p1=(0, 0, 0), geofile=str(cells), material_database=_DATABASE)
    )
    model.add(gprmax.Waveform(wave_type="ricker", amp=1, freq=antenna.frequency, id="wavelet"))
    middle, half = width // 2 * cell, antenna.separation / 2
    z = rows * cell + antenna.height
    model.add(
        gprmax.HertzianDipole(p1=(0, middle - half, z), polarisation="x", waveform_id="wavelet")
    )
    model.add(gprmax.Rx(p1=(0, middle + half, z)))
    return model


def _write_cells(
    section: Section, scene: Scene, x: float, shape: tuple[int, int], path: Path
) -> None:
    """The part of the section round `x` that gprMax reads, air over it."""
    import h5py

    columns, rows = section.cells.shape
    first = round(x / scene.cell) - shape[0] // 2
    air = len(section.materials)
    cells = np.full((1, *shape), air, np.int16)
    around = np.arange(first, first + shape[0]) % columns
    cells[0, :, :rows] = section.cells[around, ::-1]  # z is up, depth is down
    with h5py.File(path, "w") as file:
        file.attrs["dx_dy_dz"] = (scene.cell,) * 3
        file.attrs["MaterialDatabase"] = _DATABASE
        file.attrs["MaterialDatabaseSchemaVersion"] = 1
        file["data"] = cells
        file["material_keys"] = np.array([f"m{i}".encode() for i in range(air + 1)])


def _write_materials(section: Section, folder: Path) -> None:
    materials = {
        f"m{i}": {
            "name": f"m{i}",
            "model": "constant",
            "base": {
                "relative_permittivity": permittivity,
                "electric_conductivity_s_per_m": conductivity,
                "relative_permeability": 1.0,
                "magnetic_conductivity_s_per_m": 0.0,
            },
        }
        for i, (permittivity, conductivity) in enumerate([*section.materials, (1.0, 0.0)])
    }
    about = {"id": _DATABASE, "name": _DATABASE, "version": "1.0.0", "description": "a scene"}
    content = {
        "schema": "gprMax-material-database",
        "schema_version": 1,
        "database": about,
        "materials": materials,
    }
    (folder / f"{_DATABASE}.json").write_text(json.dumps(content), encoding="utf-8")


def _read_trace(scene: Scene, path: Path) -> Floats:
    """The received field at the radar's samples: low-passed by the spectrum itself, which ends far
    below half the sampling rate, so cubic interpolation of the fine steps is exact enough."""
    import h5py
    from scipy.interpolate import CubicSpline

    with h5py.File(path) as file:
        field = np.asarray(file["rxs/rx1/Ex"][:], np.float64)
        step = float(file.attrs["dt"])
    time = np.arange(scene.samples) * scene.sample_interval
    return np.asarray(CubicSpline(np.arange(len(field)) * step, field)(time))
