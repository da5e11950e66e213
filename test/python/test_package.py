"""The result of `cmake --install`: a library that others find, and man pages with every option."""

import os
import re
import sys
from pathlib import Path

import numpy as np
import pytest

import gprodom
from conftest import CHECKOUT, SAMPLE, Cli, run_program
from gprodom.cli import COMMANDS, build_parser
from gprodom.convert.cmu import read_recording
from gprodom.odometry.replay import find_program


def run(*command: str | Path, **environment: str) -> str:
    return run_program(*command, **environment).stdout


@pytest.fixture
def built() -> Path:
    """The build folder of this checkout."""
    folder = gprodom._build_folder()
    if folder is None:
        pytest.skip("not run from a checkout")
    assert (folder / "cmake_install.cmake").is_file(), f"{folder} is not built (scripts/setup)"
    return folder


def marked(header: Path) -> set[str]:
    """The classes and functions of a header that GPRODOM_EXPORT marks, with their name spaces."""
    text = header.read_text()
    [space] = re.findall(r"^namespace ([\w:]+) {", text, re.M)
    classes = re.findall(r"^(?:class|struct) GPRODOM_EXPORT (\w+)", text, re.M)
    functions = re.findall(r"^GPRODOM_EXPORT [^(]*?(\w+)\(", text, re.M)
    return {f"{space}::{name}" for name in (*classes, *functions)}


def test_the_library_exports_the_public_face_alone(built: Path) -> None:
    public = set()
    for header in (CHECKOUT / "include" / "gprodom").glob("*.h"):
        if "GPRODOM_EXPORT" in header.read_text() and header.stem != "export":
            public |= marked(header)
    assert {"gprodom::Odometry", "gprodom::Live", "gprodom::load_config"} <= public
    listed = run("nm", "-DC", "--defined-only", built / "lib" / "libgprodom.so").splitlines()
    names = [line.split(maxsplit=2)[2] for line in listed]
    names = [re.sub(r"^(vtable|typeinfo|typeinfo name) for ", "", name) for name in names]
    names = [name.split("(")[0].split("[abi:")[0] for name in names]
    owners = {
        next((p for p in public if name == p or name.startswith(f"{p}::")), name) for name in names
    }
    assert owners == public
    assert len(names) < 100


def test_an_outside_project_finds_and_uses_the_library(
    built: Path, sample_log: Path, tmp_path: Path
) -> None:
    # PATH as the system has it, so that an environment's cmake or Python is not what finds it.
    run("cmake", "--install", built, "--prefix", tmp_path / "usr", DESTDIR="", PATH=os.defpath)
    headers = list((tmp_path / "usr" / "include" / "gprodom").iterdir())
    assert 10 < len(headers) < 16, "what an integrator needs, and no more"
    source = CHECKOUT / "test" / "outside"
    run("cmake", "-S", source, "-B", tmp_path / "b", f"-DCMAKE_PREFIX_PATH={tmp_path / 'usr'}")
    run("cmake", "--build", tmp_path / "b")
    said = run(tmp_path / "b" / "outside")
    assert re.fullmatch(r"\d+ poses, at most 0\.00\d+ m from the origin\n", said)
    said = run(tmp_path / "b" / "beacons")
    assert re.fullmatch(r"1 runs: error .* m without ranges, .* m with them .*\n", said)
    said = run(tmp_path / "b" / "front_end", sample_log)
    told = r"(\d+) poses, (\S+) m driven; (\d+) standstills and (\d+) distances of similarity"
    found = re.fullmatch(rf"{told}, 0 of others\n", said)
    assert found, said
    poses, distance_m, standstills, distances = (float(value) for value in found.groups())
    usual = gprodom.Odometry().run(**read_recording(SAMPLE).messages()).odometry["position"]
    driven_m = np.linalg.norm(np.diff(usual[::20], axis=0), axis=1).sum()
    assert poses == len(usual)
    assert abs(distance_m - driven_m) < 0.05 * driven_m
    assert min(standstills, distances) > 20
    assert str(CHECKOUT) not in (tmp_path / "usr/lib").as_posix()


def test_an_outside_project_uses_the_library_of_a_checkout(
    built: Path, sample_log: Path, tmp_path: Path
) -> None:
    """As README.md tells it, with what scripts/setup builds and with what scripts/demo builds."""
    readme = (CHECKOUT / "README.md").read_text()
    assert "cmake -S examples/cpp/front_end -B out/front_end -Dgprodom_DIR=$PWD/build" in readme
    assert "lib/libgprodom.so" in run("ninja", "-C", built, "-t", "query", "programs")
    source, out = CHECKOUT / "examples" / "cpp" / "front_end", tmp_path / "b"
    run("cmake", "-S", source, "-B", out, f"-Dgprodom_DIR={built}", PATH=os.defpath)
    run("cmake", "--build", out, PATH=os.defpath)
    assert "standstills and" in run(out / "front_end", sample_log)


def test_a_build_folder_without_the_library_is_not_taken(built: Path, tmp_path: Path) -> None:
    for name in ("gprodom-config.cmake", "gprodom-config-version.cmake", "gprodom-targets.cmake"):
        text = (built / name).read_text().replace(str(built / "lib"), str(tmp_path / "lib"))
        (tmp_path / name).write_text(text)
    source = CHECKOUT / "examples" / "cpp" / "front_end"
    command = ("cmake", "-S", source, "-B", tmp_path / "b", f"-Dgprodom_DIR={tmp_path}")
    said = " ".join(run_program(*command, codes=(1,)).stderr.split())
    assert "libgprodom.so" in said
    assert f"is not built: cmake --build {tmp_path} --target gprodom" in said


@pytest.mark.parametrize(("program", "section"), [("gprodomd", 8), ("gprodom-replay", 1)])
def test_man_page_tells_of_every_option(program: str, section: int) -> None:
    page = (CHECKOUT / "share" / "man" / f"{program}.{section}").read_text().replace("\\-", "-")
    options = re.findall(r"^  (?:(-\w), )?(--[\w-]+)", run(find_program(program), "--help"), re.M)
    assert len(options) > 5
    described = [line for line in page.splitlines() if line.startswith((".BR -", ".B --"))]
    assert [o for o in options if not any(o[1] in line.split() for line in described)] == []
    assert len(described) == len(options)


def test_the_version_stands_once(cli: Cli) -> None:
    text = (CHECKOUT / "scripts" / "pyproject.toml").read_text()
    (version,) = re.findall(r'^version = "(.*)"$', text, re.M)
    assert gprodom.__version__ == version
    assert cli("--version").out == f"gprodom {version}\n"


def test_man_page_tells_of_every_command() -> None:
    page = (CHECKOUT / "share" / "man" / "gprodom.1").read_text()
    commands = re.findall(r"^    (\w+)", build_parser().format_help(), re.M)
    assert len(commands) >= len(COMMANDS)
    assert re.findall(r"^\.TP\n\.B (\w+)$", page, re.M) == commands


@pytest.mark.parametrize(
    ("check", "package", "code", "said"),
    [
        (0, 0, 0, "scripts/check passed, scripts/check-package passed"),
        (1, 0, 1, "scripts/check FAILED, scripts/check-package passed"),
        (0, 1, 1, "scripts/check passed, scripts/check-package FAILED"),
        (0, 3, 0, "scripts/check passed, scripts/check-package NOT RUN (no namespaces)"),
        (2, 3, 1, "scripts/check FAILED, scripts/check-package NOT RUN (no namespaces)"),
    ],
)
def test_integration_runs_and_reports_both_checks(
    check: int, package: int, code: int, said: str, tmp_path: Path
) -> None:
    (tmp_path / ".ci").mkdir()
    (tmp_path / ".ci" / "run").write_bytes((CHECKOUT / ".ci" / "run").read_bytes())
    (tmp_path / "scripts").mkdir()
    for name, status in (("check", check), ("check-package", package)):
        script = tmp_path / "scripts" / name
        script.write_text(f"#!/bin/sh\necho no namespaces >&2\nexit {status}\n")
        script.chmod(0o755)
    ran = run_program("bash", tmp_path / ".ci" / "run", codes=(code,))
    assert re.fullmatch(rf"\.ci/run: {re.escape(said)}, \d+ s", ran.stdout.splitlines()[-1])


@pytest.mark.parametrize(
    ("line", "offered"),
    [
        ("gprodomd --check", "--check-config"),
        ("gprodom-replay --sm", "--smoothed"),
        ("gprodom conv", "convert"),
        ("gprodom convert c", "cmu"),
        ("gprodom convert cmu --sam", "--sample-interval"),
    ],
)
def test_completion(line: str, offered: str) -> None:
    words = line.split()
    path = f"{find_program().parent}:{os.environ['PATH']}"
    script = f"""
        . {CHECKOUT / "share" / "completions" / "gprodom"}
        COMP_WORDS=({line}) COMP_CWORD={len(words) - 1}
        gprodom() {{ {sys.executable} -m gprodom "$@"; }}
        _gprodom {words[0]} && printf '%s\\n' "${{COMPREPLY[@]}}"
    """
    assert run("bash", "-c", script, PATH=path) == f"{offered}\n"
