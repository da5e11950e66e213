"""A map outlasts a killed process, a full disk, a radar set otherwise and a power cut: some random
moments of bench/map_faults.py, and what its power cuts leave of simple files."""

import random
import sys
from pathlib import Path

import power_cuts
import pytest

from conftest import in_own_network, run_bench


@pytest.mark.usefixtures("compiled")
def test_the_map_is_there_after_faults_at_random_moments() -> None:
    found = run_bench("map_faults.py", "--moments", 5)["faults"]
    assert [each["fault"] for each in found] == ["kill", "disk", "format", "cut"]
    assert all(each["kept"] == 5 for each in found)


@pytest.mark.usefixtures("compiled")
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
