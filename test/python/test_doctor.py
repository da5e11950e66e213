"""gprodom doctor: what is wrong with a recording is named, and nothing in good ones.

bench/doctor.py does it to 200 recordings.
"""

from functools import cache
from pathlib import Path

import numpy as np
import pytest
from doctor import BAND, DAMAGE, codes_of, damaged, recording
from recordings import RECORDINGS, convert

from conftest import Cli
from gprodom.config import STANDARD
from gprodom.doctor.examine import examine
from gprodom.doctor.finding import Log
from gprodom.drive.imu_mounting import ImuMounting
from gprodom.lcm.log_writer import Stream, write_log
from gprodom.lcm.logs import read_roles
from gprodom.lcm.wire import encode

SEEDS = (3, 4)  # figures of eight and stops, with left and right wheels
BESIDE_SEED = 5  # a loop, whose bends all go to one side
good = cache(recording)


@pytest.mark.parametrize("seed", SEEDS)
def test_nothing_is_found_in_good_recordings(seed: int) -> None:
    assert codes_of(good(seed)) == []


@pytest.mark.parametrize("name", DAMAGE)
def test_damage_is_named_and_what_mends_it(name: str) -> None:
    seed = next(seed for seed in SEEDS if DAMAGE[name].shown(seed))
    found = examine(damaged(good(seed), name, seed), ImuMounting(), BAND)
    assert {each.code for each in found} & set(DAMAGE[name].codes)
    assert all(each.what and each.mend for each in found), found


@pytest.mark.parametrize("name", ["wheel lost for 3 s", "IMU lost for 2 s"])
def test_a_gap_is_nothing_else(name: str) -> None:
    assert codes_of(damaged(good(3), name, 3)) == ["gap"]


REAL = {  # as ../shared/data/README.md describes them
    "husky": ["axes"],  # the robot's yaw rate is the IMU's y axis
    "warthog_a": ["clock"],  # wheels 0.15 to 0.2 s behind the gyro; it skids
    "f1tenth2": ["gap"],  # of 26 s
    "f1tenth3": ["axes"],  # IMU at some 92 degrees
    "xsens_skid": [],  # wheels read 13 % too far
    "phil1": [],  # shows too little of its mounting
}


@pytest.mark.parametrize("name", REAL)
def test_real_recordings(shared: Path, tmp_path: Path, name: str) -> None:
    log = tmp_path / "drive.lcmlog"
    convert(RECORDINGS[name], shared / "robots", log)
    found = examine(read_roles(log, STANDARD.of("imu", "wheel")), ImuMounting(), BAND)
    assert [each.code for each in found] == REAL[name]


def test_a_mounting_that_is_configured_is_not_found() -> None:
    turned = damaged(good(3), "IMU turned by 90 degrees", 3)
    assert [each.code for each in examine(turned, ImuMounting((0.0, 0.0, -np.pi / 2)), BAND)] == []


@pytest.mark.parametrize("percent", [93, 108])
def test_a_scale_that_the_estimator_divides_out_is_named(percent: int, compiled: object) -> None:
    """From 5 % on, at rest; less is a bias."""
    for share, codes in ((percent / 100, ["acceleration"]), (1 + (percent - 100) / 250, [])):
        log = {role: dict(content) for role, content in good(3).items()}
        log["imu"]["linear_acceleration"] = share * log["imu"]["linear_acceleration"]
        found = examine(log, ImuMounting(), BAND)
        assert [each.code for each in found] == codes
        assert all(f"{percent} % of gravity" in each.what for each in found)


def test_an_imu_beside_the_origin(tmp_path: Path, cli: Cli, compiled: object) -> None:
    """Bends add to its accelerations; by its place, as configured, nothing is wrong with them."""
    log = write(recording(BESIDE_SEED, (0.5, 0.0, 0.0)), tmp_path / "beside.lcmlog")
    place = ["--set", "imu.lever_arm=[0.5, 0, 0]"]
    cli("doctor", log, code=1)  # as if it were turned
    cli("doctor", log, *place)
    said = cli("doctor", log, *place, "--set", "imu.rpy_body_imu=[0, 0, 1.57]", code=1).out
    assert said.splitlines()[-2].startswith("axes: IMU: turned by -90 +- ")


def of_two_antennas(seed: int) -> Log:
    """A good recording, whose traces antenna 4 has, too, 4 ms later."""
    log = dict(good(seed))
    radar = log["gpr_trace"]
    rows = {name: values for name, values in radar.items() if isinstance(values, np.ndarray)}
    order = np.arange(2 * len(radar["utime"])).reshape(2, -1).T.ravel()
    both = {name: np.concatenate([values, values])[order] for name, values in rows.items()}
    both["antenna_id"] = np.tile([0, 4], len(radar["utime"]))
    both["utime"] = both["utime"] + np.where(both["antenna_id"] == 4, 4000, 0)
    return log | {"gpr_trace": {**radar, **both}}


@pytest.mark.parametrize(
    ("places", "codes", "said"),
    [
        ({0: (0.1, 0, 0), 4: (-0.1, 0, 0)}, [], ""),
        ({}, ["antenna"], "of antenna 4: gpr.antennas is empty"),
        ({4: (0.1, 0, 0)}, ["antenna"], "of antenna 0: gpr.antennas has not their place"),
        (dict.fromkeys((0, 4, 5)), ["antenna missing"], "no traces of antenna 5"),
    ],
    ids=["placed", "no places", "one placed", "one silent"],
)
def test_antennas_that_the_estimator_refuses_or_misses(
    places: dict[int, object], codes: list[str], said: str
) -> None:
    found = examine(of_two_antennas(3), ImuMounting(), BAND, places)
    assert [each.code for each in found] == codes
    assert all(said in each.what for each in found)


def test_each_antenna_is_judged() -> None:
    """Half of the traces of the second are empty."""
    log = of_two_antennas(4)
    radar = log["gpr_trace"]
    second = radar["antenna_id"] == 4
    radar["samples"] = radar["samples"].copy()
    radar["samples"][np.flatnonzero(second)[::2]] = 0
    (found,) = examine(log, ImuMounting(), BAND, {0: (0.1, 0, 0), 4: (-0.1, 0, 0)})
    assert found.code == "empty" and found.what.startswith("radar, antenna 4: 50 %")


def write(log: Log, path: Path) -> Path:
    """A log of IMU and left and right wheels, and of the radar where it has several antennas."""
    kinds = {"imu": ("IMU", "imu_t"), "wheels": ("WHEELS", "wheels_t")}
    if "gpr_trace" in log and log["gpr_trace"]["antenna_id"].any():
        kinds["gpr_trace"] = ("GPR_TRACE", "gpr_trace_t")
    streams = []
    for role, (channel, kind) in kinds.items():
        utime = log[role]["utime"]
        streams.append(Stream(channel, utime, encode(kind, log[role], len(utime))))
    write_log(path, streams)
    return path


def test_command(tmp_path: Path, cli: Cli, compiled: object) -> None:
    """Exit codes, JSON, and what the configuration says."""
    assert cli("doctor", write(good(3), tmp_path / "good.lcmlog")).out == "nothing found\n"
    log = write(damaged(good(3), "IMU turned by 90 degrees", 3), tmp_path / "turned.lcmlog")
    (found,) = cli.json("doctor", log, code=1)
    assert found["code"] == "axes" and "gprodom calibrate mount" in found["mend"]
    mended = ["--set", f"imu.rpy_body_imu=[0, 0, {-np.pi / 2}]"]
    cli("doctor", log, *mended)
    cli("doctor", log, "--set", "imu.rpy_body_imu=auto")
    two = of_two_antennas(3)
    log = write(two, tmp_path / "two.lcmlog")
    count = len(two["gpr_trace"]["utime"]) // 2
    said = cli("doctor", log, code=1).out
    assert said.startswith(f"antennas: 0 ({count} traces), 4 ({count} traces)\nantenna: radar: of")
    cli("doctor", log, "--set", "gpr.antennas={0: [0, 0, 0], 4: [0.3, 0, 0]}")
    assert "no_such" in cli.error("doctor", log, "--set", "imu.no_such=1")
