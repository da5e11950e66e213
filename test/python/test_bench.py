"""The bench commands run, and the smoothers side by side agree: no times are judged."""

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from repeat_log import repeat
from sensors import Sensors
from variations import displaced

from conftest import BENCH, CHECKOUT, SAMPLE, run_bench, run_cli
from gprodom.config import STANDARD
from gprodom.ground.survey import LATERAL
from gprodom.lcm import logs
from gprodom.odometry.dead_reckoning import wheel_distance
from gprodom.odometry.replay import find_program

KERNELS = BENCH / "kernels.py"


def test_every_bench_is_named_where_it_is_found() -> None:
    """By a document, a test, a check, the table of bench/run, or by another bench that is."""
    sources = [path for path in BENCH.rglob("*") if path.suffix in (".py", ".cpp")]
    places = [*CHECKOUT.glob("docs/*.md"), *CHECKOUT.glob("test/python/**/*.py"), *sources]
    places += [path for path in CHECKOUT.glob("scripts/*") if path.is_file()]
    texts = {path: path.read_text(errors="replace") for path in places}
    kernels = re.findall(r'"(\w+)"', re.search(r"^PROGRAMS = .*$", texts[KERNELS], re.M)[0])
    unnamed = []
    for path in BENCH.iterdir():
        if path.suffix not in (".py", ".cpp") or path.stem.removeprefix("bench_") in kernels:
            continue
        name = path.stem
        ways = [rf"\b{name}\.(py|cpp)", rf"\bbench_{name}\b", rf"^(import|from) {name}\b"]
        word = re.compile("|".join([*ways, rf'(Bench|as_it_is|timed)\(\s*"{name}"']), re.M)
        if not any(word.search(text) for where, text in texts.items() if where != path):
            unnamed.append(path.name)
    assert unnamed == []


def test_smoothers_agree(tmp_path: Path, programs: Path) -> None:
    """The same factors: gprodom's newest estimates err as GTSAM's do."""
    pytest.importorskip("gtsam", reason="gtsam is not installed (scripts[bench])")
    sequence = tmp_path / "1700000000-0-yard-cmu-gpr.zip"
    drive = ["--route", "loop", "--distance", "12", "--seed", "3"]
    run_cli("simulate", *drive, "-o", sequence)
    words = [sequence, "--repeats", 1, "--program", programs / "bench_smoother_update"]
    errors = run_bench("smoothers.py", *words, codes=(0, 1))["error_m"]
    ours = errors["gprodom, ceres"]
    assert 0 < ours < 0.5
    assert errors["gprodom, chain"] == pytest.approx(ours, abs=1e-6)
    for other in ("GTSAM batch", "GTSAM incremental"):
        assert ours == pytest.approx(errors[other], rel=0.1, abs=0.005)


def test_both_solvers_of_the_window_publish_the_same(sample_log: Path) -> None:
    config = CHECKOUT / "config" / "cmu_gpr.yaml"
    (row,) = run_bench("window_solvers.py", sample_log, "-c", config)
    assert row["poses"] > 1000
    assert row["max_m"] < 1e-6
    assert row["covariance"] < 1e-5
    assert row["same_bytes"]


def mid_drive(*words: object) -> Any:
    """Two starts in the sample."""
    shares = ("--share", 0.3, "--share", 0.5)
    return run_bench("mid_drive.py", SAMPLE, *shares, *words, codes=(0, 1))


def test_a_start_in_mid_drive() -> None:
    """The short form of bench/mid_drive.py. The sample errs by 12 mm: its ratios say little."""
    outcomes = mid_drive()
    assert len(outcomes) == 2
    for outcome in outcomes:
        assert outcome["causal_m"] < 0.05
        assert outcome["smoothed_m"] < 2 * outcome["normal_smoothed_m"]
        assert 1.0 < outcome["start_s"] < 10.0
        assert outcome["nees_xy"] < 4
    # With a key that waits, no pose before the robot stands; too late for what is asked.
    waiting = mid_drive("--set", "initializer.wait_for_standstill=true")
    for waits, moves in zip(waiting, outcomes, strict=True):
        assert waits["stands_s"] == moves["stands_s"]
        assert waits["start_s"] >= min(waits["stands_s"], moves["start_s"])
        if moves["stands_s"] > 5:
            assert waits["start_s"] > moves["start_s"]


def test_a_start_in_mid_drive_with_a_cheap_gyro() -> None:
    """Its bias is eight times that of the simulation's, as a car's on record: the wheel does not
    seem to slip by it, and the covariance holds."""
    for outcome in mid_drive("--gyro-bias", -0.016, 0.016, 0.006):
        assert outcome["causal_m"] < 0.1
        assert outcome["smoothed_m"] < 0.05
        assert 1.0 < outcome["start_s"] < 10.0
        assert outcome["nees_xy"] < 4


def test_variations_of_a_recording() -> None:
    """The short form of bench/robot_variations.py. Which side is left makes no difference."""
    kinds = ["as recorded", "mirrored", "IMU upside down", "wheel 10 Hz", "wheel loses 0.5 s, 5 %"]
    kinds += ["no wheel for 3 s", "IMU 0.5 m off along x, given"]
    varied = [word for kind in kinds for word in ("--vary", kind)]
    rows = run_bench("robot_variations.py", SAMPLE, *varied)
    found = {row["variation"]: row for row in rows}
    assert list(found) == kinds
    for row in rows:
        assert row["ratio"] < 1.15, row
        assert row["nees_xy"] < 6, row
        assert row["start_s"] < 10, row
        # What the arm adds is taken out a little late, and for a moment looks like a slip.
        assert row["jump_m"] < (0.2 if "given" in row["variation"] else 0.1), row
    assert found["mirrored"]["causal_m"] == pytest.approx(found["as recorded"]["causal_m"], 1e-3)


def test_turning_adds_accelerations_where_the_imu_sits() -> None:
    """On a circle towards its centre; where the turn gets faster, across the arm, too."""
    n, faster, arm = 1000, 0.2, 0.5  # of 0.01 s; rad/s^2; m
    turn = 1.0 + faster * 0.01 * np.arange(n)
    none, random = np.zeros((0, 3)), np.random.default_rng(1)
    time = np.arange(n, dtype=np.int64) * 10_000
    rate = np.column_stack([np.zeros((n, 2)), turn])
    still = Sensors(time, np.zeros((n, 3)), rate, time[:0], none, time[:0], none)
    inside = slice(100, -100)
    found = displaced(still, random, (arm, 0, 0)).force[inside]
    expected = np.column_stack([-arm * turn**2, np.full(n, arm * faster), np.zeros(n)])[inside]
    np.testing.assert_allclose(found, expected, atol=0.01)


def test_a_wrong_mounting_is_told() -> None:
    """In STATUS, of a drive of a minute and a half; a right one is not."""
    kinds = {"as recorded": False, "yaw of the IMU 90 degrees off": True}
    rows = run_bench("robot_variations.py", SAMPLE, *(f"--vary={kind}" for kind in kinds))
    for row in rows:
        told = any(reason.startswith("IMU mounting") for reason in row["reasons"])
        assert told == kinds[row["variation"]], row["reasons"]


def test_immobilised_robots_are_told() -> None:
    """The short form of bench/immobilised.py."""
    drives = run_bench("immobilised.py", "--cases", 8)
    cases = [case for drive in drives for case in drive["cases"]]
    assert len(cases) == 8
    assert sum(case["in_time"] for case in cases) >= 7, cases
    assert all(case["moved_m"] < 0.3 * case["turned_in_all_m"] for case in cases), cases
    assert sum(len(drive["false_alarms"]) for drive in drives) == 0, drives
    assert all(drive["in_status_s"] >= 2 for drive in drives), drives


def test_a_log_is_made_longer(sample_log: Path, tmp_path: Path) -> None:
    long = tmp_path / "long.lcmlog"
    repeat(sample_log, long, 200)
    sensors = STANDARD.of("imu", "wheel")
    short, read = logs.read_roles(sample_log, sensors), logs.read_roles(long, sensors)
    time = read["imu"]["utime"]
    assert (time[-1] - time[0]) * 1e-6 == pytest.approx(200, abs=0.1)
    steps = wheel_distance(read)[1]
    assert abs(steps).max() > 2 * abs(wheel_distance(short)[1]).max()
    assert (abs(steps[1:] - steps[:-1]) < 0.1).all()


def test_a_robot_is_located_on_changed_ground() -> None:
    """The short form of bench/changed_ground.py. Without stretched travel times it is not."""
    words = ["--runs", 2, "--others", 0, "--change", 20]
    now, before = run_bench("changed_ground.py", *words)["figures"]
    assert (now["right"], now["false_on_known_ground"], now["false_on_strangers"]) == (2, 0, 0)
    assert now["along_cm_rms"] < 10
    assert now["right_within_20_m"] == 2
    assert before["matcher"] == "before" and before["right_within_20_m"] < 2


def test_a_stranger_is_not_located() -> None:
    """One of two drives over other ground that a single revisit located."""
    words = ["--runs", 1, "--first-seed", 87, "--change", 10, "--no-beside"]
    (found,) = run_bench("changed_ground.py", *words)["figures"]
    assert (found["right"], found["strangers"], found["false_on_strangers"]) == (1, 1, 0)


def test_real_ground_of_another_day(shared: Path) -> None:
    """The short form of bench/real_another_day.py; told about where it is, it is located."""
    words = ["--lines", 1, "--strangers", 1, "--change", 0]
    searched, told, field, strangers = run_bench("real_another_day.py", shared, *words)
    assert told["right"] == field["right"] == 1
    assert searched["false"] == told["false"] == field["false"] == strangers["false"] == 0
    assert told["along_cm_rms"] < 10 and field["along_cm_rms"] < 10


def test_replay_gives_the_same_bytes_again(tmp_path: Path) -> None:
    """The short form of bench/same_bytes.py, and that it detects a difference."""
    results = run_bench("same_bytes.py", "--short")
    assert [result["case"].split()[0] for result in results] == ["sample", "commands", "state"]
    assert all(result["messages"] > 10_000 for result in results)
    assert all(result["differing"] == [] for result in results)
    assert results[1]["files"] > 3  # two maps besides what every run leaves

    other = tmp_path / "gprodom-replay"
    other.write_text(f'#!/bin/sh\nexec {find_program()} "$@" --set imu.time_offset=0.005\n')
    other.chmod(0o755)
    results = run_bench("same_bytes.py", "--short", "--base-program", other, codes=(1,))
    for result in results:
        assert any(each.startswith("ODOMETRY: ") for each in result["differing"])


def test_ground_beside_a_track_is_as_the_simulator_has_it(shared: Path) -> None:
    found = run_bench("lateral.py", shared / "real_ground")
    assert pytest.approx(found["lateral_m"], rel=0.05) == LATERAL
    aside = [row["aside"] for row in found["rows"]]
    assert 0.7 > aside[0] > aside[1] > aside[2] > 0.05
