"""The pose in map on simulated drives over ground seen again; statistics: bench/map_coverage.py."""

import random
import shutil
import sys
from pathlib import Path
from typing import Any

import numpy as np
import power_cuts
import pytest

import gprodom
from conftest import in_own_network, run_bench
from gprodom.benchmark.monte_carlo import estimate_told
from gprodom.simulate.drives import drive_on_known_ground, wrong_revisits
from gprodom.simulate.recording import as_recording
from known_drives import drive

pytestmark = pytest.mark.usefixtures("compiled")


def error(run: Any, poses: dict[str, Any]) -> float:
    """RMS of the position, once a second, where the truth is placed by its first pose."""
    every = np.append(0, np.arange(len(poses["time"]) // 2, len(poses["time"]), 200))
    time = poses["time"][every] // 1000
    off = poses["position"][every, :2] - run.position_from(time[0], time)
    return float(np.sqrt(np.mean(np.sum(off[1:] ** 2, axis=1))))


@pytest.mark.parametrize("seed", [0, 1])
def test_revisits_help_and_wrong_ones_do_not_harm(seed: int) -> None:
    run = drive_on_known_ground(seed)
    [outputs] = estimate_told(run)
    found = [told for told in outputs.displacements if told["source"] == "revisit"]
    assert len(found) > 30
    truth = run.motion_at(np.array([[t["from"], t["to"]] for t in found]).ravel() // 1000)
    apart = np.hypot(np.diff(truth.x)[::2], np.diff(truth.y)[::2])
    assert np.mean(apart < 0.1) > 0.98
    assert error(run, outputs.odometry_map) < error(run, outputs.odometry) + 0.01

    told = wrong_revisits(run)
    *_, last = estimate_told(run, told=told)
    assert last.status[-1]["values"]["revisits.refused"] >= len(told)
    moved = last.odometry_map["position"][-1] - outputs.odometry_map["position"][-1]
    assert np.linalg.norm(moved) < 0.02


def test_the_solution_over_all_data_takes_revisits_in() -> None:
    run = drive_on_known_ground(0)
    smoothed = []
    for graph in ("true", "false"):
        estimator = gprodom.Odometry(set=[f"graph.enabled={graph}"])
        estimator.record()
        drive(estimator, run)
        smoothed.append(estimator.smoothed())
    with_revisits, without = smoothed
    assert np.array_equal(with_revisits["time"], without["time"])
    moved = np.linalg.norm(with_revisits["position"] - without["position"], axis=1)
    assert 1e-4 < moved.max() < 0.3


@pytest.mark.parametrize("seed", [0, 1])
def test_after_a_reset_the_robot_is_located_on_known_ground(tmp_path: Path, seed: int) -> None:
    run = drive_on_known_ground(seed)
    estimator = gprodom.Odometry()
    first = drive(estimator, run)
    known = str(tmp_path / "ground.map")
    estimator.save_map(known)
    other = gprodom.Odometry()
    other.load_map(known)
    estimator.reset()
    for later, shift in ((estimator, 10**13), (other, -(10**13))):
        outputs = drive(later, run, shift, 1.01, 30.0)
        assert outputs.status[-1]["values"]["map.located"] == 1.0
        # The revisits of the proof are those that tie the track: over more than one patch.
        told = [one for one in outputs.displacements if one["from"] == 0]
        proof = [one["to"] - shift for one in told if one["time"] == told[0]["time"]]
        travelled = np.interp(np.array(proof) // 1000, run.truth_utime, run.truth.travelled)
        assert travelled[-1] - travelled[0] > 1.7
        placed = outputs.odometry_map
        before = first.odometry_map
        end = [
            np.interp(placed["time"][-1] - shift, before["time"], before["position"][:, axis])
            for axis in (0, 1)
        ]
        assert np.hypot(*(placed["position"][-1, :2] - end)) < 0.2


@pytest.fixture(scope="module")
def known(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The ground of a line to and fro, as a run leaves it in its folder."""
    folder = tmp_path_factory.mktemp("known")
    drive(gprodom.Odometry(set=[f"state.directory={folder}"]), drive_on_known_ground(0))
    return folder / "ground.map"


def located_after_m(outputs: Any, run: Any, shift: int) -> float:
    """Metres driven when the status first says so; infinite: never."""
    when = [
        status["time"] - shift
        for status in outputs.status
        if status["values"].get("map.located") == 1.0
    ]
    return (
        float(np.interp(when[0] // 1000, run.truth_utime, run.truth.travelled)) if when else np.inf
    )


def end_off_m(outputs: Any, run: Any, shift: int) -> float:
    """How far the last pose in map is from the truth, placed by the first pose in odom."""
    begin = (outputs.odometry["time"][0] - shift) // 1000
    truth = run.position_from(begin, (outputs.odometry_map["time"][-1:] - shift) // 1000)
    return float(np.hypot(*(outputs.odometry_map["position"][-1, :2] - truth[-1])))


def test_a_rough_place_locates_sooner_and_right(known: Path) -> None:
    run, shift = drive_on_known_ground(0), 10**13
    found = []
    for told in ((), (0.5, -0.3, 0.1, 0.5)):
        estimator = gprodom.Odometry()
        estimator.load_map(str(known))
        if told:
            estimator.locate_at(*told)
        outputs = drive(estimator, run, shift, 1.01, 30.0)
        found.append(located_after_m(outputs, run, shift))
        values = outputs.status[-1]["values"]
        assert 0.0 < values["map.sigma_m"] < 0.5 and values["map.searched_m"] == 0.0
        assert not any(reason.startswith("map:") for reason in outputs.status[-1]["reasons"])
        assert end_off_m(outputs, run, shift) < 0.3
    assert found[1] < found[0] - 2.0


@pytest.mark.parametrize("where", ["other ground", "elsewhere on the map"])
def test_a_wrong_rough_place_is_not_believed(known: Path, where: str) -> None:
    other = where == "other ground"
    run, shift = drive_on_known_ground(3 if other else 0), 10**13
    estimator = gprodom.Odometry()
    estimator.load_map(str(known))
    estimator.locate_at(*((0.0, 0.0, 0.0) if other else (5.0, 0.0, np.pi)), 0.5)
    outputs = drive(estimator, run, shift, 1.01, 30.0)
    last = outputs.status[-1]
    refused = "map: locate_at: the ground there is not the one driven over: not located"
    if other:
        assert last["values"]["map.located"] == 0.0 and last["values"][refused] == 1.0
        assert last["values"]["map.searched_m"] > 30.0
        assert "map: searching for earlier ground" in last["reasons"]
        return
    # Its own search finds it in the end, or nothing does; but not where it was told to be.
    assert last["values"]["map.located"] != 1.0 or end_off_m(outputs, run, shift) < 0.3


def test_a_rough_place_must_make_sense(known: Path) -> None:
    estimator = gprodom.Odometry()
    for bad in ((np.nan, 0, 0, 0.5), (0, np.inf, 0, 0.5), (0, 0, 0, 0.0), (0, 0, 0, 10.0)):
        with pytest.raises(ValueError, match="expected"):
            estimator.locate_at(*bad)
    with pytest.raises(gprodom.FileError, match="there is no map"):
        gprodom.Odometry(set=["graph.enabled=false"]).locate_at(0, 0, 0, 0.5)
    estimator.locate_at(0, 0, 0, 0.5)  # without earlier ground: counted
    values = drive(estimator, drive_on_known_ground(1)).status[-1]["values"]
    assert sum("locate_at: not used: there is no earlier ground" in name for name in values) == 1


def test_read_only_writes_no_ground(known: Path, tmp_path: Path) -> None:
    shutil.copy(known, tmp_path / "ground.map")
    kept = [f"state.directory={tmp_path}", "state.map=read_only"]
    estimator = gprodom.Odometry(set=[*kept, "state.save_period=0.1"])
    values = drive(estimator, drive_on_known_ground(0), 10**13).status[-1]["values"]
    assert values["map.read_only"] == 1.0 and values["map.located"] == 1.0
    with pytest.raises(gprodom.FileError, match=r"state\.map is read_only"):
        estimator.save_map(str(tmp_path / "other.map"))
    assert (tmp_path / "ground.map").read_bytes() == known.read_bytes()
    assert not (tmp_path / "other.map").exists()
    assert (tmp_path / "pose.state").exists()  # the rest is kept as ever


# A located track that drives too far without a revisit: STATUS says that it is lost.


def test_lost_without_known_ground_and_found_again(tmp_path: Path) -> None:
    run = drive_on_known_ground(0)
    path = str(tmp_path / "ground.map")
    first = gprodom.Odometry()
    drive(first, run)
    first.save_map(path)

    # Sensors that are said to be poor, and no radar in the middle of the drive.
    estimator = gprodom.Odometry(set=["wheel.noise=0.8", "imu.accel_noise_density=0.1"])
    estimator.load_map(path)
    told = as_recording(run).messages()
    time = told["gpr_time"]
    begin, end = (int(np.quantile(time, share)) for share in (0.5, 0.75))
    kept = (time < begin) | (time > end)
    told["gpr_time"], told["traces"] = time[kept], told["traces"][kept]
    outputs = estimator.run(**told)

    status = [
        (one["time"] / 1e9, one["values"].get("map.located"), "; ".join(one["reasons"]))
        for one in outputs.status
    ]
    before = [one for one in status if one[0] < begin / 1e9]
    between = [one for one in status if begin / 1e9 <= one[0] < end / 1e9]
    assert before[-1][1] == 1.0
    assert not any("lost: no known" in said for *_, said in before)
    # Not at once, and from then on until there is ground again.
    assert between[0][1] == 1.0 and between[-1][1] == 0.0
    for _, located, said in between:
        assert ("lost: no known ground" in said) == (located == 0.0)
    assert status[-1][1] == 1.0 and "lost" not in status[-1][2]


# A map outlasts a killed process, a full disk, a radar set otherwise and a power cut: some random
# moments of bench/map_faults.py, and what its power cuts leave of simple files.


@pytest.mark.usefixtures("compiled")
def test_the_map_is_there_after_faults_at_random_moments() -> None:
    found = run_bench("map_faults.py", "--moments", 5)["faults"]
    assert [each["fault"] for each in found] == ["kill", "disk", "format", "cut"]
    assert all(each["kept"] == 5 for each in found)


def test_the_map_is_there_after_reloads_at_random_moments() -> None:
    in_own_network()  # else it is skipped
    (found,) = run_bench("map_restarts.py", "--moments", 5)["faults"]
    assert found["kept"] == 5, found["lost"]


WRITER = """
import os, sys
folder, way = sys.argv[1:]
def put(name, data, sync):
    file = os.open(f"{folder}/{name}", os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o644)
    os.write(file, data)
    if sync:
        os.fsync(file)
    os.close(file)
if way == "in place":
    put("a", b"new" * 100, True)
else:
    put("b", b"new" * 100, way == "synchronised")
    os.rename(f"{folder}/b", f"{folder}/a")
    file = os.open(folder, os.O_RDONLY)
    os.fsync(file)
"""


@pytest.mark.parametrize("way", ["in place", "renamed", "synchronised"])
def test_power_cuts_find_files_that_are_not_written_safely(tmp_path: Path, way: str) -> None:
    """The old file or the new one is there at each moment where it is synchronised and renamed; the
    other ways lose both at some moment, and that is seen."""
    folder = tmp_path / "files"
    folder.mkdir()
    (folder / "a").write_bytes(b"old")
    writer = [sys.executable, "-c", WRITER, str(folder), way]
    calls = power_cuts.record(writer, folder, tmp_path / "calls")
    chance = random.Random(1)
    left = {
        power_cuts.cut({"a": b"old"}, calls, at, folder, chance).get("a")
        for at in range(len(calls) + 1)
        for _ in range(20)
    }
    whole = {b"old", b"new" * 100}
    assert b"old" in left
    assert left == whole if way == "synchronised" else left - whole
