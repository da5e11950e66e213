"""What `import gprodom` shows to somebody who explores it: names, texts of objects, its page."""

from __future__ import annotations

import sys
from typing import Any

import numpy as np
import pytest

import gprodom
from conftest import CHECKOUT, run_program

pytestmark = pytest.mark.usefixtures("compiled")


def standing(seconds: int = 4) -> dict[str, Any]:
    """A robot that stands, IMU at 100 Hz and wheel at 10 Hz."""
    random = np.random.default_rng(1)
    start, n = 1_700_000_000_000_000_000, 100 * seconds
    return {
        "imu_time": start + np.arange(n) * 10_000_000,
        "acceleration": random.normal([0, 0, 9.81], 0.01, (n, 3)),
        "angular_velocity": random.normal(0, 0.001, (n, 3)),
        "wheel_time": start + np.arange(n // 10) * 100_000_000,
        "wheel_distance": np.zeros(n // 10),
        "gpr_time": np.empty(0, int),
        "traces": np.empty((0, 64)),
    }


def test_completion_offers_what_is_loaded_when_asked_for() -> None:
    code = "import gprodom; print(*dir(gprodom)); print(*dir(gprodom.gpr)); gprodom.Odometry"
    done = run_program(sys.executable, "-c", code)
    names, radar = (set(line.split()) for line in done.stdout.splitlines())
    assert {"Odometry", "Outputs", "ConfigError", "describe_config", "gpr", "__version__"} <= names
    assert "DetailsRetention" in radar


def test_outputs_say_what_they_hold() -> None:
    odometry = gprodom.Odometry(set=["gpr.enabled=false"])
    assert repr(odometry.step()) == (
        "<gprodom.Outputs: 0 odometry, 0 corrections, 0 displacements, 0 status, 0 warnings>"
    )
    outputs = odometry.run(**standing())
    time = outputs.odometry["time"]
    first, last = (f"{time[i] / 1e9:.3f}" for i in (0, -1))
    assert repr(outputs).startswith(
        f"<gprodom.Outputs: {len(time)} odometry from {first} to {last} s, "
        f"0 corrections, 0 displacements, {len(outputs.status)} status, "
    )


def test_one_override_needs_no_list() -> None:
    once, listed = (
        gprodom.describe_config(set=setting)
        for setting in ("wheel.scale=0.97", ["wheel.scale=0.97"])
    )
    assert once == listed != gprodom.describe_config()
    with pytest.raises(gprodom.ConfigError, match="--set a=b: unknown key"):
        gprodom.Odometry(set="a=b")


def test_the_page_tells_of_every_member() -> None:
    page = (CHECKOUT / "docs" / "python.md").read_text()
    tutorial = (CHECKOUT / "docs" / "tutorial.md").read_text()
    for name in (name for name in dir(gprodom.Outputs) if not name.startswith("_")):
        assert f"\n| `{name}` |" in page, f"docs/python.md does not tell of Outputs.{name}"
    for name in (name for name in dir(gprodom.Odometry) if not name.startswith("_")):
        assert f"`{name}(" in page, f"docs/python.md does not tell of Odometry.{name}()"
    # What one is to plot has the corrections.
    assert 'outputs.odometry_map["position"]' in tutorial and "outputs.corrections" in tutorial
