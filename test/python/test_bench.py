"""The bench commands run, and the smoothers side by side agree: no times are judged."""

from __future__ import annotations

import csv
import json
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from conftest import CHECKOUT
from gprodom.cli import main
from gprodom.config import STANDARD
from gprodom.ground.survey import LATERAL
from gprodom.lcm import logs
from gprodom.odometry.dead_reckoning import wheel_distance
from gprodom.odometry.replay import find_program

BENCH = CHECKOUT / "bench"
KERNELS = BENCH / "kernels.py"
SAMPLE = next((CHECKOUT / "sample").glob("*-cmu-gpr.zip"))


def run(*command: object, codes: tuple[int, ...] = (0,)) -> str:
    """What a bench command prints."""
    done = subprocess.run(
        [sys.executable, *map(str, command)], capture_output=True, text=True, timeout=600
    )
    assert done.returncode in codes, done.stderr
    return done.stdout


def test_every_bench_is_named_where_it_is_found() -> None:
    """By a document, a test, a check, or by another bench that is."""
    sources = [path for path in BENCH.rglob("*") if path.suffix in (".py", ".cpp")]
    places = [*CHECKOUT.glob("docs/*.md"), *CHECKOUT.glob("test/python/*.py"), *sources]
    places += [path for path in CHECKOUT.glob("scripts/*") if path.is_file()]
    texts = {path: path.read_text(errors="replace") for path in places}
    kernels = re.findall(r'"(\w+)"', re.search(r"^PROGRAMS = .*$", texts[KERNELS], re.M)[0])
    unnamed = []
    for path in BENCH.iterdir():
        if path.suffix not in (".py", ".cpp") or path.stem.removeprefix("bench_") in kernels:
            continue
        name = path.stem
        word = re.compile(rf"\b{name}\.(py|cpp)|\bbench_{name}\b|^(import|from) {name}\b", re.M)
        if not any(word.search(text) for where, text in texts.items() if where != path):
            unnamed.append(path.name)
    assert unnamed == []


def test_smoothers_agree(tmp_path: Path, programs: Path) -> None:
    """The same factors: gprodom's newest estimates err as GTSAM's do."""
    pytest.importorskip("gtsam", reason="gtsam is not installed (scripts[bench])")
    sequence = tmp_path / "1700000000-0-yard-cmu-gpr.zip"
    drive = ["--route", "loop", "--distance", "12", "--seed", "3"]
    assert main(["simulate", *drive, "-o", str(sequence)]) == 0
    command = [BENCH / "smoothers.py", sequence, "--repeats", 1, "--json"]
    command += ["--program", programs / "bench_smoother_update"]
    errors = json.loads(run(*command, codes=(0, 1)))["error_m"]
    ours = errors["gprodom, ceres"]
    assert 0 < ours < 0.5
    assert errors["gprodom, chain"] == pytest.approx(ours, abs=1e-6)
    for other in ("GTSAM batch", "GTSAM incremental"):
        assert ours == pytest.approx(errors[other], rel=0.1, abs=0.005)


def test_both_solvers_of_the_window_publish_the_same(tmp_path: Path) -> None:
    log = tmp_path / "sample.lcmlog"
    assert main(["convert", "cmu", str(SAMPLE), "-o", str(log)]) == 0
    command = [BENCH / "window_solvers.py", log, "-c", CHECKOUT / "config" / "cmu_gpr.yaml"]
    (row,) = json.loads(run(*command, "--json"))
    assert row["poses"] > 1000
    assert row["max_m"] < 1e-6
    assert row["covariance"] < 1e-5
    assert row["same_bytes"]


def test_a_start_in_mid_drive() -> None:
    """The short form of bench/mid_drive.py. The sample errs by 12 mm: its ratios say little."""
    command = [BENCH / "mid_drive.py", SAMPLE, "--share", 0.3, "--share", 0.5, "--json"]
    outcomes = json.loads(run(*command, codes=(0, 1)))
    assert len(outcomes) == 2
    for outcome in outcomes:
        assert outcome["causal_m"] < 0.05
        assert outcome["smoothed_m"] < 2 * outcome["normal_smoothed_m"]
        assert 1.0 < outcome["start_s"] < 10.0
        assert outcome["nees_xy"] < 4
    # With a key that waits, no pose before the robot stands; too late for what is asked.
    waiting = ["--set", "initializer.wait_for_standstill=true"]
    for waits, moves in zip(
        json.loads(run(*command, *waiting, codes=(0, 1))), outcomes, strict=True
    ):
        assert waits["stands_s"] == moves["stands_s"]
        assert waits["start_s"] >= min(waits["stands_s"], moves["start_s"])
        if moves["stands_s"] > 5:
            assert waits["start_s"] > moves["start_s"]


def test_a_start_in_mid_drive_with_a_cheap_gyro() -> None:
    """Its bias is eight times that of the simulation's, as a car's on record: the wheel does not
    seem to slip by it, and the covariance holds."""
    cheap = ["--gyro-bias", -0.016, 0.016, 0.006]
    command = [BENCH / "mid_drive.py", SAMPLE, "--share", 0.3, "--share", 0.5, *cheap, "--json"]
    for outcome in json.loads(run(*command, codes=(0, 1))):
        assert outcome["causal_m"] < 0.1
        assert outcome["smoothed_m"] < 0.05
        assert 1.0 < outcome["start_s"] < 10.0
        assert outcome["nees_xy"] < 4


def test_gaps_of_the_wheel() -> None:
    """The short form of bench/wheel_gaps.py. In 3 s the sample drives more than a metre."""
    (row,) = json.loads(run(BENCH / "wheel_gaps.py", SAMPLE, "--gap", 3, "--json"))
    assert row["gaps"] >= 2
    assert row["imu_wheel_m"] < 0.02  # 0.023 where the count behind a gap is not used


def test_variations_of_a_recording() -> None:
    """The short form of bench/robot_variations.py. Which side is left makes no difference."""
    kinds = ["as recorded", "mirrored", "IMU upside down", "wheel 10 Hz", "wheel loses 0.5 s, 5 %"]
    kinds.append("IMU 0.5 m off along x, given")
    varied = [word for kind in kinds for word in ("--vary", kind)]
    rows = json.loads(run(BENCH / "robot_variations.py", SAMPLE, *varied, "--json"))
    found = {row["variation"]: row for row in rows}
    assert list(found) == kinds
    for row in rows:
        assert row["ratio"] < 1.15, row
        assert row["nees_xy"] < 6, row
        assert row["start_s"] < 10, row
        # What the arm adds is taken out a little late, and for a moment looks like a slip.
        assert row["jump_m"] < (0.2 if "given" in row["variation"] else 0.1), row
    assert found["mirrored"]["causal_m"] == pytest.approx(found["as recorded"]["causal_m"], 1e-3)


def test_turning_adds_accelerations_where_the_imu_sits(monkeypatch: pytest.MonkeyPatch) -> None:
    """On a circle towards its centre; where the turn gets faster, across the arm, too."""
    monkeypatch.syspath_prepend(str(BENCH))
    from sensors import Sensors
    from variations import displaced

    n, faster, arm = 1000, 0.2, 0.5  # of 0.01 s; rad/s^2; m
    turn = 1.0 + faster * 0.01 * np.arange(n)
    none, random = np.zeros((0, 3)), np.random.default_rng(1)
    time = np.arange(n, dtype=np.int64) * 10_000
    rate = np.column_stack([np.zeros((n, 2)), turn])
    still = Sensors(time, np.zeros((n, 3)), rate, time[:0], none, time[:0], none)
    inside = slice(100, -100)
    found = displaced(arm, 0, 0)(still, random).force[inside]
    expected = np.column_stack([-arm * turn**2, np.full(n, arm * faster), np.zeros(n)])[inside]
    np.testing.assert_allclose(found, expected, atol=0.01)


def test_a_wrong_mounting_is_told() -> None:
    """The short form of bench/mounting.py, on a drive of a minute and a half."""
    (found,) = json.loads(run(BENCH / "mounting.py", SAMPLE, "--json")).values()
    assert found.pop("right") == []
    assert all(len(changes) == 1 for changes in found.values()), found
    assert all(found[f"roll {degrees}"][0] < 10 for degrees in (90, 180)), found
    assert all(changes[0] < 80 for changes in found.values()), found


def test_traces_by_the_wheel_are_compared_with_those_of_a_clock() -> None:
    """The short form of bench/triggers.py: a radar that cannot tell slip harms nothing."""
    command = [BENCH / "triggers.py", "--ground", "rays", "--seeds", 1, "--spacing", 0.02, "--json"]
    rows = json.loads(run(*command))
    assert [(row["slip"], row["trigger"]) for row in rows] == [
        (slip, trigger) for slip in ("moments", "lasting") for trigger in ("time", "2 cm")
    ]
    for row in rows:
        assert row["error_m"] < 1.1 * row["without_m"] + 0.02, row


def test_immobilised_robots_are_told() -> None:
    """The short form of bench/immobilised.py."""
    drives = json.loads(run(BENCH / "immobilised.py", "--cases", 8, "--json"))
    cases = [case for drive in drives for case in drive["cases"]]
    assert len(cases) == 8
    assert sum(case["in_time"] for case in cases) >= 7, cases
    assert all(case["moved_m"] < 0.3 * case["turned_in_all_m"] for case in cases), cases
    assert sum(len(drive["false_alarms"]) for drive in drives) == 0, drives
    assert all(drive["in_status_s"] >= 2 for drive in drives), drives


def test_consistency_of_robots() -> None:
    command = [BENCH / "consistency.py", "--runs", 2, "--robot", "cart", "--surface", "grass"]
    ((name, drives),) = json.loads(run(*command, "--json", codes=(0, 1))).items()
    assert name == "cart, grass"
    assert drives["runs"] == 2
    assert 0 < drives["rmse_m"] < drives["reckoned_m"] < 5
    assert drives["nees_xy"]["low"] < 2 < drives["nees_xy"]["high"]


def test_a_log_driven_again_and_again(tmp_path: Path, programs: Path) -> None:
    """The short form of bench/soak.cpp: a row each minute, on a way longer than the log."""
    log, out = tmp_path / "sample.lcmlog", tmp_path / "soak.csv"
    assert main(["convert", "cmu", str(SAMPLE), "-o", str(log)]) == 0
    command = [str(programs / "bench_soak"), str(log), "0.1", str(out)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=600)
    assert done.returncode == 0, done.stderr
    rows = list(csv.DictReader(out.open()))
    assert float(rows[-1]["distance_m"]) > 100 and float(rows[-1]["revisits"]) > 10


def test_a_log_is_made_longer(tmp_path: Path) -> None:
    log, long = tmp_path / "sample.lcmlog", tmp_path / "long.lcmlog"
    assert main(["convert", "cmu", str(SAMPLE), "-o", str(log)]) == 0
    run(BENCH / "repeat_log.py", log, long, "--seconds", 200)
    sensors = STANDARD.of("imu", "wheel")
    short, read = logs.read_roles(log, sensors), logs.read_roles(long, sensors)
    time = read["imu"]["utime"]
    assert (time[-1] - time[0]) * 1e-6 == pytest.approx(200, abs=0.1)
    steps = wheel_distance(read)[1]
    assert abs(steps).max() > 2 * abs(wheel_distance(short)[1]).max()
    assert (abs(steps[1:] - steps[:-1]) < 0.1).all()


def test_a_robot_is_located_on_changed_ground() -> None:
    """The short form of bench/changed_ground.py. Without stretched travel times it is not."""
    command = [BENCH / "changed_ground.py", "--runs", 2, "--others", 0, "--change", 20, "--json"]
    now, before = json.loads(run(*command))["figures"]
    assert (now["right"], now["false_on_known_ground"], now["false_on_strangers"]) == (2, 0, 0)
    assert now["along_cm_rms"] < 10
    assert now["right_within_20_m"] == 2
    assert before["matcher"] == "before" and before["right_within_20_m"] < 2


def test_a_stranger_is_not_located() -> None:
    """One of two drives over other ground that a single revisit located."""
    options = ["--runs", 1, "--first-seed", 87, "--change", 10, "--no-beside", "--json"]
    (found,) = json.loads(run(BENCH / "changed_ground.py", *options))["figures"]
    assert (found["right"], found["strangers"], found["false_on_strangers"]) == (1, 1, 0)


def test_drives_of_another_day_in_a_folder(tmp_path: Path) -> None:
    """The short form of bench/days.py: on the same ground it is located, on another it is not."""
    for seed, ground in ((3, "basement"), (4, "basement"), (5, "garage")):
        drive = ["--ground", ground, "--route", "loop", "--distance", "40", "--seed", str(seed)]
        zipped = tmp_path / f"170000000{seed}-0-{ground}-cmu-gpr.zip"
        assert main(["simulate", *drive, "-o", str(zipped)]) == 0
    (day,) = json.loads(run(BENCH / "days.py", tmp_path, "--json"))
    assert day["map_of"].startswith("1700000003") and day["sequence"].startswith("1700000004")
    assert 5 < day["located_after_m"] < 35
    assert 0 < day["with_map_m"] < 0.1 and 0 < day["without_m"] < 0.1
    strangers = json.loads(run(BENCH / "days.py", tmp_path, "--strangers", "--json"))
    assert [each["located_after_m"] for each in strangers] == [None] * 3


def test_maps_of_two_days_become_one() -> None:
    """The short form of bench/merge.py."""
    command = [BENCH / "merge.py", "--runs", 1, "--change", 10, "--jobs", 1, "--json"]
    [found] = json.loads(run(*command))
    assert (found["proven"], found["strangers_joined"], found["moved_by_strangers_m"]) == (1, 0, 0)
    assert max(found["after_m"]) < max(found["before_m"])
    assert found["bytes_after"] < 1.1 * max(found["bytes_before"])


def test_real_ground_of_another_day(shared: Path) -> None:
    """The short form of bench/real_another_day.py; told about where it is, it is located."""
    command = [BENCH / "real_another_day.py", shared, "--lines", 1, "--strangers", 1]
    searched, told, field, strangers = json.loads(run(*command, "--change", 0, "--json"))
    assert told["right"] == field["right"] == 1
    assert searched["false"] == told["false"] == field["false"] == strangers["false"] == 0
    assert told["along_cm_rms"] < 10 and field["along_cm_rms"] < 10


def test_replay_gives_the_same_bytes_again(tmp_path: Path) -> None:
    """The short form of bench/same_bytes.py, and that it detects a difference."""
    command = [BENCH / "same_bytes.py", "--short", "--json"]
    results = json.loads(run(*command))
    assert [result["case"].split()[0] for result in results] == ["sample", "commands", "state"]
    assert all(result["messages"] > 10_000 for result in results)
    assert all(result["differing"] == [] for result in results)
    assert results[1]["files"] > 3  # two maps besides what every run leaves

    other = tmp_path / "gprodom-replay"
    other.write_text(f'#!/bin/sh\nexec {find_program()} "$@" --set imu.time_offset=0.005\n')
    other.chmod(0o755)
    results = json.loads(run(*command, "--base-program", other, codes=(1,)))
    for result in results:
        assert any(each.startswith("ODOMETRY: ") for each in result["differing"])


def test_ground_beside_a_track_is_as_the_simulator_has_it(shared: Path) -> None:
    found = json.loads(run(BENCH / "lateral.py", shared / "real_ground", "--json"))
    assert pytest.approx(found["lateral_m"], rel=0.05) == LATERAL
    aside = [row["aside"] for row in found["rows"]]
    assert 0.7 > aside[0] > aside[1] > aside[2] > 0.05
