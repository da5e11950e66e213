"""bench/anchors: its errors on paths made here, its figures, and the part that simulates."""

from dataclasses import replace
from pathlib import Path

import drives
import numpy as np
import pytest
from anchoring import anchors
from jobs import of_anchors

from conftest import run_bench
from gprodom.errors import Error
from gprodom.odometry.estimate import FixAntenna
from gprodom.trajectory import Trajectory


def path(scale: float, turn: float) -> Trajectory:
    """100 m along an arc, its lengths times a scale, turned by an angle (rad)."""
    time = np.arange(1001) * 100_000
    angle = np.linspace(0, 1, 1001)
    place = 100 * scale * np.column_stack([np.sin(angle), 1 - np.cos(angle), 0 * angle])
    cos, sin = np.cos(turn), np.sin(turn)
    matrix = np.array([[cos, -sin, 0], [sin, cos, 0], [0, 0, 1.0]])
    return Trajectory(time, place @ matrix.T)


def test_errors_are_placed_by_what_they_say() -> None:
    """Turned paths are equal by se2, but not as they are; of a longer one the ends are as far off
    as the middle is, placed by the middle."""
    truth, turned, longer = path(1.0, 0.0), path(1.0, 0.3), path(1.02, 0.0)
    everywhere = np.ones(1001, bool)
    ends = np.zeros(1001, bool)
    ends[:100] = ends[-100:] = True
    assert drives.error(turned, truth, everywhere, everywhere) < 1e-9
    bare = drives.error(turned, truth, everywhere, None)
    assert bare == pytest.approx(
        np.sqrt(np.mean(np.sum((turned.position - truth.position) ** 2, axis=1)))
    )
    assert drives.error(longer, truth, ends, ends) > drives.error(longer, truth, ~ends, ~ends)
    assert drives.error(longer, truth, ends, ~ends) > drives.error(longer, truth, ends, ends)


def test_the_track_of_an_antenna_is_late_and_at_its_place() -> None:
    straight = np.tile([1.0, 0, 0, 0], (1001, 1))
    body = replace(path(1.0, 0.0), orientation=straight)
    track = FixAntenna(np.array([0.5, -0.2, 1.0]), 0.25).track(body)
    assert np.all(track.time - body.time == 250_000)
    assert np.allclose(track.position - body.position, [0.5, -0.2, 1.0])


def test_every_job_names_its_data_and_rows_become_figures() -> None:
    jobs = of_anchors()
    assert len({job.name for job in jobs}) == len(jobs)
    for job in jobs:
        assert bool(job.data) == ("{data}/robots" in job.arguments)
    row = {"recording": "a", "fault": "jump", "smoothed_m": 1.0, "smoothed_over": 1.1}
    rows = [row | {"named": "fixes: jump", "after_s": 2.0}, row | {"named": "", "fault": "drag_1"}]
    found = {figure.name: figure.value for figure in anchors(rows)}
    assert found["a/jump/smoothed_over"] == 1.1
    assert found["a/jump/after_s"] == 2.0
    assert found["a/named"] == 0.5


def test_the_scale_of_two_fixes(programs: Path) -> None:
    """Two seeds, so that there is a mean; without fixes the scale stays as it was before."""
    one, two, mean, sure = run_bench("anchors", "scale", "--seeds", 2)
    assert (mean["seed"], sure["seed"]) == ("mean", "mean, no slip")
    assert sure["sigma_over_limit"] < 1.2 < mean["sigma_over_limit"]
    for row in (one, two):
        # Two fixes of 2 cm and 5 mm/sqrt(m) of the wheel, over 90 m.
        assert row["limit"] == pytest.approx(np.hypot(0.02 * np.sqrt(2), 0.0474) / 90, rel=0.01)
        assert row["sigma_without"] > 5 * row["limit"]
    assert mean["sigma"] == pytest.approx((one["sigma"] + two["sigma"]) / 2)


def test_data_that_are_not_there_are_named(tmp_path: Path) -> None:
    with pytest.raises(Error, match="wid02 is not measured"):
        drives.ready("wid02", tmp_path, tmp_path)


def test_two_days_of_one_datum_become_one_map(programs: Path) -> None:
    [row] = run_bench("anchors", "days")
    assert row["joined"]
    assert row["error_m"] < 0.3  # of fixes of 3 cm, and a path between them
