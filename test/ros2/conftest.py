"""The tests run in a network namespace of their own, as scripts/check-ros2 starts them."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "scripts"))


@pytest.fixture(autouse=True, scope="session")
def own_network() -> None:
    """Nothing but the loopback, so that nothing reaches a network card."""
    said = subprocess.run(["ip", "-br", "link"], capture_output=True, text=True, check=True).stdout
    if [line.split()[0] for line in said.splitlines()] != ["lo"]:
        pytest.exit("not in a network namespace of its own: run scripts/check-ros2", 2)


def gprodom(*arguments: str | Path) -> None:
    subprocess.run([sys.executable, "-m", "gprodom", *map(str, arguments)], check=True)


@pytest.fixture(scope="session")
def drive(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Holds in.lcmlog, a short simulated drive, config.yaml and out.lcmlog, its replay."""
    folder = tmp_path_factory.mktemp("drive")
    sequence = folder / "1700000000-0-yard-cmu-gpr"
    gprodom("simulate", "--distance", "4", "--standstill", "4", "--seed", "3", "-o", sequence)
    gprodom("convert", "cmu", sequence, "-o", folder / "in.lcmlog")
    # Room for a busy machine, where data time runs faster than the clock: what is computed beside
    # takes effect as late as the settings allow.
    (folder / "config.yaml").write_text(
        "time: {reorder_window: 1.0}\n"
        "smoother: {state_rate: 1, latency: 0.95}\n"
        "gpr: {latency_budget: 2, lever_arm: [0.1, 0.2, -0.3]}\n"
        "graph: {latency: 5}\n"
    )
    config = ["-c", folder / "config.yaml"]
    command = ["gprodom-replay", *config, folder / "in.lcmlog", "-o", folder / "out.lcmlog"]
    subprocess.run([str(part) for part in command], check=True)
    return folder
