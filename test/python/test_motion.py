"""What the radar sees of motion, on one sequence of each scene; bench/motion.py tells of more."""

from __future__ import annotations

from pathlib import Path

from gprodom.benchmark.motion import measure


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
