"""bench/run: one JSON form, what was measured is kept, a failure is told and the others go on."""

import json
import re
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest
from benches import benches
from commits import sources_of
from ending import descendants
from job import Program

from conftest import BENCH, CHECKOUT, run_bench, run_program

RUNNER = BENCH / "runner"
pytestmark = pytest.mark.usefixtures("compiled")


def run(*arguments: object, code: int = 0) -> subprocess.CompletedProcess[str]:
    """bench/run, without its building."""
    return run_program(sys.executable, *arguments, codes=(code,))


def read(path: Path) -> dict[str, Any]:
    content: dict[str, Any] = json.loads(path.read_text())
    return content


def test_figures_have_one_form_and_are_kept(tmp_path: Path) -> None:
    options = ["--cache", tmp_path / "cache", "-o"]
    run(RUNNER, "sample", *options, tmp_path / "one")
    report = read(tmp_path / "one" / "sample.json")
    [job] = report["jobs"]
    assert (report["name"], report["failed"], job["job"]) == ("sample", {}, "sample")
    assert job["command"].startswith("bench/rough.py sample/")
    assert all(len(digest) == 64 for digest in job["data"].values())
    assert {name.partition(".")[2] for name in job["data"]} == {"zip", "json", "truth.npz"}
    figures = {figure["name"]: figure for figure in job["figures"]}
    error = figures["1700000000/gprodom_full/causal_m"]
    assert (error["unit"], error["better"], error["spread"]) == ("m", "lower", None)
    assert 0 < error["value"] < 0.05 < figures["1700000000/gprodom_full/dead_m"]["value"]
    assert figures["1700000000/gprodom_full/nees_map"]["better"] == "near 2"

    assert "1 jobs were measured before" in run(RUNNER, "sample", *options, tmp_path / "two").stderr
    assert read(tmp_path / "two" / "sample.json") == report

    # Other arguments are measured anew, and what fails of them is told.
    other = [*options, tmp_path / "three", "--set", "wheel.no_such=1"]
    assert "wheel.no_such=1: unknown key" in run(RUNNER, "sample", *other, code=1).stderr
    assert "unknown key" in read(tmp_path / "three" / "sample.json")["failed"]["sample"]


def test_what_differs_is_printed(tmp_path: Path) -> None:
    """The same program measured twice: no difference. With twice the wheel's noise: the drive."""
    options = ["--cache", tmp_path / "cache", "-o"]
    run(RUNNER, "sample", *options, tmp_path / "one")
    compared = ["--compare", tmp_path / "one"]
    same = run(RUNNER, "sample", "--fresh", *options, tmp_path / "two", *compared)
    assert "no difference in 5 figures" in same.stdout
    noisy = ["--set", "wheel.noise=0.01", *options, tmp_path / "three", *compared]
    told = run(RUNNER, "sample", *noisy).stdout
    assert re.search(r"^sample/1700000000/gprodom_full/causal_m .* (better|worse)$", told, re.M)
    assert "gprodom_full/dead_m" not in told.rpartition("ratio")[2]
    assert re.search(r"^\d of 5 figures differ: ", told, re.M)


def test_another_commit_is_taken_as_it_was(tmp_path: Path) -> None:
    if not (CHECKOUT / ".git").exists():
        pytest.skip("not a clone")
    program = sources_of("HEAD", tmp_path)
    show = ["git", "-C", str(CHECKOUT), "show", "HEAD:config/gprodom.yaml"]
    settings = program.root / "config" / "gprodom.yaml"
    assert settings.read_bytes() == subprocess.run(show, capture_output=True, check=True).stdout
    assert len(program.digest()) == 64 and program.digest() == Program(program.root).digest()
    assert program.environment()["GPRODOM_BUILD"] == str(program.root / "build")
    settings.write_text(settings.read_text().replace("noise: 0.005 ", "noise: 0.01  "))
    assert Program(program.root, "changed").digest() != program.digest()
    refused = run(RUNNER, "sample", "-o", tmp_path, "--compare", "no-such-commit", code=2)
    assert "no-such-commit: no such commit" in refused.stderr


def test_what_it_has_started_ends_with_it(tmp_path: Path) -> None:
    command = [sys.executable, RUNNER, "coverage", "--fresh", "-o", tmp_path, "--cache", tmp_path]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as runner:
        until = time.monotonic() + 120

        def runs_a_bench(process: int) -> bool:
            words = Path(f"/proc/{process}/cmdline")
            return words.exists() and b"map_coverage.py" in words.read_bytes()

        while not any(map(runs_a_bench, started := descendants(runner.pid))):
            assert runner.poll() is None and time.monotonic() < until
            time.sleep(0.1)
        runner.terminate()
        assert "what was measured is kept" in runner.communicate(timeout=60)[1]
        assert runner.returncode == 130
    while any(map(runs_a_bench, started)):
        assert time.monotonic() < until, "a bench runs on"
        time.sleep(0.1)


def test_unknown_names_are_refused(tmp_path: Path) -> None:
    unknown = run(RUNNER, "no_such", "-o", tmp_path, code=2).stderr
    assert "no_such: expected some of" in unknown
    assert "coverage, yard, consistency" in unknown  # they need no recorded data
    assert "expected one of" in run(RUNNER, "coverage/none", "-o", tmp_path, code=2).stderr


def test_every_program_takes_what_it_is_given(shared: Path) -> None:
    """The words of all jobs, in both forms, against the help of their programs."""
    words: dict[str, set[str]] = {}
    for bench in benches(shared):
        for job in bench.jobs:
            given = (*job.command(short=False), *job.command(short=True))
            own = given[: given.index("--")] if "--" in given else given
            options = {word.split("=")[0] for word in own if word.startswith("--")}
            words.setdefault(bench.program, set()).update(options)
    programs = [program for program in words if program.endswith(".py") and words[program]]
    assert len(programs) > 15
    with ThreadPoolExecutor() as pool:
        helps = pool.map(lambda program: run(RUNNER.parent / program, "--help").stdout, programs)
        unknown = {
            program: [word for word in words[program] if word not in help_text]
            for program, help_text in zip(programs, helps, strict=True)
        }
    assert not any(unknown.values()), unknown


def test_without_recorded_data_the_rest_is_measured(tmp_path: Path) -> None:
    done = run_program(sys.executable, RUNNER, "--list", GPRODOM_SHARED=str(tmp_path))
    assert f"no recorded data in {tmp_path / 'data'}" in done.stderr
    assert "\nsample " in done.stdout and "\nrobots " not in done.stdout


def test_other_recordings_by_a_description(shared: Path, tmp_path: Path) -> None:
    """A folder that the table does not know gives what the table's own gives."""
    folder = tmp_path / "more"
    folder.mkdir()
    for file in ("accelerometer", "gyroscope", "wheels", "position"):
        (folder / f"my_{file}.csv").symlink_to(shared / "robots" / "phil1" / f"{file}.csv")
    description = folder / "recordings.yaml"
    described = (
        "mine:\n  accelerometer: my_accelerometer.csv\n  gyroscope: my_gyroscope.csv\n"
        "  wheel: my_wheels.csv\n  position: my_position.csv\n"
        "  truth_sigma_m: 0.002\n  truth_delay_sigma_s: 0.05\n"
    )
    description.write_text(described)
    [mine] = run_bench("robots.py", folder).values()
    assert mine == run_bench("robots.py", shared / "robots", "--only", "phil1")["phil1"]

    description.write_text(described + "  truth_sigma: 1\n")
    assert "mine: unknown key truth_sigma" in run(BENCH / "robots.py", folder, code=1).stderr
    description.write_text(described.replace("  truth_sigma_m: 0.002\n", ""))
    assert "mine: truth_sigma_m is missing" in run(BENCH / "robots.py", folder, code=1).stderr
