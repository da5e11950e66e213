"""The benches of two antennas in a row, in short form, and the limit that they measure against."""

from pathlib import Path

import numpy as np
import pytest
from pair_distance import Case, information

from conftest import run_bench
from gprodom.ground.survey import Survey
from gprodom.random_streams import stream


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
