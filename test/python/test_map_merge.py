"""``gprodom map merge`` on the maps of two simulated days."""

import json
from pathlib import Path

import numpy as np
import pytest

import gprodom
from conftest import Cli
from gprodom.geodesy import Datum
from gprodom.map.ground import read_map
from gprodom.map.merge import as_text
from gprodom.simulate.drives import drive_on_known_ground
from gprodom.simulate.recording import as_recording
from known_drives import drive, later
from map_bytes import sealed, version_1

pytestmark = pytest.mark.usefixtures("compiled")


def save(path: Path, seed: int, shift: int = 0, wheel: float = 1.0) -> None:
    """The map of a drive, `shift` ns later than it was, by another wheel."""
    estimator = gprodom.Odometry()
    drive(estimator, drive_on_known_ground(seed), shift, wheel, 30.0 if shift else 0.0)
    estimator.reset()
    estimator.save_map(str(path))


@pytest.fixture(scope="module")
def days(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two days on the same ground, and a day elsewhere."""
    folder = tmp_path_factory.mktemp("days")
    save(folder / "monday.map", 0)
    save(folder / "tuesday.map", 0, 10**14, 1.01)
    save(folder / "elsewhere.map", 3)
    return folder


SITE = (52.3906, 13.0645, 40.0)


def save_tied(path: Path, seed: int, day: int, place: tuple[float, float]) -> None:
    """The map of a drive with a fix in degrees each second."""
    pytest.importorskip("pyproj")
    run = drive_on_known_ground(seed)
    recording, estimator = as_recording(run), gprodom.Odometry(set=[f"anchor.datum={[*SITE]}"])
    random, late, since = np.random.RandomState(seed), day * 10**14, 0
    moments = np.arange(run.imu_utime[0], run.imu_utime[-1], 1_000_000)
    for moment in [*moments.tolist(), np.iinfo(np.int64).max]:
        estimator.run(**later(recording.messages(since, moment), late))
        if moment <= moments[-1]:
            there = run.motion_at(np.array([moment]))
            site = [there.x[0] + place[0], there.y[0] + place[1], 0.0]
            site[:2] += 0.02 * random.standard_normal(2)
            fix = Datum(*SITE).to_geographic(np.array([site]))[0]
            estimator.add_fix(moment * 1000 + late, fix, 4e-4 * np.eye(3), geodetic=True)
        since = moment
    estimator.reset()
    estimator.save_map(str(path))


def test_two_days_of_one_site_need_no_ground_in_common(tmp_path: Path, cli: Cli) -> None:
    save_tied(tmp_path / "one.map", 0, 0, (5.0, 3.0))
    save_tied(tmp_path / "two.map", 3, 1, (60.0, 25.0))
    one = read_map(tmp_path / "one.map")
    assert one.ground.version == 5
    [facts] = [each["site"] for each in cli.json("map", "info", one.path)[0]["maps"]]
    assert facts["origin"] == pytest.approx(SITE) and facts["x"] == facts["y"] == 0.0
    # m, at the origin, some metres from the track.
    assert 0.005 < facts["sigma_m"] < 0.3 and 1e-4 < facts["sigma_yaw"] < 0.05
    assert "site at 52.3906000, 13.0645000" in cli("map", "info", one.path).out
    written = tmp_path / "path.json"
    cli("map", "export", one.path, "--geojson", written)
    assert json.loads(written.read_text())["features"]
    [join] = cli.json(*merging(tmp_path, "one", "two"))["joins"]
    assert join["proven"] and join["by_datum"] and join["revisits"] == 0
    assert "by where both lie in site" in as_text(join)
    merged = read_map(tmp_path / "merged.map")
    two = read_map(tmp_path / "two.map")
    assert merged.maps == [0] and merged.ground.version == 5
    assert merged.length_m == pytest.approx(one.length_m + two.length_m)
    for name in "xy":
        both = np.concatenate([one.places[name], two.places[name]])
        np.testing.assert_allclose(merged.places[name], both, atol=1e-6)


def merging(folder: Path, first: str, second: str) -> list[object]:
    """The command."""
    one, two, merged = (folder / f"{name}.map" for name in (first, second, "merged"))
    return ["map", "merge", one, two, "-o", merged]


def test_two_days_become_one_map(days: Path, cli: Cli) -> None:
    found = cli.json(*merging(days, "monday", "tuesday"))
    [join] = found["joins"]
    assert "map 0 joins map 0" in as_text(join)
    assert join["proven"] and join["revisits"] > 20 and join["refused"] < 3
    assert 0.985 < join["scale"] < 1.015 and abs(join["longer_travel_times"]) < 0.02
    # Ground that is known is not stored twice.
    assert found["length_m"] < found["first_m"] + 1.0
    assert found["known_m"] == pytest.approx(
        found["first_m"] + found["second_m"] - found["length_m"]
    )
    monday, tuesday, merged = (
        read_map(days / f"{name}.map") for name in ("monday", "tuesday", "merged")
    )
    assert merged.ground.parents == [monday.ground.identity, tuesday.ground.identity]
    assert merged.maps == [0]
    moved = [np.abs(merged.places[n][: len(monday.places[n])] - monday.places[n]) for n in "xy"]
    assert max(map(np.max, moved)) < 0.2
    # A robot is at home in it.
    estimator = gprodom.Odometry()
    estimator.load_map(str(days / "merged.map"))
    assert drive(estimator, drive_on_known_ground(0)).status[-1]["values"]["map.located"] == 1.0


def test_nothing_is_written_of_a_stranger(days: Path, cli: Cli) -> None:
    (days / "merged.map").unlink(missing_ok=True)
    assert "no ground in common" in cli.error(*merging(days, "monday", "elsewhere"))
    assert not (days / "merged.map").exists()


def test_version_1_is_not_merged(days: Path, cli: Cli) -> None:
    (days / "old.map").write_bytes(sealed(1, version_1()))
    for names in (("monday", "old"), ("old", "monday")):
        assert "version 1" in cli.error(*merging(days, *names))


def test_travel_times_are_told_as_far_as_they_are_known() -> None:
    """The search begins at 0 and 5 % either way: -4 % for the same ground is what it came upon."""
    join = {"proven": True, "map": 0, "into": 0, "revisits": 30, "refused": 0, "proven_m": 9.0}
    join |= {"sigma_m": 0.05, "longer_travel_times": -0.04, "by_datum": False, "datum": None}
    assert "travel times alike within 5 %; its last pose is known to 5 cm" in as_text(join)
    assert "travel times about +9 % (to some 5 %)" in as_text(join | {"longer_travel_times": 0.09})
