"""bench/anchors: its errors on paths made here, its figures, and the part that simulates."""

from dataclasses import replace
from pathlib import Path

import drives
import numpy as np
import pytest
from anchoring import anchors
from jobs import of_anchors
from pair_distance import Case, information

from conftest import run_bench
from gprodom.errors import Error
from gprodom.ground.survey import Survey
from gprodom.odometry.estimate import FixAntenna
from gprodom.random_streams import stream
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


# The benches of two antennas in a row, in short form, and the limit that they measure against.


def test_distance_by_the_pair_alone(shared: Path, programs: Path) -> None:
    words = ["--drives", 1, "--ground", "field", "--case", "centre"]
    (row,) = run_bench("pair_distance.py", shared / "real_ground", *words)
    assert row["passages"] > 100 and row["wrong"] == 0
    assert row["rms_percent"] < 0.5
    assert row["limit_mm"] < row["match_mm"] < 10


def test_faults_of_a_pair(shared: Path, programs: Path) -> None:
    """An antenna that was silent is used again; the rest of the drive is as without the fault.
    Swapped cables are named, and nothing that they say is used."""
    words = ["--km", 0, "--minutes", 1, "--ground", "fdtd"]
    rows = run_bench("pair_faults.py", shared / "real_ground", *words)
    of = {row["fault"]: row for row in rows}
    swapped = [row for row in rows if row["fault"] == "swapped"]
    assert [row["method"] for row in swapped] == ["gprodom", "radar_imu"]
    for row in swapped:
        assert row["passages"] == 0
        assert any(reason.startswith("antennas: swapped") for reason in row["said"])
    assert all(of[name]["wrong"] == 0 for name in ("none", "silent"))
    assert 0 <= of["silent"]["back_after_s"] < 10
    lost = of["none"]["passages"] - of["silent"]["passages"]
    assert 25 <= lost <= 48  # in 10 s the robot drives 4 m, with a passage each 0.1 m at most
    assert of["time zero"]["passages"] > 0.8 * of["none"]["passages"]


def test_front_antenna_that_fails(shared: Path, programs: Path) -> None:
    """The rear one finds what the front one has seen; without, the error is 0.34 of dead
    reckoning."""
    drive = shared / "pairs" / "1760002000-0-gates_g-cmu-gpr.zip"
    (row,) = run_bench("pairs.py", drive, "--only", "front fails")
    assert row["smoothed_m"] < 0.15 * row["dead_m"]


def test_antennas_abreast_find_more_than_one() -> None:
    words = ["--runs", 2, "--laps", 3, "--wander", 0.15, "--abreast", 0.15]
    both, one = (run_bench("map_coverage.py", *words, *more) for more in ([], ["--one"]))
    assert both["revisits_mean"] > 1.2 * one["revisits_mean"] > 0


def test_rebar_at_the_distance_of_the_antennas(shared: Path, programs: Path) -> None:
    words = ["--km", 0.015, "--minutes", 0]
    rows = run_bench("pair_faults.py", shared / "real_ground", *words)
    passages = {(row["fault"], row["method"]): row["passages"] for row in rows}
    assert all(row["wrong"] == 0 for row in rows)
    for method in ("gprodom", "radar_imu"):
        assert passages["pitch", method] > 0.8 * passages["none", method] > 10


def test_limit_is_what_an_ideal_match_reaches() -> None:
    """On ground whose spectrum is white in a band of wave numbers, the best match is the peak of
    the correlation: its variance over draws of noise is the limit."""
    columns, samples, spacing = 320, 40, 0.02
    draw = stream(1, "limit")
    ground = draw.standard_normal((columns, samples))
    number = 2 * np.pi * np.fft.fftfreq(columns, spacing)
    band = (np.abs(number) < 40)[:, None]
    ground = 1000 * np.fft.ifft(band * np.fft.fft(ground, axis=0), axis=0).real
    survey = Survey(
        "made", np.rint(ground)[None].astype(np.int16), spacing, np.zeros(1), 2e-10, 0.0
    )
    case = Case(aside_m=0.0, snr_db=10.0, speed=0.4, rate=0.4 / spacing)
    noise = ground.std() * 10**-0.5
    offsets = []
    for _ in range(300):
        front, rear = (
            band * np.fft.fft(ground + noise * draw.standard_normal(ground.shape), axis=0)
            for _ in range(2)
        )
        cross = np.sum(front * np.conj(rear), axis=1)
        offsets.append(np.sum(number * cross.imag) / np.sum(number**2 * cross.real))
    limit = 1 / np.sqrt(information(survey, case) * columns * spacing)
    assert np.std(offsets) == pytest.approx(limit, rel=0.15)
