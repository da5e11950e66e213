"""The types kept of the compiled module are those of the module as it is built."""

import sys
from pathlib import Path

import pytest

from conftest import CHECKOUT, run_program


@pytest.mark.usefixtures("compiled")
def test_types_of_the_compiled_module_are_true(tmp_path: Path) -> None:
    kept, fresh = CHECKOUT / "scripts" / "gprodom" / "_core.pyi", tmp_path / "_core.pyi"
    run_program(CHECKOUT / "scripts" / "stubs", fresh, PYTHON=sys.executable)
    assert fresh.read_text() == kept.read_text(), "run scripts/stubs and look at what has changed"
