"""gprodom commission --live: what to do next, by a robot of which nothing is known yet."""

import json
from pathlib import Path

import numpy as np
import pytest
import yaml
from commission import make

from conftest import Cli, run_isolated
from gprodom.commission.live import CIRCLING, HARD_STARTS, RETURN, STANDING, STRETCH, Guide
from gprodom.config import STANDARD
from gprodom.lcm.logs import read_roles
from gprodom.odometry.dead_reckoning import wheel_distance


def guided(log: Path, until_s: float = np.inf) -> list[tuple[int, float]]:
    """(step, s) of each step that was reached, by the messages of a log in order of time."""
    content = read_roles(log, STANDARD.of("imu", "wheel", "wheels"))
    imu, (time, distance) = content["imu"], wheel_distance(content)
    guide, reached = Guide(), [(0, 0.0)]
    stamps = np.concatenate([imu["utime"], time])
    begin = stamps.min()
    for row in np.argsort(stamps, kind="stable"):
        seconds = float(stamps[row] - begin) * 1e-6
        if seconds > until_s:
            break
        i = int(row) - len(imu["utime"])
        if i >= 0:
            guide.wheel(int(time[i]), float(distance[i]))
        else:
            force, rate = (imu[name][row] for name in ("linear_acceleration", "angular_velocity"))
            guide.imu(int(stamps[row]), force, rate)
        if guide.step > reached[-1][0]:
            reached.append((guide.step, seconds))
    assert guide.done == (guide.step == RETURN + 1)
    return reached


@pytest.mark.parametrize("seed", range(5))
def test_each_step_is_left_when_it_is_done(seed: int, tmp_path: Path) -> None:
    """One wheel, cart, rover, skid steer and car, their IMU mounted and their ticks scaled at
    random."""
    made = make(seed, tmp_path, radar=False)
    reached = guided(made.log)
    assert [step for step, _ in reached] == [0, 1, 2, 3, 4, 5]
    seconds = [second for _, second in reached]
    assert seconds[STRETCH] == pytest.approx(30.0, abs=1.5)
    assert seconds[HARD_STARTS] > seconds[STRETCH] + 3
    assert seconds[CIRCLING] > seconds[HARD_STARTS] + 20
    content = read_roles(made.log, STANDARD.of("imu"))
    whole = float(np.ptp(content["imu"]["utime"])) * 1e-6
    assert whole - 4 < seconds[RETURN + 1] <= whole


def test_a_step_that_is_not_done_is_not_left(tmp_path: Path) -> None:
    made = make(0, tmp_path, radar=False)
    steps = [step for step, _ in guided(made.log)]
    before = dict(guided(made.log))
    assert steps[-1] == RETURN + 1
    for step in (STANDING, STRETCH, HARD_STARTS, CIRCLING, RETURN):
        assert guided(made.log, before[step + 1] - 1.0)[-1][0] == step


def test_turns_to_one_side_are_not_enough() -> None:
    guide = Guide()
    guide.step = CIRCLING
    guide._count, guide._force = 1, np.array([0.0, -9.81, 0.0])  # on its side: up is -y
    for i in range(2000):
        guide.imu(20_000 * i, np.array([0.0, -9.81, 0.0]), np.array([0.0, -0.5, 0.0]))
        guide.wheel(20_000 * i, 0.01 * i)
    assert guide.step == CIRCLING
    assert "3.2 of 2 to the left, 0.0 of 2 to the right" in guide.line()


def test_usage(tmp_path: Path, cli: Cli) -> None:
    log = str(tmp_path / "a.lcmlog")
    for arguments in ([], ["--live"], [log, "--record", log], [log, "--live", "--record", log]):
        assert cli.error("commission", *arguments, code=2).count("\n") == 1


LIVE = """
import signal, subprocess, sys, time
from gprodom.lcm import DEFAULT_URL, LCM, EventLog
log, folder = sys.argv[1:]
command = [sys.executable, "-m", "gprodom", "commission", "--live",
           "--record", folder + "/a.lcmlog", "-o", folder + "/robot.yaml",
           "--no-replay", "--stretch", "10", "--json"]
process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                           stdin=subprocess.DEVNULL)
lcm = LCM(DEFAULT_URL)
events = [each for each in EventLog(log, "r")]
time.sleep(6.0)  # until it listens
begun = time.monotonic()
for event in events:  # a drive of minutes in seconds: the stamps are those of the data
    due = begun + (event.timestamp - events[0].timestamp) * 1e-6 / 12
    while time.monotonic() < due:
        time.sleep(0.0005)
    lcm.publish(event.channel, event.data)
out, said = process.communicate(timeout=200)
print(process.returncode); print(said); print("JSON" + out)
"""


def test_a_drive_is_recorded_and_gives_a_configuration(tmp_path: Path, compiled: object) -> None:
    made = make(1, tmp_path, radar=False)
    done = run_isolated(LIVE, made.log, tmp_path, timeout_s=300)
    said, _, told = done.stdout.partition("JSON")
    assert said.startswith("0\n"), said
    assert "1 of 5: stand still" in said and "to the right" in said
    assert "nothing from: IMU, wheel" in said  # before the robot was heard
    assert "ended in step" not in said
    found = {each["name"]: each for each in json.loads(told)["parameters"]}
    assert found["wheel scale, by the stretch"]["value"] and found["mounting of the IMU"]["value"]
    assert yaml.safe_load((tmp_path / "robot.yaml").read_text())["wheel"]["scale"] != 1.0
    sent, kept = (read_roles(log, STANDARD.of("imu")) for log in (made.log, tmp_path / "a.lcmlog"))
    assert len(kept["imu"]["utime"]) > 0.99 * len(sent["imu"]["utime"])
