"""``gprodom map`` on the map of a short simulated drive, and on files that are not sound."""

import hashlib
import json
import os
import pwd
import shutil
import stat
import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

import gprodom
from conftest import Cli, line, rows_of, run_cli
from gprodom import canvas
from gprodom.map import service
from gprodom.map.ground import read_map
from gprodom.random_streams import stream
from gprodom.simulate.drives import drive_on_known_ground
from gprodom.simulate.routes import make_route
from gprodom.simulate.sequence import Spec, simulate
from known_drives import drive
from map_bytes import bodies, bodies_of_version_1, sealed, version_1

pytestmark = pytest.mark.usefixtures("compiled")


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
    run_cli("map", "cut", folder / "two.map", "--map", "0", "-o", folder / "one.map")
    return folder


def test_info_tells_what_is_in_a_file(made: Path, cli: Cli) -> None:
    path = made / "two.map"
    [found] = cli.json("map", "info", path)
    assert found["version"] == 4
    assert found["sha256"] == hashlib.sha256(path.read_bytes()).hexdigest()
    assert (found["samples"], found["sample_interval_s"]) == (201, 2e-10)
    assert found["bytes"] == path.stat().st_size
    assert [one["map"] for one in found["maps"]] == [0, 1]
    assert found["maps"][0]["from"] < found["maps"][0]["to"] < found["maps"][1]["from"]
    assert 8.0 < found["maps"][1]["length_m"] < 12.0  # the newest ground is not stored yet
    of_runs = sum(run["to_m"] - run["from_m"] for run in found["runs"])
    assert of_runs == pytest.approx(found["length_m"])
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
    text = cli("map", "info", path, "--runs").out
    assert "not in this version" not in text
    assert found["sha256"] in text and "ahead" in text and "back" in text


def test_a_column_has_one_place(made: Path) -> None:
    """Beyond a run's end, several nodes of the path have its last column as the nearest."""
    columns = read_map(made / "two.map").places["column"]
    assert (np.diff(columns) > 0).all()


def test_the_picture_shows_paths_and_ground(made: Path, drawn: list[canvas.Figure]) -> None:
    run_cli("map", "plot", made / "two.map", "-o", made / "two.png")
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
    run_cli("map", "export", made / "two.map", *outputs, *options)
    file = read_map(made / "two.map")
    chosen = file.places["map"] == 1
    rows = rows_of(made / "p.csv")
    assert len(rows) == np.count_nonzero(chosen)
    for name in ("x", "y"):
        told = [float(row[name]) for row in rows]
        np.testing.assert_allclose(told, file.places[name][chosen], rtol=1e-8, atol=1e-9)
    features = json.loads((made / "p.json").read_text())["features"]
    fixes = np.vstack([each["geometry"]["coordinates"] for each in features])
    assert len(features) == len({row["path"] for row in rows})
    # x points north: a metre of it is 1 / 111267 degrees of latitude there.
    np.testing.assert_allclose((fixes[:, 1] - 52) * 111_267, file.places["x"][chosen], atol=2e-3)


def test_an_export_wants_one_map(made: Path, cli: Cli) -> None:
    export = ["map", "export", str(made / "two.map"), "--csv", str(made / "none.csv")]
    assert "give --map, one of 0, 1" in cli.error(*export, code=2)
    cli(*export, "--map", "7", code=1)
    assert not (made / "none.csv").exists()


@pytest.mark.parametrize("option", ["--runs=1", "--distance=3:8", "--area=2,-1,6.5,1", "--map=1"])
def test_a_part_is_what_the_whole_has_there(made: Path, tmp_path: Path, option: str) -> None:
    more = ["--map", "0"] if "area" in option else []
    whole, part = made / "two.map", tmp_path / "part.map"
    run_cli("map", "cut", whole, option, *more, "-o", part)
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


def test_runs_that_are_not_there_are_told(made: Path, tmp_path: Path, cli: Cli) -> None:
    command = ["map", "cut", made / "two.map", "--runs=0-9", "-o", tmp_path / "part.map"]
    assert "its runs are 0 to" in cli.error(*command)


def test_cutting_away_nothing_changes_nothing(made: Path, tmp_path: Path) -> None:
    part = tmp_path / "part.map"
    run_cli("map", "cut", made / "two.map", "--distance=0:", "-o", part)
    assert part.read_bytes() == (made / "two.map").read_bytes()


def test_a_robot_finds_itself_on_a_part(made: Path, tmp_path: Path) -> None:
    part = tmp_path / "part.map"
    run_cli("map", "cut", made / "two.map", "--map=0", "-o", part)
    estimator = gprodom.Odometry()
    estimator.load_map(str(part))
    assert drive(estimator, drive_on_known_ground(0)).status[-1]["values"]["map.located"] == 1.0


@pytest.mark.parametrize("option", ["--area=1,1,0,2", "--distance=5:5", "--runs=1-", "--area=1,2"])
def test_bad_parts_are_bad_usage(made: Path, option: str) -> None:
    run_cli("map", "cut", made / "two.map", option, "-o", made / "none.map", code=2)


def test_version_1_still_loads_and_says_what_it_lacks(tmp_path: Path, cli: Cli) -> None:
    path = tmp_path / "old.map"
    path.write_bytes(sealed(1, version_1()))
    [found] = cli.json("map", "info", path)
    assert found["version"] == 1 and found["length_m"] == pytest.approx(4.0)
    assert all(found[name] is None for name in ("identity", "parents", "sessions"))
    assert cli("map", "info", path).out.count("not in this version") == 2
    estimator = gprodom.Odometry()
    estimator.load_map(str(path))
    estimator.save_map(str(tmp_path / "again.map"))
    assert (tmp_path / "again.map").read_bytes() == path.read_bytes()
    part = tmp_path / "part.map"
    cli("map", "cut", path, "--distance=1:3", "-o", part)
    assert read_map(part).ground.version == 1


def test_a_map_that_goes_on_names_its_parent(made: Path, tmp_path: Path) -> None:
    first = read_map(made / "one.map")
    estimator = gprodom.Odometry()
    estimator.load_map(str(first.path))
    estimator.save_map(str(tmp_path / "same.map"))
    assert (tmp_path / "same.map").read_bytes() == first.data
    drive(estimator, drive_on_known_ground(1), 10**13)
    estimator.save_map(str(tmp_path / "next.map"))
    after = read_map(tmp_path / "next.map").ground
    assert after.parents == [first.ground.identity]
    assert after.identity != first.ground.identity
    assert len(after.sessions()) == 2


def test_files_that_make_no_sense_are_refused_with_the_reason(
    made: Path, tmp_path: Path, cli: Cli
) -> None:
    path = tmp_path / "bad.map"
    bad = [(4, *each) for each in bodies((made / "one.map").read_bytes())]
    bad += [(1, *each) for each in bodies_of_version_1(version_1())]
    for version, reason, body in bad:
        path.write_bytes(sealed(version, body))
        said = cli.error("map", "info", path)
        assert said.startswith(f"gprodom: error: {path}: cannot be used: ") and reason in said
        with pytest.raises(gprodom.FileError, match="bad"):
            gprodom.Odometry().load_map(str(path))


def test_damaged_files_are_refused(made: Path, tmp_path: Path, cli: Cli) -> None:
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
            said = cli.error("map", name, path, *options, *([str(output)] if options else []))
            assert said.startswith(f"gprodom: error: {path}: cannot be used: ")
            assert said.count("\n") == 1
            assert ("of version 7; this program reads versions 1 to 6" in said) == (data is later)
    assert not output.exists()


def test_the_folder_of_the_service_is_for_root(
    made: Path, monkeypatch: pytest.MonkeyPatch, cli: Cli
) -> None:
    monkeypatch.setattr(os, "geteuid", lambda: 1000)
    for work in (["install", str(made / "one.map")], ["fetch", "ground"]):
        assert "run this as root" in cli.error("map", *work)
    monkeypatch.setattr(os, "geteuid", lambda: 0)
    monkeypatch.setattr(service, "USER", "no-such-user")
    assert "no user no-such-user: install the package" in cli.error(
        "map", "install", made / "one.map"
    )


def test_names_stay_in_the_folder(made: Path, cli: Cli) -> None:
    for name in ("../etc", ".hidden", "a/b", "", "a b", "ä", "n" * 101):
        for work in (("fetch", name), ("install", made / "one.map", "--as", name or ".")):
            assert "expected a map's name" in cli.error("map", *work)


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
    run_cli("map", "install", made / "one.map", made / "two.map", *there)
    found = (kept / "two.map").stat()
    assert stat.S_IMODE(found.st_mode) == 0o640
    assert (found.st_uid, found.st_gid) == (65534, kept.stat().st_gid)
    assert sorted(path.name for path in kept.iterdir()) == ["one.map", "two.map"]
    run_cli("map", "fetch", "one", "two.map", "-o", tmp_path, *there)
    for name in ("one.map", "two.map"):
        assert (tmp_path / name).read_bytes() == (made / name).read_bytes()
    assert (tmp_path / "one.map").stat().st_uid == 0
    assert (os.geteuid(), os.getegid(), os.getgroups()) == before


def test_what_the_service_has_is_not_lost_by_installing(made: Path, kept: Path, cli: Cli) -> None:
    install = ["map", "install", "--folder", kept]
    two, one = ((made / name).read_bytes() for name in ("two.map", "one.map"))
    cli(*install, made / "two.map", "--as", "ground")
    said = cli(*install, made / "one.map", "--as", "ground").out
    assert "it is kept as ground.kept-1.map" in said
    assert (kept / "ground.kept-1.map").read_bytes() == two
    (kept / "ground.map").chmod(0o666)  # as if root's daemon used it
    kept.chmod(0o777)
    daemon = gprodom.Odometry(set=[f"state.directory={kept}"])
    said = cli.error(*install, made / "two.map", "--as", "ground")
    assert "is in use by another estimator" in said
    cli(*install, made / "two.map", "--as", "yard")
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
    run_cli("map", "fetch", "link", "-o", tmp_path / "got.map", *there, code=1)
    assert not (tmp_path / "got.map").exists()
    run_cli("map", "install", made / "two.map", "--as", "link", *there)
    assert secret.read_bytes() == (made / "one.map").read_bytes()
