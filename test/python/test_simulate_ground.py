"""The simulator's ground: scatterers and layers, changed permittivity, survey lines."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from gprodom.ground.survey import Survey, write_survey
from gprodom.simulate import Spec, make_route, simulate, stream
from gprodom.simulate.ground import Ground, GroundSpec
from gprodom.simulate.radar import RadarSpec
from gprodom.simulate.sequence import SurveySpec


def test_same_place_same_trace() -> None:
    x, y = np.linspace(0, 5, 251), np.linspace(0, 0.2, 251)
    ground = Ground(GroundSpec(), x, y, stream(1, "ground"))
    traces = ground.traces(x, y)
    np.testing.assert_array_equal(ground.traces(x[::-1], y[::-1])[::-1], traces)
    traces = traces - traces.mean(axis=0)
    far = traces[:-100].ravel() @ traces[100:].ravel()
    near = traces[:-1].ravel() @ traces[1:].ravel()
    here = traces.ravel() @ traces.ravel()
    assert 0.9 < near / here < 0.999  # 2 cm aside is seen, and alike
    assert abs(far / here) < 0.3


def test_changed_permittivity_delays_the_echoes() -> None:
    x = np.linspace(0, 5, 251)

    def seen(*permittivity: float) -> np.ndarray:
        spec = GroundSpec(permittivity=permittivity)
        return Ground(spec, x, np.zeros_like(x), stream(1, "ground")).traces(x, np.zeros_like(x))

    as_it_was = seen()
    np.testing.assert_allclose(seen(0.0, 0.0), as_it_was, atol=1.0)
    spec = GroundSpec()
    begin = round(spec.surface_time / spec.sample_interval)
    late = begin + (np.arange(30, 150) - begin) * 1.1  # 21 % more: slower by a tenth
    samples = np.arange(spec.samples)
    slower = np.array([np.interp(late, samples, trace) for trace in seen(0.21, 0.21)])
    slower, before = (a - a.mean(axis=0) for a in (slower, as_it_was[:, 30:150]))
    alike = np.sum(slower * before) / np.sqrt(np.sum(slower**2) * np.sum(before**2))
    assert alike > 0.9
    # Only below the first half metre: what is above arrives as it did.
    deep = seen(0.0, 0.0, 0.2, 0.2)
    shallow = slice(begin, begin + round(2 * 0.4 / spec.wave_speed / spec.sample_interval))
    np.testing.assert_allclose(deep[:, shallow], as_it_was[:, shallow], atol=300.0)
    assert np.abs(deep[:, 120:] - as_it_was[:, 120:]).max() > 300.0


def test_ground_of_a_survey_is_seen_again(tmp_path: Path) -> None:
    """The same place gives the same trace forwards, backwards and a lap later."""
    x = np.arange(500) / 500
    lines = 5000 * np.sin(2 * np.pi * (x[:, None] * 30 + np.arange(120) / 13))
    survey = Survey("made", lines.astype(np.int16)[None], 0.02, np.zeros(1), 2e-10, 1e-9)
    write_survey(tmp_path / "made.npz", survey)
    drive = make_route("loop", 30.0, 0.6, 1.0, stream(1, "route"), survey.length)
    ground = SurveySpec(str(tmp_path / "made.npz"), middle=0.0)
    clean = RadarSpec(noise=0.0)
    data = simulate(Spec(replace(drive, lateral_noise=0), radar=clean, ground=ground), 1)
    s = data.motion_at(data.gpr_utime).s
    expected = 5000 * np.sin(2 * np.pi * (s[:, None] / 10 * 30 + np.arange(120) / 13))
    assert s.max() > 20
    assert np.abs(data.traces - expected).max() < 0.02 * 5000
