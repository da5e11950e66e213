"""gprodomd from outside: its command line, and live in a network namespace."""

import os
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

import pytest

from conftest import CHECKOUT, CONFIG, UNPRIVILEGED, run_isolated
from gprodom.odometry.replay import find_program

SCENARIOS = CHECKOUT / "test" / "python" / "daemon_scenario.py"


def gprodomd(*words: object) -> subprocess.CompletedProcess[str]:
    command = [find_program("gprodomd"), *words]
    return subprocess.run([*map(str, command)], capture_output=True, text=True, timeout=20)


def test_check_config(tmp_path: Path) -> None:
    for profile in sorted((CHECKOUT / "config").glob("*.yaml")):
        result = gprodomd("-c", profile, "--check-config")
        assert (result.returncode, result.stdout) == (0, f"{profile}: ok\n"), result.stderr
    bad = tmp_path / "bad.yaml"
    bad.write_text("wheel:\n  scale: fast\n")
    result = gprodomd("-c", bad, "--check-config")
    assert result.returncode == 1
    assert result.stderr == (
        f'gprodomd: {bad}:2: wheel.scale: expected a number from 0.1 to 10, got "fast"\n'
    )


def test_check_config_builds_the_estimator() -> None:
    result = gprodomd("-c", CONFIG, "--set", "smoother.latency=0.2", "--check-config")
    assert result.returncode == 1 and "ok" not in result.stdout
    assert "smoother.latency: expected less than one state interval" in result.stderr


OLD = CHECKOUT / "test" / "package" / "gprodom-0.1.yaml"  # the conffile of 0.1, with every key


def test_an_edited_file_of_the_version_before_does_not_stop_the_daemon(tmp_path: Path) -> None:
    config = tmp_path / "gprodom.yaml"
    config.write_text(OLD.read_text().replace("max_speed: 5 ", "max_speed: 4.5 "))
    checked = gprodomd("-c", config, "--check-config")
    assert checked.returncode == 0, checked.stderr
    assert f"{config}: ok\n" in checked.stdout
    assert "no longer settings" in checked.stdout
    printed = gprodomd("-c", config, "--print-config").stdout
    kept = CONFIG.read_text().replace("max_speed: 0  ", "max_speed: 4.5")
    kept = kept.replace("robust_threshold: 5  ", "robust_threshold: 1.5")
    assert printed == kept.replace("solver: chain", "solver: ceres")


def test_a_removed_key_at_another_value_says_what_became_of_it(tmp_path: Path) -> None:
    config, old = tmp_path / "gprodom.yaml", OLD.read_text()
    config.write_text(old.replace("slip_lasts: 20 ", "slip_lasts: 30 "))
    line = 1 + old[: old.index("slip_lasts")].count("\n")
    checked = gprodomd("-c", config, "--check-config")
    assert checked.returncode == 1
    said = "wheel.slip_lasts: no longer a setting: it is fixed at 20"
    assert f"{config}:{line}: {said}" in checked.stderr


def test_the_file_for_a_robot_is_at_the_defaults() -> None:
    robot = CHECKOUT / "config" / "robot.yaml"
    assert gprodomd("-c", robot, "--print-config").stdout == CONFIG.read_text()
    assert "no longer" not in gprodomd("-c", robot, "--check-config").stdout


def test_print_config_is_the_file_and_shows_overrides() -> None:
    assert gprodomd("--print-config").stdout == CONFIG.read_text()
    changed = gprodomd("--set", "wheel.scale=0.97", "--set=wheel.max_speed=2", "--print-config")
    assert "  scale: 0.97 " in changed.stdout
    assert "  max_speed: 2 " in changed.stdout


def test_configs_merge_later_ones_over_those_before(tmp_path: Path) -> None:
    robot, wheel = tmp_path / "robot.yaml", tmp_path / "wheel.yaml"
    robot.write_text("wheel:\n  scale: 1.02\n  noise: 0.01\n")
    wheel.write_text("wheel:\n  scale: 0.98\n")
    merged = gprodomd("-c", robot, "-c", wheel, "--print-config").stdout
    assert "  scale: 0.98 " in merged and "  noise: 0.01 " in merged
    result = gprodomd("-c", robot, "-c", wheel, "--check-config")
    assert (result.returncode, result.stdout) == (0, f"{robot}: ok\n{wheel}: ok\n")
    wheel.write_text("wheel:\n  scale: fast\n")
    result = gprodomd("-c", wheel, "-c", robot, "--check-config")
    assert (result.returncode, result.stdout) == (1, ""), "the first counts too"
    assert f"{wheel}:2: wheel.scale" in result.stderr


@pytest.mark.parametrize(
    ("arguments", "code", "said"),
    [
        ([], 2, "-c CONFIG is needed"),
        (["-c"], 2, "-c needs CONFIG"),
        (["-c", "x", "extra"], 2, "unexpected argument extra"),
        (["--fast"], 2, "unknown option --fast"),
        (["--check-config=yes"], 2, "--check-config takes no value"),
        (["--realtime", "100"], 2, "expected a priority from 1 to 99, got 100"),
        (["-c", "/no/such.yaml"], 1, "/no/such.yaml: cannot be read: No such file or directory"),
        (["--print-config", "--set", "wheel.scal=1"], 1, "did you mean wheel.scale?"),
    ],
)
def test_bad_usage(arguments: list[str], code: int, said: str) -> None:
    result = gprodomd(*arguments)
    assert result.returncode == code
    assert said in result.stderr


@pytest.mark.parametrize(
    ("name", "what"),
    [("gprodomd", "--print-config"), ("gprodomd", "--help"), ("gprodom-replay", "--version")],
)
def test_what_cannot_be_printed_is_a_failure(name: str, what: str) -> None:
    with open("/dev/full", "w") as full:
        result = subprocess.run(
            [str(find_program(name)), what], stdout=full, stderr=subprocess.PIPE, text=True
        )
    assert result.returncode == 1
    assert result.stderr == f"{name}: standard output: cannot be written\n"


def test_bad_lcm_url_is_one_line_that_helps() -> None:
    result = gprodomd("-c", CONFIG, "--lcm-url", "carrier-pigeon://")
    assert result.returncode == 1
    assert "expected one like udpm://" in result.stderr


def test_status_without_a_daemon() -> None:
    code = "import sys; from gprodom.cli import main; sys.exit(main(sys.argv[1:]))"
    result = run_isolated(code, "status", "--once", "--timeout", "1.5", codes=(1,))
    assert "is gprodomd running" in result.stderr


@pytest.mark.parametrize("scenario", ["status", "two"])
def test_it_tells_of_itself(tmp_path: Path, scenario: str) -> None:
    run_isolated(SCENARIOS.read_text(), scenario, tmp_path, timeout_s=120)


@pytest.mark.parametrize("scenario", ["ground", "reload"])
def test_ground_is_kept(sample_log: Path, tmp_path: Path, scenario: str) -> None:
    (tmp_path / "in.lcmlog").symlink_to(sample_log)
    folder, name = SCENARIOS.parent, "daemon_maps.py"
    code = f"""
import runpy, sys
sys.path.insert(0, {str(folder)!r})
runpy.run_path({str(folder / name)!r}, run_name="__main__")
"""
    run_isolated(code, scenario, tmp_path, timeout_s=300)


@pytest.mark.parametrize("scenario", ["reread", "hostile", "service", "journal", "killed"])
@pytest.mark.parametrize("user", ["ours", "unprivileged"])
def test_live(scenario: str, user: str, open_folder: Path) -> None:
    as_user: Sequence[str] = ()
    if user == "unprivileged":
        if os.geteuid() != 0:
            pytest.skip("not root: the other case runs unprivileged already")
        as_user = UNPRIVILEGED
        usable = subprocess.run(
            [*as_user, sys.executable, "-c", "import gprodom"], capture_output=True
        )
        if usable.returncode != 0:
            pytest.skip("other users cannot read this checkout or its Python")
    run_isolated(SCENARIOS.read_text(), scenario, open_folder, as_user=as_user)
