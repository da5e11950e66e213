"""Apexes of pipes on full-wave lines, and places along a track by a map of pipes."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from salient import apexes, basement_pipes

from conftest import run_cli
from gprodom.errors import Error
from gprodom.ground.pipes import PipeMap, read_pipes
from gprodom.ground.survey import find_survey
from gprodom.lcm.answers import Answer
from gprodom.lcm.constants import kind
from gprodom.odometry.pipes import APEX_M, DRIFT, LENGTH, PipeTeller


def test_apexes_on_full_wave_lines() -> None:
    """Place within 2 cm and depth within 5 % in three strengths of clutter; elsewhere but a stone
    now and then."""
    rows = apexes()
    metal = [row for row in rows if row["pipe"] == "metal"]
    assert [row["clutter"] for row in metal] == ["weak", "medium", "strong"]
    for row in metal:
        assert row["found"] == 1, row
        assert abs(row["off_m"]) < 0.02, row
        assert abs(row["depth_error"]) < 0.05, row
    assert all(row["others_per_m"] < 1 for row in rows)


def drive(laps: float, pipes: PipeMap, ground: str = "basement") -> list[tuple[Answer, float]]:
    """Answers on a straight drive at 0.5 m/s from 3.7 m on, and the true distance of each. The
    odometry reads 2 % too much."""
    survey = find_survey(ground)
    teller = PipeTeller(pipes)
    answers = []
    steps = round(laps * survey.length / 0.025)
    place = 3.7 + 0.025 * np.arange(steps)
    traces = survey.traces(place, np.zeros(steps))
    for i in range(steps):
        utime = 1_000_000_000 + 50_000 * i
        answers += teller.trace(utime, traces[i], survey.sample_interval)
        answers += teller.pose(utime, 1.02 * (place[i] - place[0]), 0.0, 0.0)
    return [(each, 0.5e-6 * (each.utime_to - each.utime_from)) for each in answers]


def test_a_map_of_pipes_tells_displacements(tmp_path: Path) -> None:
    """Right within 3 sigma but for one in twenty, pipes seen again included, and no drift."""
    pipes = read_pipes(basement_pipes(tmp_path))
    told = drive(5.0, pipes)
    assert len(told) > 20
    off = np.array([pipes.apart(np.array(a.distance - true)) / a.sigma for a, true in told])
    assert np.mean(np.abs(off) < 3) > 0.95, off
    assert {a.kind for a, _ in told} == {kind("EXTERNAL"), kind("REVISIT")}


def test_how_well_pipes_are_mapped_is_learnt_from_the_drive(tmp_path: Path) -> None:
    """A map that is off by 8 cm, this way and that, is trusted less than odometry in an image, one
    that is right more."""
    right = read_pipes(basement_pipes(tmp_path))
    wrong = replace(right, x=right.x + 0.08 * (-1.0) ** np.arange(len(right.x)))
    first, last = (drive(5.0, pipes)[-1][0].sigma / np.sqrt(2) for pipes in (right, wrong))
    assert APEX_M <= first < DRIFT * LENGTH < last


def test_ground_without_those_pipes_is_not_located(tmp_path: Path) -> None:
    """The garage is not the basement."""
    assert drive(5.0, read_pipes(basement_pipes(tmp_path)), "garage") == []


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "expected keys and their values"),
        ("pipes: {}", "pipes: expected a list"),
        ("pipes: [{x: 1}]", "pipes[0]: depth is missing"),
        ("pipes: [{x: 1, depth: deep}]", "pipes[0]: depth: 'deep': expected a number"),
        ("pipes: [{x: 1, depth: -0.3}]", "depth above 0"),
        ("pipes: [{x: 1, depth: .3}]\nspeed: 1", "speed: unknown key"),
    ],
)
def test_what_is_wrong_with_a_map_is_said(tmp_path: Path, text: str, said: str) -> None:
    """With file and key."""
    path = tmp_path / "pipes.yaml"
    path.write_text(text)
    with pytest.raises(Error) as error:
        read_pipes(path)
    assert str(path) in str(error.value) and said in str(error.value)


def test_rays_show_the_pipes_they_are_given(tmp_path: Path) -> None:
    """gprodom simulate --pipes; other ground refuses it."""
    path = tmp_path / "pipes.yaml"
    path.write_text("pipes: [{x: 2.0, depth: 0.4}]")
    out = tmp_path / "1700000000-0-yard-cmu-gpr"
    command = ["simulate", "--distance", "6", "--pipes", str(path), "-o", str(out)]
    run_cli(*command)
    run_cli(*command, "--ground", "garage", code=2)
