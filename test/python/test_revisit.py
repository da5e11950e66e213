"""Revisits on real ground: parallel survey lines 20 cm apart, patches in both directions."""

from pathlib import Path

import numpy as np
import pytest

gpr = pytest.importorskip("gprodom.gpr")

WINDOW = 100  # traces, 1.8 m


@pytest.fixture(scope="module")
def lines(shared: Path) -> list[tuple[np.ndarray, float, float]]:
    """Traces (columns, samples), spacing (m) and sample interval (s) of some parallel lines."""
    folder = shared / "real_ground" / "seal_beach"
    if not folder.is_dir():
        pytest.skip(f"no real ground in {folder}")
    loaded = [np.load(folder / f"line_{n:02d}.npz") for n in (7, 8, 14)]
    return [
        (z["traces"].astype(np.float32), float(z["spacing"]), float(z["sample_interval"]))
        for z in loaded
    ]


def test_a_line_beside_is_found_in_both_directions(lines):
    memory, spacing, interval = lines[0]
    beside = lines[1][0]
    errors, rejected = [], 0
    for start in range(60, len(memory) - WINDOW - 60, 50):
        true = (start + WINDOW / 2) * spacing
        for mirrored in (False, True):
            query = beside[start : start + WINDOW]
            if mirrored:
                query = query[::-1]
            position, found_mirrored, score = gpr.match_patch(
                memory, query, spacing, interval, true + 0.25, 0.6
            )
            if score < gpr.RevisitOptions().min_score:
                rejected += 1
                continue
            assert found_mirrored == mirrored
            errors.append(position - true)
    assert rejected <= 0.2 * (rejected + len(errors))
    assert np.abs(np.array(errors) - np.median(errors)).max() < 0.10


def test_a_line_far_off_is_rejected(lines):
    memory, spacing, interval = lines[0]
    far = lines[2][0]
    for start in range(0, 700, 50):
        prior = (start + WINDOW / 2) * spacing
        match = gpr.find_patch(memory, far[start : start + WINDOW], spacing, interval, prior, 0.6)
        assert not match.accepted


def test_features_need_the_traces_they_were_learnt_for(lines):
    memory, spacing, interval = lines[0]
    with pytest.raises(ValueError, match="same number of samples"):
        gpr.match_patch(memory, memory[:50, :100], spacing, interval, 5.0, 0.6)
