"""What `import gprodom` shows to somebody who explores it: names, texts of objects, its page."""

import sys
from pathlib import Path

import pytest

import gprodom
from conftest import CHECKOUT, SAMPLE, run_program
from gprodom.convert.cmu import read_recording

pytestmark = pytest.mark.usefixtures("compiled")


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
    recording = read_recording(SAMPLE)
    outputs = odometry.run(**recording.messages(until=int(recording.imu_utime[0]) + 4_000_000))
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


# The types kept of the compiled module are those of the module as it is built.


@pytest.mark.usefixtures("compiled")
def test_types_of_the_compiled_module_are_true(tmp_path: Path) -> None:
    kept, fresh = CHECKOUT / "scripts" / "gprodom" / "_core.pyi", tmp_path / "_core.pyi"
    run_program(CHECKOUT / "scripts" / "stubs", fresh, PYTHON=sys.executable)
    assert fresh.read_text() == kept.read_text(), "run scripts/stubs and look at what has changed"
