"""What the radar sees of motion, by bench/motion.py on one sequence of each scene."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

from conftest import CHECKOUT


def test_motion_of_the_sequences(shared: Path) -> None:
    """Standstill, slip, and coherence no surer than it is; none of it harms the estimate."""
    sequences = sorted((shared / "cmu_like").glob("*.zip"))[2::3]
    assert sequences
    script = str(CHECKOUT / "bench/motion.py")
    result = subprocess.run(
        [sys.executable, script, "--json", *map(str, sequences)], capture_output=True, text=True
    )
    assert result.returncode == 0, result.stderr
    for outcome in json.loads(result.stdout):
        standing = outcome["standing"]
        assert standing["recall"] > 0.95, outcome["sequence"]
        assert standing["false"] < 0.005, outcome["sequence"]
        assert standing["unseen_mm"] < 10, outcome["sequence"]
        assert outcome["prompt"] >= 0.8 * outcome["episodes"], outcome["sequence"]
        assert outcome["false_flags"] <= 0.01 * outcome["metres"] + 1, outcome["sequence"]
        assert outcome["coherence_spans"] > 20, outcome["sequence"]
        assert outcome["coherence_covered"] > 0.9, outcome["sequence"]
        assert outcome["rmse"]["gprodom"] < 1.1 * outcome["rmse"]["imu_wheel"], outcome["sequence"]
