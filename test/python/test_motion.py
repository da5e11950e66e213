"""Standstill and coherence on one sequence of each scene; bench/motion.py runs more."""

from pathlib import Path

import numpy as np

from conftest import Cli
from gprodom.benchmark.motion import measure
from gprodom.ground.survey import Survey, write_survey


def test_motion_of_the_sequences(shared: Path, tmp_path: Path) -> None:
    """Standstill, slip, and coherence no surer than it is; none of it harms the estimate."""
    sequences = sorted((shared / "cmu_like").glob("*.zip"))[2::3]
    assert sequences
    outcomes = [measure(sequence, [], tmp_path) for sequence in sequences]
    prompt = sum(outcome.prompt for outcome in outcomes)
    assert prompt >= 0.9 * sum(outcome.episodes for outcome in outcomes)
    for outcome in outcomes:
        standing, name = outcome.standing, outcome.sequence
        assert standing.recall > 0.95, name
        assert standing.false < 0.005, name
        assert standing.unseen_mm < 10, name
        assert outcome.false_flags <= 0.01 * outcome.metres + 1, name
        assert outcome.coherence_spans > 20, name
        assert outcome.coherence_covered > 0.9, name
        assert outcome.rmse["gprodom"] < 1.1 * outcome.rmse["imu_wheel"], name


def coarse_ground(path: Path) -> None:
    """Traces 0.6 m apart by a radar of 50 MHz, its echoes weak and without anything in common."""
    interval, samples = 8e-10, 300
    time = np.arange(samples) * interval

    def wavelet(at: float) -> np.ndarray:
        a = (np.pi * 50e6 * (time - at)) ** 2
        return (1 - 2 * a) * np.exp(-a)

    strength = 100 * np.exp(-time / 60e-9) * (time > 40e-9)
    reflections = np.random.default_rng(1).normal(0, strength, (100, samples))
    echoes = reflections @ np.array([wavelet(at) for at in time])
    counts = np.rint(30000 * wavelet(30e-9) + echoes).astype(np.int16)
    write_survey(
        path, Survey("coarse", counts[None], 0.6, np.zeros(1), interval, 30e-9, closed=False)
    )


def test_ground_that_shows_no_slow_motion(tmp_path: Path, cli: Cli) -> None:
    """It is no witness against the wheel: no worse than without a radar, and told."""
    coarse_ground(tmp_path / "coarse.npz")
    drive = tmp_path / "1700000001-0-coarse-cmu-gpr.zip"
    made = ["--ground", str(tmp_path / "coarse.npz"), "--distance", "60", "--seed", "1"]
    cli("simulate", *made, "-o", drive)
    error = {}
    for method in ("imu_wheel", "gprodom"):
        path = tmp_path / f"{method}.tum"
        said = cli("run", drive, "--method", method, "--tum", path).err
        assert ("the radar cannot detect slow motion" in said) is (method == "gprodom")
        error[method] = cli.json("score", path, drive)["ate_rmse_m"]
    assert error["gprodom"] < 1.1 * error["imu_wheel"] + 0.01
