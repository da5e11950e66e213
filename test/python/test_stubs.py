"""The types kept of the compiled module are those of the module as it is built."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from conftest import CHECKOUT


@pytest.mark.usefixtures("compiled")
def test_types_of_the_compiled_module_are_true(tmp_path: Path) -> None:
    kept, fresh = CHECKOUT / "scripts" / "gprodom" / "_core.pyi", tmp_path / "_core.pyi"
    done = subprocess.run(
        [CHECKOUT / "scripts" / "stubs", fresh],
        env={**os.environ, "PYTHON": sys.executable},
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    assert fresh.read_text() == kept.read_text(), "run scripts/stubs and look at what has changed"
