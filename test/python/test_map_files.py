"""``gprodom map`` on the map of a short simulated drive, and on files that are not sound."""

from __future__ import annotations

import csv
import hashlib
import json
import os
import pwd
import shutil
import stat
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

import gprodom
from conftest import line
from gprodom.cli import main
from gprodom.map import service
from gprodom.map.ground import read_map
from gprodom.random_streams import stream
from gprodom.simulate.drives import drive_on_known_ground
from gprodom.simulate.recording import as_recording
from gprodom.simulate.routes import make_route
from gprodom.simulate.sequence import Simulated, Spec, simulate
from map_bytes import bodies, bodies_of_version_1, sealed, version_1

if TYPE_CHECKING:
    from matplotlib.figure import Figure

pytestmark = pytest.mark.usefixtures("compiled")


def drive(estimator: Any, run: Simulated, shift: int = 0) -> Any:
    """A whole drive, `shift` ns later than it was."""
    told = as_recording(run).messages()
    for time in ("imu_time", "wheel_time", "gpr_time"):
        told[time] = told[time] + shift
    return estimator.run(**told)


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two tracks that were never tied: a line to and fro, and a part of a loop elsewhere."""
    folder = tmp_path_factory.mktemp("maps")
    estimator = gprodom.Odometry()
    drive(estimator, drive_on_known_ground(0))
    estimator.reset()
    loop = make_route("loop", 12.0, 0.7, 4.0, stream(2, "route"))
    drive(estimator, simulate(Spec(loop, station=None), 2), 10**13)
    estimator.save_map(str(folder / "two.map"))
    assert main(["map", "cut", str(folder / "two.map"), "--map", "0", "-o",
                 str(folder / "one.map")]) == 0  # fmt: skip
    return folder


def info(path: Path, capsys: pytest.CaptureFixture[str]) -> dict[str, Any]:
    capsys.readouterr()
    assert main(["map", "info", "--json", str(path)]) == 0
    [found] = json.loads(capsys.readouterr().out)
    return dict(found)


def test_info_tells_what_is_in_a_file(made: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = made / "two.map"
    found = info(path, capsys)
    assert found["version"] == 4
    assert found["sha256"] == hashlib.sha256(path.read_bytes()).hexdigest()
    assert (found["samples"], found["sample_interval_s"]) == (201, 2e-10)
    assert found["bytes"] == path.stat().st_size
    assert [one["map"] for one in found["maps"]] == [0, 1]
    assert found["maps"][0]["from"] < found["maps"][0]["to"] < found["maps"][1]["from"]
    assert 8.0 < found["maps"][1]["length_m"] < 12.0  # the newest ground is not stored yet
    assert sum(run["to_m"] - run["from_m"] for run in found["runs"]) == pytest.approx(
        found["length_m"]
    )
    assert found["kb_per_m"] == pytest.approx(found["bytes"] / 1000 / found["length_m"])
    assert found["kb_per_m"] < 6.0
    assert found["parents"] == [] and len(found["identity"]) == 16
    assert [session["program"] for session in found["sessions"]] == [gprodom.__version__] * 2
    assert found["sessions"][0]["to"] < found["sessions"][1]["from"]
    assert [one["site"] for one in found["maps"]] == [None] * 2
    assert [session["robot"] for session in found["sessions"]] == [None] * 2  # of no live robot
    for session in found["sessions"]:
        errors = session["path_errors"]
        assert 1e-5 < errors["m_per_root_m"] < 0.02 and 1e-6 < errors["rad_per_root_m"] < 0.01
        assert 1e-5 < errors["scale"] < 0.05
    assert main(["map", "info", str(path), "--runs"]) == 0
    text = capsys.readouterr().out
    assert "not in this version" not in text
    assert found["sha256"] in text and "ahead" in text and "back" in text


def test_a_column_has_one_place(made: Path) -> None:
    """Beyond a run's end, several nodes of the path have its last column as the nearest."""
    columns = read_map(made / "two.map").places["column"]
    assert (np.diff(columns) > 0).all()


def test_the_picture_shows_paths_and_ground(made: Path, drawn: list[Figure]) -> None:
    assert main(["map", "plot", str(made / "two.map"), "-o", str(made / "two.png")]) == 0
    axes = drawn[-1].axes
    assert len(axes) == 2
    file = read_map(made / "two.map")
    for axis, number in zip(axes, (0, 1), strict=True):
        stored = line(axis, "ground stored")
        begin = line(axis, "where a path begins")[:, 0]
        np.testing.assert_allclose(begin, file.paths(number)[0].position[0, :2])
        places = file.places["map"] == number
        path = np.hstack([each.get_data() for each in axis.get_lines()])
        assert stored.shape[1] == np.count_nonzero(file.columns["map"] == number)
        assert np.isin(file.places["x"][places], path[0]).all()


def test_paths_are_exported_as_estimates_are(made: Path) -> None:
    pytest.importorskip("pyproj")
    options = ("--datum", "52,13,0,90", "--map", "1")
    outputs = ("--csv", str(made / "p.csv"), "--geojson", str(made / "p.json"))
    assert main(["map", "export", str(made / "two.map"), *outputs, *options]) == 0
    file = read_map(made / "two.map")
    chosen = file.places["map"] == 1
    with (made / "p.csv").open(encoding="utf-8") as text:
        rows = list(csv.DictReader(text))
    assert len(rows) == np.count_nonzero(chosen)
    for name in ("x", "y"):
        told = [float(row[name]) for row in rows]
        np.testing.assert_allclose(told, file.places[name][chosen], rtol=1e-8, atol=1e-9)
    features = json.loads((made / "p.json").read_text())["features"]
    fixes = np.vstack([each["geometry"]["coordinates"] for each in features])
    assert len(features) == len({row["path"] for row in rows})
    # x points north: a metre of it is 1 / 111267 degrees of latitude there.
    np.testing.assert_allclose((fixes[:, 1] - 52) * 111_267, file.places["x"][chosen], atol=2e-3)


def test_an_export_wants_one_map(made: Path, capsys: pytest.CaptureFixture[str]) -> None:
    export = ["map", "export", str(made / "two.map"), "--csv", str(made / "none.csv")]
    assert main(export) == 2
    assert "give --map, one of 0, 1" in capsys.readouterr().err
    assert main([*export, "--map", "7"]) == 1
    assert not (made / "none.csv").exists()


@pytest.mark.parametrize(
    "option", ["--runs=1", "--distance=3:8", "--area=2,-1,6.5,1", "--map=1", "--runs=0-9"]
)
def test_a_part_is_what_the_whole_has_there(
    made: Path, tmp_path: Path, option: str, capsys: pytest.CaptureFixture[str]
) -> None:
    more = ["--map", "0"] if "area" in option else []
    whole, part = made / "two.map", tmp_path / "part.map"
    if option == "--runs=0-9":  # more than there are
        assert main(["map", "cut", str(whole), option, "-o", str(part)]) == 1
        assert "its runs are 0 to" in capsys.readouterr().err
        return
    assert main(["map", "cut", str(whole), option, *more, "-o", str(part)]) == 0
    before, after = read_map(whole), read_map(part)
    assert 0 < after.length_m < before.length_m
    # Each column is one of the whole's, at the same time and place.
    index = np.searchsorted(before.ground.times(), after.ground.times())
    np.testing.assert_array_equal(before.ground.times()[index], after.ground.times())
    known = after.columns["map"] >= 0
    np.testing.assert_array_equal(after.columns["map"][known], before.columns["map"][index][known])
    for name in ("x", "y"):
        off = after.columns[name][known] - before.columns[name][index][known]
        assert np.abs(off).max() < 0.02  # at the edges by one known pose in place of two
    if "area" in option:
        x = before.columns["x"][index]
        assert x.min() >= 2 and x.max() <= 6.5
    if "distance" in option:
        assert after.length_m == pytest.approx(5.0)
    gprodom.Odometry().load_map(str(part))


def test_cutting_away_nothing_changes_nothing(made: Path, tmp_path: Path) -> None:
    part = tmp_path / "part.map"
    assert main(["map", "cut", str(made / "two.map"), "--distance=0:", "-o", str(part)]) == 0
    assert part.read_bytes() == (made / "two.map").read_bytes()


def test_a_robot_finds_itself_on_a_part(made: Path, tmp_path: Path) -> None:
    part = tmp_path / "part.map"
    assert main(["map", "cut", str(made / "two.map"), "--map=0", "-o", str(part)]) == 0
    estimator = gprodom.Odometry()
    estimator.load_map(str(part))
    values = drive(estimator, drive_on_known_ground(0)).status[-1]["values"]
    assert values["map.located"] == 1.0


@pytest.mark.parametrize("option", ["--area=1,1,0,2", "--distance=5:5", "--runs=1-", "--area=1,2"])
def test_bad_parts_are_bad_usage(made: Path, option: str) -> None:
    with pytest.raises(SystemExit) as ended:
        main(["map", "cut", str(made / "two.map"), option, "-o", str(made / "none.map")])
    assert ended.value.code == 2


def test_version_1_still_loads_and_says_what_it_lacks(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "old.map"
    path.write_bytes(sealed(1, version_1()))
    found = info(path, capsys)
    assert found["version"] == 1 and found["length_m"] == pytest.approx(4.0)
    assert all(found[name] is None for name in ("identity", "parents", "sessions"))
    assert main(["map", "info", str(path)]) == 0
    assert capsys.readouterr().out.count("not in this version") == 2
    estimator = gprodom.Odometry()
    estimator.load_map(str(path))
    estimator.save_map(str(tmp_path / "again.map"))
    assert (tmp_path / "again.map").read_bytes() == path.read_bytes()
    part = tmp_path / "part.map"
    assert main(["map", "cut", str(path), "--distance=1:3", "-o", str(part)]) == 0
    assert read_map(part).ground.version == 1


def test_a_map_that_goes_on_names_its_parent(made: Path, tmp_path: Path) -> None:
    first = read_map(made / "one.map")
    estimator = gprodom.Odometry()
    estimator.load_map(str(first.path))
    estimator.save_map(str(tmp_path / "same.map"))
    assert (tmp_path / "same.map").read_bytes() == first.data
    assert (tmp_path / "same.map").read_bytes() == first.data
    drive(estimator, drive_on_known_ground(1), 10**13)
    estimator.save_map(str(tmp_path / "next.map"))
    after = read_map(tmp_path / "next.map").ground
    assert after.parents == [first.ground.identity]
    assert after.identity != first.ground.identity
    assert len(after.sessions()) == 2


def test_files_that_make_no_sense_are_refused_with_the_reason(
    made: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "bad.map"
    bad = [(4, *each) for each in bodies((made / "one.map").read_bytes())]
    bad += [(1, *each) for each in bodies_of_version_1(version_1())]
    for version, reason, body in bad:
        path.write_bytes(sealed(version, body))
        assert main(["map", "info", str(path)]) == 1, reason
        said = capsys.readouterr().err
        assert said.startswith(f"gprodom: error: {path}: cannot be used: ") and reason in said
        with pytest.raises(gprodom.FileError, match="bad"):
            gprodom.Odometry().load_map(str(path))


def test_damaged_files_are_refused(
    made: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    whole = (made / "one.map").read_bytes()
    random = np.random.default_rng(1)
    flipped = [bytearray(whole) for _ in range(20)]
    for one in flipped:
        one[random.integers(len(whole))] ^= 1 << random.integers(8)
    later = sealed(7, b"of a later program")
    cut = [whole[:n] for n in (0, 5, 21, 30, len(whole) // 2, len(whole) - 1)]
    path, output = tmp_path / "bad.map", tmp_path / "out"
    for data in (*flipped, *cut, whole + b"\0", later, b"gprodom state 2\n" + whole[21:]):
        path.write_bytes(data)
        for work in ("info", "install", "plot -o", "cut --map=0 -o", "export --csv"):
            name, *options = work.split()
            assert (
                main(["map", name, str(path), *options, *([str(output)] if options else [])]) == 1
            )
            said = capsys.readouterr().err
            assert said.startswith(f"gprodom: error: {path}: cannot be used: ")
            assert said.count("\n") == 1
            assert ("of version 7; this program reads versions 1 to 6" in said) == (data is later)
    assert not output.exists()


def test_the_folder_of_the_service_is_for_root(
    made: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(os, "geteuid", lambda: 1000)
    for work in (["install", str(made / "one.map")], ["fetch", "ground"]):
        assert main(["map", *work]) == 1
        assert "run this as root" in capsys.readouterr().err
    monkeypatch.setattr(os, "geteuid", lambda: 0)
    monkeypatch.setattr(service, "USER", "no-such-user")
    assert main(["map", "install", str(made / "one.map")]) == 1
    assert "no user no-such-user: install the package" in capsys.readouterr().err


def test_names_stay_in_the_folder(made: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for name in ("../etc", ".hidden", "a/b", "", "a b", "ä", "n" * 101):
        assert main(["map", "fetch", name]) == 1
        assert main(["map", "install", str(made / "one.map"), "--as", name or "."]) == 1
        assert capsys.readouterr().err.count("expected a map's name") == 2


@pytest.fixture
def kept(monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A folder of `nobody`, as the service's is of its user."""
    if os.geteuid() != 0:
        pytest.skip("only root gives files away")
    user = pwd.getpwuid(65534)
    monkeypatch.setattr(service, "USER", user.pw_name)
    outer = Path(tempfile.mkdtemp())
    outer.chmod(0o755)
    folder = outer / "state"
    folder.mkdir(mode=0o750)
    os.chown(folder, user.pw_uid, user.pw_gid)
    yield folder
    shutil.rmtree(outer)


def test_install_and_fetch(made: Path, kept: Path, tmp_path: Path) -> None:
    there = ["--folder", str(kept)]
    before = os.geteuid(), os.getegid(), os.getgroups()
    assert main(["map", "install", str(made / "one.map"), str(made / "two.map"), *there]) == 0
    found = (kept / "two.map").stat()
    assert stat.S_IMODE(found.st_mode) == 0o640
    assert (found.st_uid, found.st_gid) == (65534, kept.stat().st_gid)
    assert sorted(path.name for path in kept.iterdir()) == ["one.map", "two.map"]
    assert main(["map", "fetch", "one", "two.map", "-o", str(tmp_path), *there]) == 0
    for name in ("one.map", "two.map"):
        assert (tmp_path / name).read_bytes() == (made / name).read_bytes()
    assert (tmp_path / "one.map").stat().st_uid == 0
    assert (os.geteuid(), os.getegid(), os.getgroups()) == before


def test_what_the_service_has_is_not_lost_by_installing(
    made: Path, kept: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    there = ["--folder", str(kept)]
    two, one = ((made / name).read_bytes() for name in ("two.map", "one.map"))
    assert main(["map", "install", str(made / "two.map"), "--as", "ground", *there]) == 0
    assert main(["map", "install", str(made / "one.map"), "--as", "ground", *there]) == 0
    assert "it is kept as ground.kept-1.map" in capsys.readouterr().out
    assert (kept / "ground.kept-1.map").read_bytes() == two
    (kept / "ground.map").chmod(0o666)  # as if root's daemon used it
    kept.chmod(0o777)
    daemon = gprodom.Odometry(set=[f"state.directory={kept}"])
    assert main(["map", "install", str(made / "two.map"), "--as", "ground", *there]) == 1
    assert "is in use by another estimator" in capsys.readouterr().err
    assert main(["map", "install", str(made / "two.map"), "--as", "yard", *there]) == 0
    del daemon
    assert (kept / "ground.map").read_bytes() == one


def test_a_link_of_the_service_leads_to_nothing_of_others(
    made: Path, kept: Path, tmp_path: Path
) -> None:
    secret = tmp_path / "secret.map"  # sound, and root's alone
    shutil.copy(made / "one.map", secret)
    secret.chmod(0o600)
    (kept / "link.map").symlink_to(secret)
    there = ["--folder", str(kept)]
    assert main(["map", "fetch", "link", "-o", str(tmp_path / "got.map"), *there]) == 1
    assert not (tmp_path / "got.map").exists()
    assert main(["map", "install", str(made / "two.map"), "--as", "link", *there]) == 0
    assert secret.read_bytes() == (made / "one.map").read_bytes()
