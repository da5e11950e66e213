"""The estimator's covariance over 40 simulated drives; bench/consistency.py runs more."""

from __future__ import annotations

import json
import subprocess
import sys

import pytest

from conftest import CHECKOUT


@pytest.mark.usefixtures("compiled")
def test_covariance_is_true() -> None:
    result = subprocess.run(
        [sys.executable, str(CHECKOUT / "bench" / "consistency.py"), "--runs", "40", "--json"],
        capture_output=True,
        text=True,
    )
    assert result.stdout, result.stderr
    summary = json.loads(result.stdout)
    for figure in ("nees_xy", "nees_yaw"):
        assert summary[figure]["inside"], {**summary[figure], "errors": summary["rms_error"]}
    assert summary["runs"] == 40
