"""gprodom commission: the constants of robots whose true ones are known, and of the sample.

bench/commission.py does it to 50 robots and to recordings of real ones.
"""

import json
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from commission import deviations, make, one

from browser import show
from conftest import SAMPLE, Cli, run_isolated
from gprodom.commission.find import commission
from gprodom.commission.live import CIRCLING, HARD_STARTS, RETURN, STANDING, STRETCH, Guide
from gprodom.config import STANDARD
from gprodom.lcm.logs import Channel, read_roles
from gprodom.odometry.dead_reckoning import wheel_distance
from gprodom.odometry.settings import read_settings

# One wheel whose ticks are right, and a cart whose ticks are said to be 1.3 times too long.
RIGHT, OTHER_UNIT = 0, 1
LATE = 3  # a skid steer
BESIDE = 5  # one wheel, its IMU 0.26 m behind the origin and 0.1 m to the left
SIGMAS = 5.0  # of an error of one of some thirty numbers: by chance once in 50,000 runs


def made_log_of(seed: int, folder: Path) -> tuple[Any, dict[str, Channel]]:
    """A robot, and the log of its drive."""
    made = make(seed, folder, radar=False)
    return made, dict(read_roles(made.log, STANDARD.of("imu", "wheel")))


@pytest.mark.parametrize("seed", [RIGHT, OTHER_UNIT])
def test_robots(tmp_path: Path, seed: int, compiled: object) -> None:
    """Each constant within its standard deviations; the estimate after it is as good as `wheel`."""
    row = one(seed, tmp_path, radar=False)
    of_imu = {f"{each} of the IMU" for each in ("time offset", "mounting", "lever arm")}
    noises = {f"noise of the {each}" for each in ("gyro", "accelerometer")}
    assert set(row["deviations"]) >= {"wheel scale, by the stretch", *of_imu, *noises}
    assert ("track" in row["deviations"]) == (seed == OTHER_UNIT)
    for name, errors in row["deviations"].items():
        assert np.abs(errors).max() < SIGMAS, name
    assert row["findings"] == []
    assert row["allowed"], row
    assert "radar" in row["missing"]


def test_a_wrong_unit_is_found_without_a_tape(tmp_path: Path, compiled: object) -> None:
    """By accelerations, to some per cent; nothing is said to be found that was not shown."""
    made, log = made_log_of(RIGHT, tmp_path)
    log["wheel"] = {**log["wheel"], "metres_per_tick": 6 * log["wheel"]["metres_per_tick"]}
    found = commission(log, read_settings())
    by_name = {each.name: each for each in found.parameters}
    scale = by_name["wheel scale, by accelerations"]
    assert scale.value[0] == pytest.approx(6 * made.truth[scale.name][0], abs=3 * scale.sigma[0])
    assert scale.settings[0].startswith("wheel.scale=")
    assert not by_name["wheel scale"].value and "--stretch" in by_name["wheel scale"].manoeuvre
    assert [each.code for each in found.findings] == []


def test_command(tmp_path: Path, cli: Cli, compiled: object) -> None:
    """One whole configuration, with what was there before; a page; never over an input."""
    made = make(OTHER_UNIT, tmp_path, radar=False)
    before = tmp_path / "before.yaml"
    before.write_text("graph: {latency: 0.7}\nwheel: {drive: differential}\n")
    out, page = tmp_path / "robot.yaml", tmp_path / "robot.html"
    words = ["commission", str(made.log), "-c", str(before), f"--stretch={made.stretch_m}"]
    told = cli.json(*words, "-o", out, "--page", page)
    written = yaml.safe_load(out.read_text())
    assert written["graph"]["latency"] == 0.7 and written["wheel"]["drive"] == "differential"
    assert written["imu"]["rpy_body_imu"] != [0, 0, 0]
    by_name = {each["name"]: each for each in told["parameters"]}
    scale = by_name["wheel scale, by the stretch"]["value"][0]
    assert written["wheel"]["scale"] == pytest.approx(scale, abs=1e-4)
    assert deviations(told, made.truth).keys() >= {"track"}
    ways = {way["name"]: way["error_m"] for way in told["ways"]}
    assert told["of_truth"] and ways["imu_wheel, after"] < ways["imu_wheel, before"]
    text = page.read_text()
    assert "What the recording does not show" in text and "http" not in text.replace("www.w3", "")
    for scheme in ("light", "dark"):
        for frame in show(page, [390, 1200], scheme, tmp_path).frames:
            assert frame["cut"] == [] and frame["contrast"] > 4.5
    cli(*words, "-o", before, code=2)
    assert "is an input" in cli.error(*words, "-o", made.log, code=2)
    cli("commission", made.log, "--stretch", "0.1", code=2)


def test_an_imu_beside_the_origin(tmp_path: Path, compiled: object) -> None:
    """Its place is found and written, and what it adds does not spoil the mounting;
    where it is configured already, it is not written again."""
    made, log = made_log_of(BESIDE, tmp_path)
    true = made.truth["lever arm of the IMU"]
    configured = [f"imu.lever_arm=[{true[0]}, {true[1]}, 0]"]
    for settings, written in (([], True), (configured, False)):
        found = commission(log, read_settings((), settings), made.stretch_m)
        by_name = {each.name: each for each in found.parameters}
        arm = by_name["lever arm of the IMU"]
        np.testing.assert_allclose(arm.value, true, atol=0.05)
        assert any(each.startswith("imu.lever_arm=") for each in found.settings) == written
        told = {"parameters": [asdict(each) for each in found.parameters]}
        off = deviations(told, made.truth)
        assert max(map(abs, off["mounting of the IMU"] + off["lever arm of the IMU"])) < SIGMAS


def test_late_wheels_are_waited_for(tmp_path: Path, compiled: object) -> None:
    """Held and late by 0.42 s: with the IMU's stamps moved to theirs they would come too late."""
    made, log = made_log_of(LATE, tmp_path)
    found = commission(log, read_settings((), made.settings), made.stretch_m)
    by_name = {each.name: each for each in found.parameters}
    offset = by_name["time offset of the IMU"].value[0]
    assert offset > 0.35  # time.reorder_window
    assert by_name["time to wait for late stamps"].value[0] == pytest.approx(offset + 0.1, abs=1e-3)
    assert found.settings[-1].startswith("time.reorder_window=")


def test_the_sample(tmp_path: Path, cli: Cli, compiled: object) -> None:
    """Its IMU is mounted as configured and its clocks agree: nothing of that is written."""
    told = cli.json("commission", SAMPLE, "--no-replay")
    assert [s for s in told["settings"] if not s.startswith("imu.") or "noise" not in s] == []
    by_name = {each["name"]: each for each in told["parameters"]}
    assert by_name["mean frequency of the echoes"]["value"][0] == pytest.approx(5e8, rel=0.2)
    assert by_name["fastest speed for the trace rate"]["value"]
    assert by_name["noise of the IMU"]["manoeuvre"].startswith("stand still")


# gprodom commission --live: what to do next, by a robot of which nothing is known yet.


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
