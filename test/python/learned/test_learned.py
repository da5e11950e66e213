"""A tiny training learns, its networks say the same in both runtimes, and methods and bench run."""

import shutil
import sys
from pathlib import Path

import numpy as np
import pytest

import gprodom
from conftest import SAMPLE, Cli, Silent, run_bench, run_cli, run_program
from gprodom.errors import Error
from gprodom.learned import answers, windows
from gprodom.learned.command import torch_version
from gprodom.learned.drives import by_images, by_windows, read_drive
from gprodom.learned.examples import joined
from gprodom.learned.grounds import KEPT, Line, make_line, receive, seeds
from gprodom.learned.live import Inference
from gprodom.learned.model import NETWORKS, Network, read_record
from gprodom.random_streams import stream
from packets import packet

PYTHON = Path("/usr/bin/python3")


@pytest.fixture(scope="module")
def networks(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Trained for less than a minute on a tenth of the grounds."""
    pytest.importorskip("onnxruntime", reason="onnxruntime is not installed (scripts[learned])")
    try:
        torch_version(PYTHON)
    except Error:
        pytest.skip(f"no PyTorch in {PYTHON}: apt-get install python3-torch")
    folder = tmp_path_factory.mktemp("networks")
    short = ["--share", "0.1", "--epochs", "6", "--threads", "1", "--lines", KEPT[0]]
    run_cli("learn", SAMPLE, "-o", folder, *short)
    return folder


def test_a_tiny_training_learns(networks: Path) -> None:
    record = read_record(networks)
    assert set(record["grounds"]["validate"]).isdisjoint(record["grounds"]["train"])
    assert record["grounds"]["sequences"] == [SAMPLE.name]
    way, pair = (record["training"][name] for name in NETWORKS)
    # On ground that it has not seen; a constant explains nothing.
    assert way["r2_log"] > 0.3
    assert way["history"][-1]["loss"] < way["history"][0]["loss"]
    # A guess errs by 0.3 m in the median.
    assert pair["median_m"] < 0.2


def test_both_runtimes_say_the_same(networks: Path) -> None:
    for name in NETWORKS:
        network = Network(networks, name)
        with np.load(networks / f"{name}.npz") as kept:
            inputs = [key for key in ("before", "after", "memory", "query") if key in kept]
            assert {*inputs, "told"} == set(kept)
            first, second = (kept[key] for key in inputs)
            np.testing.assert_allclose(network(first, second), kept["told"], atol=1e-4)


def test_a_faster_pass_is_told_to_be_faster(networks: Path) -> None:
    """Whatever the number of traces: it is the same for both."""
    network = Network(networks, "learned_sequential")
    line = make_line(seeds("validate")[0])
    told = []
    for spacing in (0.005, 0.02):
        along = 1.0 + spacing * np.arange(200)
        traces = receive(line, along, 20.0, stream(1, "pass"))
        rows = windows.to_rows(traces, line.sample_interval)
        starts = range(0, 160, 10)
        before = np.array([rows[i : i + 16] for i in starts])
        after = np.array([rows[i + 10 : i + 26] for i in starts])
        told.append(float(np.median(network(before, after)[:, 0])))
    assert told[1] - told[0] > 0.3  # of ln 4


@pytest.mark.parametrize("method", NETWORKS)
def test_methods_run_on_a_sequence(networks: Path, tmp_path: Path, method: str, cli: Cli) -> None:
    tum = tmp_path / "out.tum"
    command = ["run", SAMPLE, "--method", method, "--networks", networks, "--truth", SAMPLE]
    told = cli.json(*command, "--tum", tum)
    assert len(tum.read_text().splitlines()) > 1000
    if method == "learned_sequential":
        assert told["answered"] > 0.9
        assert told["revisits"] == 0
    else:
        assert told["answered"] in (0, None)


def test_a_method_is_answered_by_its_network(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of the folder that is given; a network that says nothing leaves IMU and wheel."""
    heard = Silent()

    def teller(folder: Path) -> Silent:
        assert folder == tmp_path
        return heard

    monkeypatch.setitem(answers.TELLERS, "learned_pair", teller)
    command = ["run", str(SAMPLE), "--method", "learned_pair", "--networks", str(tmp_path)]
    run_cli(*command, "--tum", tmp_path / "out.tum")
    assert len(heard.traces) > 1000


def test_a_method_without_its_network_says_so(cli: Cli) -> None:
    assert "--networks" in cli.error("run", SAMPLE, "--method", "learned_pair", code=2)


@pytest.mark.usefixtures("compiled")
def test_the_factorial_bench(networks: Path) -> None:
    """The short form of bench/learned_factorial.py, on one ground."""
    found = run_bench("learned_factorial.py", networks, "--share", 0.05)
    by_name = {way["method"]: way for way in found["ways"]}
    # The coherence sees what a network that is hardly trained need not: the bench must show it.
    assert by_name["coherence, scaled"]["r2"][0] > 0.3
    assert by_name["coherence"]["standing_mps"] < 0.01
    for way in by_name.values():
        assert way["r2"][1] <= way["r2"][0] <= way["r2"][2]
    assert {pair["pairs"] for pair in found["pairs"]} == {"consecutive", "revisit"}


def test_windows_keep_what_they_are_given() -> None:
    """A trace that rises evenly does so in rows, whatever the sample interval."""
    for interval, samples in ((2e-10, 201), (3.125e-10, 351)):
        ramp = np.arange(samples) * interval * 1e9 * 100  # counts; 100 a nanosecond
        rows = windows.on_rows(np.tile(ramp, (3, 1)), interval) * windows.FULL_SCALE
        expected = (np.arange(windows.ROWS) + 0.5) * windows.ROW_TIME * 1e11 - 50 * interval * 1e9
        np.testing.assert_allclose(rows[1], expected, atol=20)
    # An offset of the receiver is taken off, the ground's wave is not.
    time = np.arange(201) * 0.2  # ns
    wave = 1000 * np.sin(2 * np.pi * 0.5 * time)
    plain, offset = windows.to_rows(np.array([wave, wave + 300 - 4 * time]), 2e-10)
    np.testing.assert_allclose(offset[6:-6], plain[6:-6], atol=1e-5)
    assert np.abs(plain).max() > 0.8 * 1000 / windows.FULL_SCALE
    along = np.arange(0, 3, 0.03)
    rows = np.repeat(along[:, None], windows.ROWS, 1).astype(np.float32)
    picture = windows.image(rows, along, 1.0)
    middles = 1.0 + windows.COLUMN * (np.arange(windows.COLUMNS) + 0.5)
    np.testing.assert_allclose(picture, np.tile(middles, (windows.ROWS, 1)), atol=1e-5)


def test_examples_of_a_sequence_have_its_way_and_offsets() -> None:
    """The sample is driven both ways over the same ground, in laps."""
    drive, random = read_drive(SAMPLE), stream(1, "drive")
    ways = joined(by_windows(drive, random))
    with np.load(SAMPLE.with_name(SAMPLE.stem + ".truth.npz")) as truth:
        driven = float(np.abs(np.diff(truth["s"])).sum())
    assert drive.way[-1] == pytest.approx(driven, rel=0.01)
    assert ways["spacing"].min() < 1e-3  # it stands at first
    pairs = by_images(drive, random)
    same = pairs["same"] > 0.5
    assert 50 < same.sum() == (~same).sum()

    def likeness(way: int) -> float:
        """Of images on the same ground, shifted by `way` times their offset."""
        found = []
        for memory, query, offset in zip(
            pairs["memory"][same], pairs["query"][same], pairs["offset"][same], strict=True
        ):
            shift = way * round(float(offset) / windows.COLUMN)
            columns = np.arange(max(0, shift), min(windows.COLUMNS, windows.COLUMNS + shift))
            a, b = (
                x[24:, at].astype(float) for x, at in ((memory, columns), (query, columns - shift))
            )
            a, b = a - a.mean(1, keepdims=True), b - b.mean(1, keepdims=True)
            found.append(float((a * b).sum() / np.sqrt((a**2).sum() * (b**2).sum())))
        return float(np.median(found))

    assert likeness(1) > 0.8
    assert likeness(-1) < 0.5


def test_a_sequence_without_truth_says_so(tmp_path: Path) -> None:
    import zipfile

    bare = tmp_path / SAMPLE.name
    with zipfile.ZipFile(SAMPLE) as whole, zipfile.ZipFile(bare, "w") as part:
        for name in whole.namelist():
            if "ts_meas" not in name:
                part.writestr(name, whole.read(name))
    with pytest.raises(Error, match="with radar and truth"):
        read_drive(bare)


def test_fdtd_lines_are_stretched_in_length_and_time() -> None:
    """Spectra along and down shrink by the same number; a copy is the same again by its seed."""

    def scale_of(line: Line) -> float:
        return float(line.sample_interval / 2e-10)

    lines = [make_line(seed, "garage") for seed in seeds("copies")[:4]]
    again = make_line(seeds("copies")[0], "garage")
    np.testing.assert_array_equal(lines[0].traces, again.traces)
    for line in lines:
        assert 0.95 <= scale_of(line) <= 1.3
        assert line.beside == pytest.approx(0.06 * scale_of(line))
        assert line.length == pytest.approx(min(12.0, 10.0 * scale_of(line)), abs=0.01)


def test_the_package_works_without_the_networks(tmp_path: Path) -> None:
    """The folder is named nowhere outside of it, and can be taken out."""
    package = Path(gprodom.__file__).parent
    shutil.copytree(package, tmp_path / "gprodom", ignore=shutil.ignore_patterns("learned"))
    for path in (tmp_path / "gprodom").rglob("*.py"):
        assert "learned_" not in path.read_text(), path
        assert "gprodom.learned" not in path.read_text(), path
    code = "from gprodom.cli import build_parser; build_parser().parse_args(['run', '--help'])"
    done = run_program(sys.executable, "-c", code, PYTHONPATH=str(tmp_path))
    assert "gprodom_full" in done.stdout
    assert "--networks" not in done.stdout


def test_live_hears_one_antenna() -> None:
    """The first: motion is told by neighbouring traces of one."""
    heard = Silent()
    inference = Inference(heard, None, "DISPLACEMENT_IN")
    for utime, antenna in ((1, 3), (2, 0), (3, 3)):
        trace = packet("gpr_trace_t", utime=utime, antenna_id=antenna, samples=[7], num_samples=1)
        inference.take_trace("GPR_TRACE", trace)
    assert heard.traces == [(1, 1), (3, 1)]
