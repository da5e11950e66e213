"""scripts/check_rooms.py finds violations, and none in the present package."""

import sys
from pathlib import Path

import pytest

from conftest import CHECKOUT, run_program

CHECK = CHECKOUT / "scripts" / "check_rooms.py"


def check(*package: Path) -> tuple[int, str]:
    """Exit code and what was said."""
    done = run_program(sys.executable, CHECK, *package, codes=(0, 1))
    assert done.stderr == ""
    return done.returncode, done.stdout


@pytest.fixture
def package(tmp_path: Path) -> Path:
    """A package in order: above -> below.deep -> base, an __init__ that offers its modules."""
    root = tmp_path / "house"
    files = {
        "__init__.py": "",
        "above.py": "from house.below import deep\n",
        "base.py": "import sys\n",
        "below/__init__.py": "from house.below.deep import depth\n",
        "below/deep.py": "from ..base import sys\nfrom house.below import flat\ndepth = 1\n",
        "below/flat.py": "",
    }
    for name, text in files.items():
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).write_text(text)
    return root


def test_a_package_in_order_passes(package: Path) -> None:
    assert check(package) == (0, "folders and imports are as wanted\n")


@pytest.mark.parametrize(
    "text",
    [
        "import house.above\n",
        "from house import above\n",
        "from house.above import anything\n",
        "from . import above\n",
        "def later():\n    from .above import anything\n",
        'COMMANDS = ("house.above",)\n',
    ],
)
def test_a_cycle_is_found_however_it_is_written(package: Path, text: str) -> None:
    (package / "base.py").write_text(text)
    code, said = check(package)
    assert (code, said) == (1, f"{package}: imports go round: above -> below -> base -> above\n")


def test_a_cycle_inside_a_subpackage_is_found(package: Path) -> None:
    (package / "below" / "flat.py").write_text("from house.below.deep import depth\n")
    code, said = check(package)
    assert code == 1
    assert said == f"{package / 'below'}: imports go round: deep -> flat -> deep\n"


def test_a_full_folder_and_a_long_source_are_found(package: Path) -> None:
    for number in range(18):
        (package / "below" / f"room_{number}.py").write_text("")
    assert "21 modules, at most 20" in check(package)[1]
    (package / "below" / "room_0.py").unlink()
    (package / "base.py").write_text("\n" * 400)
    assert check(package)[0] == 0
    (package / "base.py").write_text("\n" * 401)
    assert check(package) == (1, f"{package / 'base.py'}: 401 lines, at most 400 are wanted\n")


def test_a_module_is_imported_without_the_extension() -> None:
    """Commands that need no estimator start without its libraries."""
    code = "import sys; from gprodom import canvas, rotation; from gprodom.cli import build_parser"
    code += "; build_parser(); print('gprodom._core' in sys.modules)"
    assert run_program(sys.executable, "-c", code).stdout == "False\n"
