"""The benchmark on two small sequences, and the fit of K."""

import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure

import gprodom
from conftest import Cli, rows_of, run_cli
from gprodom.benchmark.jobs import Outcome, Sequence, Settings, fit_on_others, shifts_path
from gprodom.benchmark.page import write_report
from gprodom.benchmark.pairs import compare_methods, interval
from gprodom.benchmark.simulated import drives
from gprodom.calibrate.k import Fit, Shifts, fit_k
from gprodom.errors import Error, UsageError
from gprodom.odometry.methods import METHODS
from gprodom.score.figures import Figures
from gprodom.score.record import COLUMNS, Record, make_record
from gprodom.trajectory import read_tum


def write_csv(path: Path, header: str, time: np.ndarray, columns: list[np.ndarray]) -> None:
    rows = [
        f"{t // 1_000_000}.{t % 1_000_000:06d},"
        + ",".join(f"{column[i]:.9g}" for column in columns)
        for i, t in enumerate(time.tolist())
    ]
    path.write_text("\r\n".join([header, *rows, ""]))


def make_sequence(folder: Path, wheel_scale: float = 1.0) -> Path:
    """2 s of standstill, then 8 m at 0.5 m/s on a circle of 4 m radius."""
    folder.mkdir(parents=True)
    time = 1_700_000_000_000_000 + np.arange(0, 18_000_000, 20_000)
    seconds = (time - time[0]) * 1e-6
    travelled = 0.5 * np.maximum(seconds - 2, 0)
    rate = np.where(seconds > 2, 0.125, 0.0)
    zero = 0 * seconds
    angle = travelled / 4
    imu = [zero, zero, zero + 9.81, zero, zero, rate]
    write_csv(folder / "imu_meas.csv", "t,a_x,a_y,a_z,g_x,g_y,g_z", time, imu)
    write_csv(folder / "we_odom_meas.csv", "Time[s],Range[m]", time, [wheel_scale * travelled])
    position = [p[::5] for p in (4 * np.sin(angle), 4 - 4 * np.cos(angle), zero)]
    write_csv(folder / "ts_meas.csv", "Time[s],Px[m],Py[m],Pz[m]", time[::5], position)
    traces = [np.round(zero[::5] + i) for i in range(12)]
    write_csv(folder / "gpr_meas.csv", "t," + ",".join("a" * 12), time[::5], traces)
    return folder


def test_benchmark_resumes_and_survives_a_broken_sequence(tmp_path: Path, cli: Cli) -> None:
    good = make_sequence(tmp_path / "1700000000-0-yard-cmu-gpr", wheel_scale=1.02)
    broken = make_sequence(tmp_path / "1700001000-0-yard-cmu-gpr")
    (broken / "imu_meas.csv").write_text("t,a\n1.0,x\n")
    out = tmp_path / "out"
    arguments = ["benchmark", good, broken, "--methods", "wheel", "-o", out, "-j2"]
    printed = cli(*arguments, "--json", code=1)
    assert "1700001000-0-yard-cmu-gpr" in printed.err
    result = json.loads(printed.out)
    assert [record["sequence"] for record in result["records"]] == [good.name]
    assert result["failures"][0]["sequence"] == broken.name
    assert result == json.loads((out / "results.json").read_text())
    row, *_ = rows_of(out / "results.csv")
    assert tuple(row) == COLUMNS
    assert (row["scene"], row["nees_xy"]) == ("yard", "")
    # 2 % of wheel scale over 8 m on a curve: centimetres, and 8.16 m of path.
    assert 0.01 < float(row["ate_rmse_m"]) < 0.1
    tum = out / good.name / "wheel.tum"
    steps = np.linalg.norm(np.diff(read_tum(tum).position, axis=0), axis=1)
    assert steps.sum() == pytest.approx(8.16, rel=0.01)
    assert "1700000000" in (out / "report.html").read_text()
    assert not list(out.rglob("*.lcmlog"))  # what only the work needed is gone

    before = tum.stat().st_mtime_ns
    cli(*arguments, code=1)
    assert tum.stat().st_mtime_ns == before  # went on, did not do it again
    cli(*arguments, "--align", "none", code=1)
    assert tum.stat().st_mtime_ns != before  # what changed is run again


# Stands in for gprodom-replay: sees 2 m travelled as 100 columns of shift, forwards; dec fails.
STAND_IN = """#!{python}
import argparse, sys
import numpy as np
from gprodom.lcm import logs
from gprodom.odometry.dead_reckoning import wheel_distance
from gprodom.lcm import EventLog
from gprodom.lcm.messages import message

parser = argparse.ArgumentParser()
parser.add_argument("log")
parser.add_argument("-c")
parser.add_argument("-o")
parser.add_argument("--smoothed")
parser.add_argument("--stats")
parser.add_argument("--set", action="append", default=[])
parser.add_argument("--progress", action="store_true")
args = parser.parse_args()
keys = dict(pair.split("=") for pair in args.set)
print("progress 0.5", file=sys.stderr)
if keys["gpr.front_end"] == "dec":
    print("error: no such front end", file=sys.stderr)
    sys.exit(1)
time, distance = wheel_distance(logs.read_roles(args.log, {{"wheel": "WHEEL"}}))
out = EventLog(args.o, "w", overwrite=True)
for i in range(0, len(time) - 25, 25):
    sent = message("displacement_t")()
    sent.utime_from, sent.utime_to, sent.utime = int(time[i]), int(time[i + 25]), int(time[i + 25])
    sent.source, sent.kind, sent.valid = keys["gpr.front_end"], 0, True
    shift = (distance[i + 25] - distance[i]) / 0.02
    sent.distance = float(keys["paper.k"]) * shift
    out.write_event(sent.utime, "GPR_DISPLACEMENT", sent.encode())
for t, x in zip(time.tolist(), distance.tolist()):
    sent = message("odometry_t")()
    sent.utime, sent.position, sent.orientation = t, [x, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0]
    sent.pose_covariance = np.eye(6).ravel().tolist()
    out.write_event(t, "ODOMETRY_MAP", sent.encode())
if args.smoothed:
    with open(args.smoothed, "w") as tum:
        for t, x in zip(time.tolist()[::40], distance.tolist()[::40]):
            tum.write(f"{{t * 1e-6:.6f}} {{x}} 0 0 0 0 0 1\\n")
with open(args.stats, "w") as stats:
    stats.write('{{"antennas": {{}}}}')
"""


@pytest.fixture
def stand_in(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    program = tmp_path / "build" / "bin" / "gprodom-replay"
    program.parent.mkdir(parents=True)
    program.write_text(STAND_IN.format(python=sys.executable))
    program.chmod(0o755)
    monkeypatch.setattr("gprodom.odometry.replay.find_program", lambda: program)
    monkeypatch.setattr("gprodom.benchmark.jobs.find_program", lambda: program)
    config = tmp_path / "gprodom.yaml"
    config.write_text("")
    monkeypatch.setattr("gprodom.config.default_config", lambda: config)
    scripts = Path(gprodom.__file__).resolve().parents[1]
    monkeypatch.setenv("PYTHONPATH", str(scripts))


@pytest.mark.usefixtures("stand_in")
def test_k_is_fitted_on_the_others_and_used(tmp_path: Path, cli: Cli) -> None:
    sources = [str(make_sequence(tmp_path / f"170000{i}000-0-yard-cmu-gpr")) for i in range(2)]
    out = tmp_path / "out"
    arguments = ["benchmark", *sources, "--methods", "gpr_sfm,sfm,dec", "-o", str(out), "--json"]
    printed = cli(*arguments, code=1)
    result = json.loads(printed.out)
    fitted = {(k["method"], round(k["k"], 4)) for k in result["k"]}
    assert fitted == {("gpr_sfm", 0.02), ("sfm", 0.02)}
    found = {record["method"]: record["ate_rmse_m"] for record in result["records"]}
    assert set(found) == {"gpr_sfm", "sfm"}
    modes = {(record["method"], record["mode"]) for record in result["records"]}
    assert modes == {("gpr_sfm", "causal"), ("sfm", "causal"), ("sfm", "smoothed")}
    assert len(read_tum(out / Path(sources[0]).name / "sfm.smoothed.tum")) > 10
    assert found["gpr_sfm"] < 0.02  # a perfect radar on a perfect gyro
    assert [failure["method"] for failure in result["failures"]] == ["dec", "dec"]
    assert "error: no such front end" in printed.err


@pytest.mark.usefixtures("stand_in")
def test_calibrate_k_and_observability(tmp_path: Path, cli: Cli, drawn: list[Figure]) -> None:
    source = str(make_sequence(tmp_path / "1700000000-0-yard-cmu-gpr"))
    fit = cli.json("calibrate", "k", source, "--method", "sfm")
    assert fit["k"] == pytest.approx(0.02, rel=0.01)
    assert fit["key"] == "paper.k"
    out = tmp_path / "out"
    seen = cli.json("plot", "observability", source, "-o", out)
    assert seen == json.loads((out / "observability.json").read_text())
    assert set(seen) == {"sfm", "trace_count"}
    [figure] = drawn
    assert [axis.get_title().split(":")[0] for axis in figure.axes] == ["sfm", "trace_count"]
    for axis, found in zip(figure.axes, seen.values(), strict=True):
        displacement, shift = np.array(axis.get_lines()[0].get_data())
        assert len(shift) == found["windows"]
        # The stand-in sees every metre as 50 columns.
        np.testing.assert_allclose(shift, 50 * displacement, rtol=0.02, atol=1.0)


def shifts(rng: np.random.Generator, k: float, n: int = 300) -> Shifts:
    """Backward and forward windows of K k, 5 mm noise, a tenth of them wildly wrong."""
    shift = rng.uniform(-20, 20, n)
    distance = np.abs(k * shift + rng.normal(0, 0.005, n))
    distance[::10] += 2.0
    distance[1] = np.nan
    return Shifts(np.arange(n), np.arange(n) + 1, shift, distance)


def test_k_is_robust() -> None:
    fit = fit_k([shifts(np.random.default_rng(1), 0.03), shifts(np.random.default_rng(2), 0.03)])
    assert fit.k == pytest.approx(0.03, rel=0.02)
    assert fit.n == 598


def test_k_needs_shifts() -> None:
    still = Shifts(np.arange(50), np.arange(50) + 1, np.zeros(50), np.zeros(50))
    with pytest.raises(Error, match="K cannot be fitted"):
        fit_k([still])


def test_edited_code_runs_the_jobs_again(tmp_path: Path) -> None:
    """Of a copy of the package, edited between two runs."""
    sequence = make_sequence(tmp_path / "1700000000-0-yard-cmu-gpr", wheel_scale=1.02)
    package = tmp_path / "scripts" / "gprodom"
    shutil.copytree(Path(gprodom.__file__).parent, package)
    out = tmp_path / "out"
    command = [sys.executable, "-m", "gprodom", "benchmark", str(sequence), "--methods", "wheel"]
    environment = {**os.environ, "PYTHONPATH": str(package.parent)}
    environment["GPRODOM_BUILD"] = str(gprodom._build)

    def run_benchmark() -> tuple[int, int | None]:
        arguments = [*command, "-o", str(out), "-j1"]
        subprocess.run(arguments, env=environment, cwd=tmp_path, check=True, capture_output=True)
        [record] = json.loads((out / "results.json").read_text())["records"]
        return (out / sequence.name / "wheel.tum").stat().st_mtime_ns, record["map_jumps"]

    made, jumps = run_benchmark()
    assert jumps is None
    view = package / "status" / "view.py"
    view.write_text(view.read_text() + "# no figure comes of this\n")
    assert run_benchmark() == (made, jumps)
    scoring = package / "score" / "record.py"
    text = scoring.read_text()
    scoring.write_text(text.replace("map_jumps=jumps.count if jumps else None", "map_jumps=7"))
    made_anew, jumps = run_benchmark()
    assert made_anew > made
    assert jumps == 7


def with_shifts(folder: Path, name: str, found: Shifts) -> Sequence:
    """A sequence whose shifts have been measured."""
    sequence = Sequence(f"{name}-cmu-gpr", folder, folder / name, 2e-10)
    sequence.folder.mkdir()
    np.savez(shifts_path(sequence, "sfm"), key="", **vars(found))
    return sequence


def test_k_comes_from_the_other_sequences(tmp_path: Path) -> None:
    rng = np.random.default_rng(3)
    sequences = [
        with_shifts(tmp_path, f"{i}-0-yard", shifts(rng, k))
        for i, k in enumerate([0.1, 0.03, 0.03])
    ]
    fit, fitted_on = fit_on_others(sequences[0], METHODS["sfm"], sequences[1:])
    assert fitted_on == (sequences[1].name, sequences[2].name)
    assert fit.k == pytest.approx(0.03, rel=0.02)
    with pytest.raises(Error, match="no other sequence"):
        fit_on_others(sequences[0], METHODS["sfm"], [])


def test_k_of_a_lone_scene_comes_from_the_others(tmp_path: Path) -> None:
    """Two simulated drives are of two scenes: each has its K from the other. So has one whose scene
    has too few windows with an answer."""
    rng = np.random.default_rng(3)
    yard, hall, again, sparse = (
        with_shifts(tmp_path, name, shifts(rng, 0.03, n))
        for name, n in (("1-0-yard", 300), ("2-0-hall", 300), ("3-0-hall", 300), ("4-0-yard", 5))
    )

    def fitted_on(sequence: Sequence, *others: Sequence) -> tuple[str, ...]:
        return fit_on_others(sequence, METHODS["sfm"], list(others))[1]

    assert fitted_on(yard, hall) == (hall.name,)
    assert fitted_on(hall, yard, again) == (again.name,)
    assert fitted_on(yard, hall, again, sparse) == (hall.name, again.name, sparse.name)


def test_the_report_says_on_what_k_was_fitted(tmp_path: Path) -> None:
    names = ("1-0-yard-cmu-gpr", "2-0-hall-cmu-gpr", "3-0-hall-cmu-gpr")
    sequences = [Sequence(name, tmp_path, tmp_path / name, None) for name in names]
    for sequence in sequences:
        sequence.source.mkdir(exist_ok=True)
    fit = Fit(0.02, 300, 0.01)
    outcomes = [
        Outcome(names[0], "sfm", k=fit, fitted_on=names[1:]),
        Outcome(names[1], "sfm", k=fit, fitted_on=names[2:]),
    ]
    page = tmp_path / "report.html"
    records = [record(names[0], "sfm", 0.1)]
    write_report(page, sequences, outcomes, records, Settings((), (), "se2", 3.0))
    text = page.read_text()
    assert "other scenes (hall), 2 sequences: its own has no other" in text
    assert "its own scene, 1 sequences" in text
    # What is looked for first is not at the far edge of a wide table.
    header = text.split("<tr>")[1].split("</tr>")[0]
    assert re.findall("<th.*?>(.*?)</th>", header)[:3] == ["method", "mode", "mean ATE (m)"]


def test_unknown_method_is_bad_usage(tmp_path: Path, cli: Cli) -> None:
    sequence = make_sequence(tmp_path / "1700000000-0-yard-cmu-gpr")
    methods = ["--methods", "wheel,magic", "-o", tmp_path / "out"]
    assert "magic" in cli.error("benchmark", sequence, *methods, code=2)


def record(sequence: str, method: str, error: float) -> Record:
    figures = Figures(error, None, error, None, None, None, 100, 0, 0.0, 0.0, 30.0)
    return make_record(sequence, method, "causal", "se2", figures)


def test_methods_differ_only_if_their_interval_excludes_zero() -> None:
    rng = np.random.default_rng(4)
    records = []
    for i in range(40):
        hard = rng.uniform(0.1, 1.0)  # sequences differ far more than methods: pairing matters
        for method, offset in (("a", 0.0), ("b", 0.02), ("c", 0.0)):
            error = hard + offset + rng.normal(0, 0.02)
            records.append(record(f"{i}-0-yard-cmu-gpr", method, error))
    pairs = {(p.method, p.other): p for p in compare_methods(records)}
    assert pairs["a", "b"].verdict == "a better"
    assert pairs["a", "b"].low_m < -0.02 < pairs["a", "b"].high_m
    assert pairs["b", "c"].verdict == "c better"
    assert pairs["a", "c"].verdict == "no difference shown"
    assert compare_methods(records[:12]) == []  # four sequences say nothing


def test_bootstrap_interval_covers() -> None:
    """Of intervals on 30 normal draws some 93 % hold the mean (the percentile method's own)."""
    rng = np.random.default_rng(5)
    intervals = [interval(rng.normal(1.0, 1.0, 30)) for _ in range(300)]
    assert 0.88 < np.mean([low <= 1.0 <= high for low, high in intervals]) < 0.98


def test_report_says_what_is_of_other_data(tmp_path: Path) -> None:
    ours = make_sequence(tmp_path / "1700000000-0-gates_g-cmu-gpr")
    theirs = make_sequence(tmp_path / "1700001000-0-nsh_b-cmu-gpr")
    (theirs / "camera").mkdir()
    for sources, said in (([ours, theirs], True), ([theirs], False)):
        out = tmp_path / f"out{said}"
        arguments = ["benchmark", *map(str, sources), "--methods", "wheel", "-o", str(out), "-j1"]
        run_cli(*arguments)
        page = (out / "report.html").read_text()
        assert ("MEASURED ON OTHER DATA: 1 of 2" in page) == said
        assert "0.568" in page  # the published mean stands beside
        assert page.count("<img") == page.count('src="data:image/png;base64,') >= 4


def test_simulated_sequences_are_the_same_again(tmp_path: Path) -> None:
    made = drives(2, 7, ("rays",), 4.0)
    assert [drive.name for drive in made] == [f"170000000{i}-0-rays-cmu-gpr" for i in (7, 8)]
    logs_made = [drive.make(tmp_path) for drive in made]
    first = logs_made[0].read_bytes()
    logs_made[0].unlink()
    assert drives(1, 7, ("rays",), 4.0)[0].make(tmp_path).read_bytes() == first
    assert logs_made[1].read_bytes() != first
    kept = logs_made[1].stat().st_mtime_ns
    assert made[1].make(tmp_path).stat().st_mtime_ns == kept  # it is there
    assert drives(1, 8, ("rays",), 6.0)[0].make(tmp_path).stat().st_mtime_ns > kept  # another one
    with pytest.raises(UsageError, match="rays"):
        drives(1, 7, ("moon",), 4.0)
