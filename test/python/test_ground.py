"""FDTD ground: scenes, physics, the lines that come with the package."""

from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest

from conftest import CHECKOUT, run_bench
from gprodom.errors import Error
from gprodom.ground.materials import sections
from gprodom.ground.scene import Layer, Pipe, Scene, read_scene
from gprodom.ground.survey import SHIPPED, Survey, find_survey, read_survey, shipped, write_survey

SCENES = sorted((CHECKOUT / "config" / "scenes").glob("*.yaml"))


def test_fdtd_obeys_physics() -> None:
    if find_spec("gprMax") is None:
        pytest.skip("gprMax is not installed (the extra fdtd)")
    run_bench("fdtd_physics.py")


@pytest.mark.parametrize("path", SCENES, ids=lambda path: path.stem)
def test_scenes_repeat_and_their_lines_belong_together(path: Path) -> None:
    first, second = sections(read_scene(path), 1.0)
    eps = [np.array(s.materials)[:, 0][s.cells] for s in (first, second)]
    assert np.corrcoef(eps[0].ravel(), eps[1].ravel())[0, 1] > 0.6

    eps = [e - e.mean(axis=0) for e in eps]
    near = np.sum(eps[0] * eps[1]) / np.sqrt(np.sum(eps[0] ** 2) * np.sum(eps[1] ** 2))
    assert 0.3 < near < 0.98
    # The seam is no edge: neighbours across it are as alike as anywhere.
    steps = np.abs(np.diff(eps[0], axis=0, append=eps[0][:1])).mean(axis=1)
    assert steps[-1] < 4 * np.median(steps)


def test_pipe_is_where_it_is_said() -> None:
    layer = Layer("even", 5.0, 0.0)
    pipe = Pipe(x=1.0, depth=0.3, radius=0.05, permittivity=1.0, skew=0.5)
    scene = Scene("one", (layer,), pipes=(pipe,), length=3.0, aside=(0.0, 0.2))
    for section, shift in zip(sections(scene, 0.6), (0.0, 0.2 * np.tan(0.5)), strict=True):
        inside = np.array(section.materials)[section.cells][..., 0] < 2
        along, deep = np.nonzero(inside)
        assert (along.mean() + 0.5) * scene.cell == pytest.approx(1.0 + shift, abs=0.005)
        assert (deep.mean() + 0.5) * scene.cell == pytest.approx(0.3, abs=0.003)
        assert inside.sum() * scene.cell**2 == pytest.approx(np.pi * 0.05**2, rel=0.05)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("layers: [{name: a, permittivity: 4}]", "conductivity is missing"),
        ("layers: [{name: a, permittivity: wet, conductivity: 0}]", "expected a number"),
        ("layers: [{name: a, permittivity: 4, conductivity: 0, colour: 1}]", "unknown key"),
        ("layers: []", "at least one"),
        ("{layers: [{name: a, permittivity: 4, conductivity: 0}], length: 1.005}", "whole number"),
    ],
)
def test_scene_errors_name_the_key(tmp_path: Path, text: str, said: str) -> None:
    path = tmp_path / "scene.yaml"
    path.write_text(text)
    with pytest.raises(Error, match=said):
        read_scene(path)


def survey() -> Survey:
    """Two lines of waves that are band-limited along the line."""
    x = np.arange(200) * 0.02
    waves = 8000 * np.sin(2 * np.pi * (x[:, None] / 0.1 + np.arange(50) / 17))
    lines = np.stack([waves, 0.5 * waves]).astype(np.int16)
    return Survey("waves", lines, 0.02, np.array([0.0, 0.05]), 2e-10, 1e-9)


def test_survey_between_traces_and_lines() -> None:
    lines = survey()
    along = np.array([0.0, 0.33, 1.007, 3.999, 4.0 + 0.33])
    seen = lines.traces(along, np.full(5, 0.0125))
    expected = 7000 * np.sin(2 * np.pi * (along[:, None] / 0.1 + np.arange(50) / 17))
    np.testing.assert_allclose(seen, expected, atol=25)
    outside = lines.traces(along, np.full(5, 0.2))
    np.testing.assert_allclose(outside, expected * 4 / 7, atol=25)


def test_survey_file_keeps_every_count(tmp_path: Path) -> None:
    lines = survey()
    hard = np.random.default_rng(1).integers(-(2**15), 2**15, lines.lines.shape).astype(np.int16)
    lines = replace(lines, lines=hard)
    write_survey(tmp_path / "waves.npz", lines)
    again = read_survey(tmp_path / "waves.npz")
    np.testing.assert_array_equal(again.lines, hard)
    assert (again.spacing, again.sample_interval, again.length) == (0.02, 2e-10, 4.0)


def test_shipped_lines() -> None:
    assert set(shipped()) == {path.stem for path in SCENES}
    assert sum(path.stat().st_size for path in SHIPPED.glob("*.npz")) < 6e6
    for path in SCENES:
        scene, lines = read_scene(path), find_survey(path.stem)
        assert lines.lines.shape == (len(scene.aside), scene.traces, scene.samples)
        traces = lines.lines - lines.lines.mean(axis=1, keepdims=True)
        a, b = (part[:, 60:].ravel() for part in traces)
        # Some centimetres aside the ground is alike, but not the same.
        assert 0.3 < a @ b / np.sqrt((a @ a) * (b @ b)) < 0.97


def test_unknown_ground(tmp_path: Path) -> None:
    with pytest.raises(Error, match="basement"):
        find_survey(str(tmp_path / "nothing.npz"))
