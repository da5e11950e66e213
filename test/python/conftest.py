"""Shared by the tests: the folders of test data, the command line, and a private network for
live LCM."""

import csv
import importlib.util
import io
import json
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gprodom
from gprodom import canvas
from gprodom.cli import main
from made_drive import write_drive

CHECKOUT = Path(__file__).resolve().parents[2]
BENCH = CHECKOUT / "bench"
CONFIG = CHECKOUT / "config" / "gprodom.yaml"
SAMPLE = CHECKOUT / "sample" / "1700000000-0-basement-cmu-gpr.zip"


def shared_folder() -> Path:
    """Recorded data for tests: beside the checkout, or named by GPRODOM_SHARED."""
    return Path(os.environ.get("GPRODOM_SHARED", CHECKOUT.parent / "shared"))


@pytest.fixture(scope="session")
def shared() -> Path:
    """The folder of shared test data; the test is skipped where there is none."""
    folder = shared_folder() / "data"
    if not folder.is_dir():
        pytest.skip(f"no shared test data in {folder} (name its parent in GPRODOM_SHARED)")
    return folder


@pytest.fixture(scope="session")
def compiled() -> None:
    """The compiled module is needed: without it the test is skipped, as where Python alone is."""
    if importlib.util.find_spec("gprodom._core") is None:
        pytest.skip("the extension gprodom._core is not built")


@pytest.fixture
def programs() -> Path:
    """The build's folder of benchmark programs: where there is a build that makes them, one that
    does not have them is a fault; the test is skipped where none is meant to."""
    build = gprodom._build
    if build is None or not (build / "CMakeCache.txt").is_file():
        pytest.skip("not run from a checkout that is built")
    if "GPRODOM_BENCHMARKS:BOOL=OFF" in (build / "CMakeCache.txt").read_text():
        pytest.skip(f"{build} is configured without benchmark programs")
    folder = build / "bench"
    assert (folder / "bench_yard").is_file(), f"no programs in {folder}: cmake --build {build}"
    return folder


def run_cli(*words: object, code: int = 0) -> None:
    """`gprodom WORDS` in this process, which must end with that exit code."""
    try:
        ended = main([*map(str, words)])
    except SystemExit as stopped:
        ended = stopped.code
    assert ended == code


class Cli:
    """`gprodom` in this process, and what it prints."""

    def __init__(self, capsys: pytest.CaptureFixture[str]) -> None:
        self._capsys = capsys

    def __call__(self, *words: object, code: int = 0) -> Any:
        """What `gprodom WORDS` prints: out, err."""
        self._capsys.readouterr()
        run_cli(*words, code=code)
        return self._capsys.readouterr()

    def json(self, *words: object, code: int = 0) -> Any:
        """What it prints with --json."""
        return json.loads(self(*words, "--json", code=code).out)

    def error(self, *words: object, code: int = 1) -> str:
        """What it says where it fails."""
        said: str = self(*words, code=code).err
        return said


@pytest.fixture
def cli(capsys: pytest.CaptureFixture[str]) -> Cli:
    return Cli(capsys)


@pytest.fixture(scope="session")
def made_log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The log of made_drive.py."""
    log = tmp_path_factory.mktemp("made") / "drive.lcmlog"
    write_drive(log)
    return log


def run_program(
    *command: object, codes: Sequence[int] = (0,), timeout_s: float = 600.0, **environment: str
) -> subprocess.CompletedProcess[str]:
    """A program, which must end with one of those exit codes, and what it prints."""
    words, changed = [*map(str, command)], {**os.environ, **environment}
    done = subprocess.run(words, capture_output=True, text=True, timeout=timeout_s, env=changed)
    assert done.returncode in codes, done.stdout + done.stderr
    return done


def run_bench(program: str, *words: object, codes: Sequence[int] = (0,)) -> Any:
    """What a program of bench/ prints with --json."""
    command = (sys.executable, BENCH / program, "--json", *words)
    return json.loads(run_program(*command, codes=codes).stdout)


@pytest.fixture(scope="session")
def sample_log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The sample sequence as a log."""
    log = tmp_path_factory.mktemp("sample") / "sample.lcmlog"
    run_cli("convert", "cmu", SAMPLE, "-o", log)
    return log


class Silent:
    """A teller that keeps what traces it hears (us, samples), and tells nothing."""

    def __init__(self) -> None:
        self.traces: list[tuple[int, int]] = []

    def trace(self, utime: int, samples: np.ndarray, _interval: float) -> list[Any]:
        self.traces.append((utime, len(samples)))
        return []

    def pose(self, _utime: int, _x: float, _y: float, _yaw: float) -> list[Any]:
        return []


@pytest.fixture
def drawn(monkeypatch: pytest.MonkeyPatch) -> list[canvas.Figure]:
    """The figures that were drawn, in order; each must be a picture that is not blank."""
    figures: list[canvas.Figure] = []
    to_png: Callable[..., bytes] = canvas.png

    def png(figure: canvas.Figure, dpi: int = 110) -> bytes:
        data = to_png(figure, dpi)
        assert len(colours_in(data)) > 10
        figures.append(figure)
        return data

    monkeypatch.setattr(canvas, "png", png)
    return figures


def rows_of(table: Path) -> list[dict[str, str]]:
    """Of a CSV."""
    with table.open(encoding="utf-8") as file:
        return list(csv.DictReader(file))


def colours_in(picture: bytes) -> set[str]:
    """The colours of a PNG's pixels, such as #0072b2."""
    from matplotlib.image import imread

    pixels = np.round(255 * imread(io.BytesIO(picture), "png")[..., :3]).astype(int)
    return {f"#{r:02x}{g:02x}{b:02x}" for r, g, b in np.unique(pixels.reshape(-1, 3), axis=0)}


def line(axis: canvas.Axes, label: str) -> np.ndarray:
    """(2, n): x and y of the line of that label, or of the first whose label begins with it."""
    [found, *_] = [each for each in axis.get_lines() if str(each.get_label()).startswith(label)]
    return np.array(found.get_data(), float)


UNPRIVILEGED = ("setpriv", "--reuid=65534", "--regid=65534", "--clear-groups", "--no-new-privs")


@pytest.fixture
def open_folder() -> Iterator[Path]:
    """A folder for any user, as `tmp_path` is not."""
    folder = Path(tempfile.mkdtemp(prefix="gprodom-"))
    folder.chmod(0o777)
    yield folder
    shutil.rmtree(folder)


def in_own_network() -> list[str]:
    """What stands before a command that runs in a network namespace of its own; where none can be
    made, the test is skipped."""
    if shutil.which("unshare") is None:
        pytest.skip("unshare (util-linux) is not installed")
    setup = "ip link set lo up && ip route add 224.0.0.0/4 dev lo"
    # In a chroot root may make a network namespace but no user namespace.
    unshare = ["unshare", "-n" if os.geteuid() == 0 else "-rn"]
    probe = subprocess.run([*unshare, "sh", "-c", setup], capture_output=True, text=True)
    if probe.returncode != 0:
        pytest.skip(f"no network namespace: {probe.stderr.strip()}")
    return [*unshare, "sh", "-c", f'{setup} && exec "$@"', "sh"]


def run_isolated(
    code: str,
    *arguments: object,
    as_user: Sequence[str] = (),
    timeout_s: float = 60.0,
    codes: Sequence[int] = (0,),
) -> subprocess.CompletedProcess[str]:
    """Runs Python code in a network namespace where LCM multicast stays on the loopback.

    Root may give `UNPRIVILEGED` as `as_user`, to run the code as nobody.
    """
    command = (*in_own_network(), *as_user, sys.executable, "-c", code, *arguments)
    return run_program(*command, codes=codes, timeout_s=timeout_s)
