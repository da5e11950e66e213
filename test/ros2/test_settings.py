"""The settings of the node: what it has, and what it refuses."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest

from kit import BIN, CHECKOUT


def ask(*arguments: str) -> subprocess.CompletedProcess[str]:
    command = [str(BIN / "gprodom_ros2"), *arguments]
    return subprocess.run(command, capture_output=True, text=True, timeout=20)


def test_settings_file_has_every_setting_at_its_default() -> None:
    said = ask("--print-settings")
    assert said.stdout == (CHECKOUT / "ros2" / "ros2.yaml").read_text()
    said = ask("--settings", str(CHECKOUT / "ros2" / "ros2.yaml"), "--check-config")
    assert said.returncode == 0, said.stderr


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("odometry: odom\nodometri: x\n", ":2: odometri: there is no such setting"),
        ("domain: 233\n", ":1: domain: expected an integer, 0 to 232"),
        ("domain: [1]\n", ":1: domain: expected an integer"),
        ("use_sim_time: maybe\n", ":1: use_sim_time: expected true or false"),
        (
            "wheel_message: wheels\n",
            "expected one of odometry, twist, joint, joints, ticks or none",
        ),
        ("wheel_message: joint\nwheel_joint: left\n", "set wheel_radius"),
        ("wheel_message: ticks\n", "set metres_per_tick"),
        ("namespace: husky\n", "expected a name that begins with /"),
        ("imu: imu data\n", "'imu data': not a name of ROS 2"),
        ("track: .nan\n", "track: expected a number"),
        ("- a\n", "expected lines of name: value"),
    ],
)
def test_what_cannot_be_used_is_said_in_one_line(tmp_path: Path, text: str, expected: str) -> None:
    (tmp_path / "ros2.yaml").write_text(text)
    said = ask("--settings", str(tmp_path / "ros2.yaml"), "--check-config")
    assert said.returncode == 1
    assert expected in said.stderr
    assert said.stderr.count("\n") == 1


def test_an_interface_that_is_not_there_is_said() -> None:
    said = ask("-p", "interface:=eth7")
    assert said.returncode == 1
    assert "interface 'eth7'" in said.stderr
