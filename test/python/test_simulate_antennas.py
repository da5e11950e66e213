"""Several simulated antennas on one robot, and ground that differs beside the track."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from conftest import run_cli
from gprodom.ground.survey import LATERAL, Survey, find_survey
from gprodom.lcm.logs import read
from gprodom.simulate import Spec, make_route, simulate, stream
from gprodom.simulate.antennas import AntennaSpec, draw_antennas, receive
from gprodom.simulate.ground import GroundSpec
from gprodom.simulate.radar import RadarSpec
from gprodom.simulate.sequence import SurveySpec

QUIET = RadarSpec(noise=0.0)


def alike(a: np.ndarray, b: np.ndarray) -> float:
    a, b = a - a.mean(axis=0), b - b.mean(axis=0)
    return float(np.sum(a * b) / np.sqrt(np.sum(a**2) * np.sum(b**2)))


@pytest.mark.parametrize("ground", ["rays", "basement"])
def test_two_antennas_are_written_and_converted(ground: str, tmp_path: Path) -> None:
    path = tmp_path / "1700000000-0-two-cmu-gpr.zip"
    words = ["simulate", "--seed=3", "--distance=2", "--standstill=1", f"--ground={ground}"]
    words += ["--antenna=0.15,0", "--antenna=-0.15,0.1", "-o", str(path)]
    run_cli(*words)
    run_cli("convert", "cmu", path, "-o", tmp_path / "two.lcmlog")
    gpr = read(tmp_path / "two.lcmlog")["GPR_TRACE"]
    times = [gpr["utime"][gpr["antenna_id"] == i] for i in (0, 1)]
    count = min(map(len, times))
    assert count > 100
    assert set(times[1][:count] - times[0][:count]) == {4000}
    facts = json.loads(path.with_suffix(".json").read_text())
    assert facts["antennas"] == [[0.15, 0, 0], [-0.15, 0.1, 0]]
    off = np.subtract(facts["antennas_true"], facts["antennas"])
    assert np.all(off[0] == 0)
    assert 0 < np.abs(off[1]).max() < 0.02


def test_with_one_antenna_nothing_is_said_of_several(tmp_path: Path) -> None:
    path = tmp_path / "one.zip"
    words = ["--distance=1", "--standstill=0", "--ground=none", "--antenna=0.1,0"]
    run_cli("simulate", *words, "-o", path)
    facts = json.loads(path.with_suffix(".json").read_text())
    assert not [key for key in (*facts, *facts["spec"]) if key.startswith("antennas")]
    assert facts["spec"]["radar"]["lever_arm"] == [0.1, 0.0]


@pytest.mark.parametrize("ground", [GroundSpec(), SurveySpec("basement")])
def test_the_rear_antenna_sees_what_the_front_one_saw(ground: GroundSpec | SurveySpec) -> None:
    drive = replace(make_route("line", 8.0, 0.4, 0.0, stream(1, "route")), lateral_noise=0.0)
    arms = ((0.15, 0.0), (-0.15, 0.0), (-0.15, 0.06))
    antennas = tuple(AntennaSpec(replace(QUIET, lever_arm=arm), arm) for arm in arms)
    data = simulate(Spec(drive, radar=QUIET, antennas=antennas, ground=ground), 1)
    s = data.motion_at(data.gpr_utime).s
    forwards = slice(0, int(np.argmax(s)))
    places = np.arange(0.4, s.max() - 0.4, 0.02)
    seen = []
    received = (data.traces, *(a.counts for a in data.more_antennas.values()))
    for traces, arm in zip(received, arms, strict=True):
        at = np.searchsorted(s[forwards] + arm[0], places)
        seen.append(traces[forwards][at].astype(float))
    assert alike(seen[0], seen[1]) > 0.95  # traces are 2 cm apart, so the places agree to 1 cm
    assert alike(seen[0], seen[2]) < alike(seen[0], seen[1]) - 0.03


@pytest.mark.parametrize("name", ["garage", "basement", "floor"])
def test_ground_beside_the_track_differs_as_real_ground(name: str) -> None:
    survey = find_survey(name).decorrelating()
    along = np.arange(0.0, survey.length, 0.02)

    def seen(beside: float) -> np.ndarray:
        return survey.turned_traces(along, np.full_like(along, beside))

    first = find_survey(name).traces(along, np.zeros_like(along))
    np.testing.assert_allclose(seen(0.0), first, atol=1.0)
    for begin in (-0.02, 0.0, 0.03):  # the same anywhere, beside the lines too
        here = seen(begin)
        assert np.std(here - here.mean(axis=0)) == pytest.approx(
            np.std(first - first.mean(axis=0)), rel=1e-3
        )
        for off in (0.01, 0.03, 0.06):
            assert alike(here, seen(begin + off)) == pytest.approx(np.cos(off / LATERAL), abs=2e-3)


def test_ground_of_a_single_line_differs_beside_it_too() -> None:
    lines = stream(1, "line").randint(-3000, 3000, (1, 200, 50)).astype(np.int16)
    survey = Survey("made", lines, 0.02, np.zeros(1), 2e-10, 0.0).decorrelating()
    along = np.arange(0, 4, 0.02)
    seen = [survey.turned_traces(along, np.full_like(along, at)) for at in (0.0, 0.02)]
    assert alike(*seen) == pytest.approx(np.cos(0.02 / LATERAL), abs=2e-3)


def test_faults_of_an_antenna() -> None:
    """A tone comes louder, later and with its phase turned, and the drift of time zero adds."""
    interval, frequency, n = 2e-10, 5e8, 200
    t = np.arange(n) * interval
    pulse = np.exp(-(((t - 2e-8) / 4e-9) ** 2))
    clean = np.tile(5000 * pulse * np.cos(2 * np.pi * frequency * t), (3, 1))
    time, still = np.array([0.0, 300.0, 600.0]), np.zeros(3)
    spec = AntennaSpec(
        QUIET, (0, 0), gain=1.5, time_zero=4e-10, time_zero_rate=1e-9 / 600, phase=0.3
    )
    seen = receive(clean, time, still, interval, spec, stream(1, "x"))
    for row, at in zip(seen, time, strict=True):
        late = 4e-10 + 1e-9 * at / 600
        envelope = np.exp(-(((t - late - 2e-8) / 4e-9) ** 2))
        expected = 7500 * envelope * np.cos(2 * np.pi * frequency * (t - late) + 0.3)
        assert np.abs(row - expected).max() < 75
    driven = np.linspace(0, 50, 500)
    bounced = receive(
        np.tile(clean[:1], (500, 1)), driven, driven, interval,
        replace(spec, gain=1.0, bounce=0.004), stream(1, "x"),
    )  # fmt: skip
    assert 0.001 < np.std(np.abs(bounced).max(axis=1)) / 5000 < 0.05


def test_antennas_do_not_bounce_alike() -> None:
    """At no distance along the track, or it would pass for ground between them."""
    driven = np.arange(0, 60, 0.02)
    clean = np.tile(10_000 * np.hanning(100), (len(driven), 1))
    heights = []
    for name in ("front", "rear"):
        spec = AntennaSpec(QUIET, (0, 0), bounce=0.01)
        seen = receive(clean, driven, driven, 2e-10, spec, stream(1, name)).max(axis=1)
        heights.append((seen - seen.mean()) / seen.std())
    alike_at = [np.mean(heights[0][lag:] * heights[1][: len(driven) - lag]) for lag in range(100)]
    assert np.abs(alike_at).max() < 0.4


def test_antennas_are_drawn_with_faults_of_their_own() -> None:
    first, second = draw_antennas([(0.2, 0), (-0.2, 0)], RadarSpec(ringing=10.0), stream(1, "a"))
    assert first.radar.lever_arm == first.told == (0.2, 0)
    assert second.radar.lever_arm != second.told
    for name in ("gain", "time_zero", "phase", "bounce"):
        assert getattr(first, name) != getattr(second, name)
    assert first.radar.noise != second.radar.noise
