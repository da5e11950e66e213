"""Scores: against evo, against closed forms, against the reference figures of dead reckoning."""

import json
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure

from conftest import Cli, line
from gprodom import rotation
from gprodom.errors import Error
from gprodom.score.align import fit, fit_planar
from gprodom.score.associate import Pairs, associate
from gprodom.score.figures import FIGURE_NAMES, compare, errors, relative_errors
from gprodom.trajectory import Trajectory, read_tum, write_tum
from test_benchmark import write_csv

START = 1_700_001_000_123_456


def walk(seed: int, n: int = 400, planar: bool = False) -> Trajectory:
    """A smooth seeded path at 10 Hz with attitude."""
    rng = np.random.default_rng(seed)
    yaw = np.cumsum(rng.normal(0, 0.05, n))
    slope = np.zeros(n) if planar else np.cumsum(rng.normal(0, 0.01, n))
    step = 0.08 * np.stack([np.cos(yaw), np.sin(yaw), np.sin(slope)], axis=1)
    tilt = np.stack([np.cos(slope / 2), 0 * yaw, np.sin(slope / 2), 0 * yaw], axis=1)
    time = START + 100_000 * np.arange(n)
    position = np.cumsum(step, axis=0)
    return Trajectory(time, position, rotation.multiply(rotation.from_yaw(yaw), tilt))


def pair(seed: int, planar: bool = False, noise: float = 0.05) -> Pairs:
    """A truth and a turned, shifted, noisy estimate of it at the same stamps."""
    truth = walk(seed, planar=planar)
    jitter = np.random.default_rng(seed + 1).normal(0, noise, truth.position.shape)
    if planar:
        jitter[:, 2] = 0
    turned = truth.transformed(rotation.yaw_matrix(2.1), np.array([3.0, -7.0, 0.0]))
    return Pairs(Trajectory(truth.time, turned.position + jitter, turned.orientation), truth, 0)


def evo_path(trajectory: Trajectory) -> object:
    """The same as evo's trajectory; a truth of points gets identity attitude."""
    evo = pytest.importorskip("evo.core.trajectory")
    q = trajectory.orientation
    if q is None:
        q = np.tile([1.0, 0.0, 0.0, 0.0], (len(trajectory), 1))
    return evo.PoseTrajectory3D(trajectory.position, q, trajectory.seconds())


@pytest.mark.parametrize("seed", [1, 2, 3])
@pytest.mark.parametrize("alignment", ["none", "se3", "se2"])
def test_ate_equals_evo(seed: int, alignment: str) -> None:
    metrics = pytest.importorskip("evo.core.metrics")
    pairs = pair(seed, planar=alignment == "se2")  # SE(3) of planar data is SE(2)
    reference, estimate = evo_path(pairs.truth), evo_path(pairs.estimate)
    if alignment != "none":
        estimate.align(reference)  # type: ignore[attr-defined]
    ape = metrics.APE(metrics.PoseRelation.translation_part)
    ape.process_data((reference, estimate))
    expected = ape.get_statistic(metrics.StatisticsType.rmse)
    got = compare(pairs, alignment, 3.0).figures  # type: ignore[arg-type]
    assert got.ate_rmse_m == pytest.approx(expected, abs=1e-9)
    assert got.end_m == pytest.approx(ape.error[-1], abs=1e-9)


@pytest.mark.parametrize("attitude", [True, False])
def test_rpe_equals_evo(attitude: bool) -> None:
    metrics = pytest.importorskip("evo.core.metrics")
    pairs = pair(4)
    if not attitude:
        pairs = Pairs(pairs.estimate, Trajectory(pairs.truth.time, pairs.truth.position), 0)
    relation = metrics.PoseRelation
    rpe = metrics.RPE(
        relation.translation_part if attitude else relation.point_distance,
        delta=1.0,
        delta_unit=metrics.Unit.meters,
        pairs_from_reference=True,
    )
    rpe.process_data((evo_path(pairs.truth), evo_path(pairs.estimate)))
    assert relative_errors(pairs) == pytest.approx(rpe.error, abs=1e-9)


def test_se2_is_the_least_squares_solution() -> None:
    optimize = pytest.importorskip("scipy.optimize")
    pairs = pair(5)
    source, target = pairs.estimate.position, pairs.truth.position

    def residual(x: np.ndarray) -> np.ndarray:
        moved = source @ rotation.yaw_matrix(x[0]).T + np.array([x[1], x[2], 0.0])
        return (moved - target)[:, :2].ravel()

    best = optimize.least_squares(residual, [-2.0, 0.0, 0.0], xtol=1e-15, ftol=1e-15)
    got = errors(pairs, fit(pairs, "se2"), planar=True)
    assert np.sum(got**2) == pytest.approx(2 * best.cost, rel=1e-9)


def test_first_aligns_by_the_first_metres_alone() -> None:
    """A bend after 3 m moves the end, not the start; SE(2) over all spreads it."""
    x = np.linspace(0, 10, 401)
    truth = Trajectory(START + 10_000 * np.arange(401), np.stack([x, 0 * x, 0 * x], axis=1))
    bent = truth.position.copy()
    bent[x > 4, 1] += 0.1 * (x[x > 4] - 4)
    turned = Trajectory(truth.time, bent).transformed(rotation.yaw_matrix(1.0), np.ones(3))
    result = compare(Pairs(turned, truth, 0), "first", 3.0)
    assert result.error_m[x <= 4] == pytest.approx(0, abs=1e-9)
    assert result.figures.end_m == pytest.approx(0.6, abs=1e-9)
    assert result.figures.distance_pct == pytest.approx(
        6.0, rel=6e-3
    )  # distance counts in steps of 5 cm


def test_association_interpolates_and_leaves_out_gaps_and_ends() -> None:
    time = START + 100_000 * np.arange(100)
    time = time[(np.arange(100) < 40) | (np.arange(100) > 60)]  # 2.1 s without an estimate
    seconds = (time - START) * 1e-6
    estimate = Trajectory(time, np.stack([seconds, 2 * seconds, 0 * seconds], axis=1))
    stamps = START + np.array([-50_000, 25_000, 4_950_000, 9_800_000, 9_950_000])
    truth = Trajectory(
        np.concatenate([stamps, START + 130_000 + 100_000 * np.arange(20)]), np.zeros((25, 3))
    )
    truth = truth.select(np.argsort(truth.time))
    pairs = associate(estimate, truth)
    assert pairs.excluded == 3  # before the start, in the gap, after the end
    assert pairs.estimate.position[0] == pytest.approx([0.025, 0.05, 0])


def test_uncovered_truth_is_counted_and_reported(tmp_path: Path, cli: Cli) -> None:
    time = START + 100_000 * np.arange(201)  # 20 s at 0.5 m/s
    seconds = (time - START) * 1e-6
    truth = Trajectory(time, np.stack([0.5 * seconds, 0 * seconds, 0 * seconds], axis=1))
    late = truth.select(seconds >= 4.0)  # as after a start on the move
    write_tum(tmp_path / "truth.tum", truth)
    write_tum(tmp_path / "late.tum", late)
    printed = cli("score", tmp_path / "late.tum", tmp_path / "truth.tum", "--json")
    figures = json.loads(printed.out)
    assert (figures["excluded"], figures["n"]) == (40, 161)
    assert figures["excluded_s"] == pytest.approx(4.0, abs=0.11)
    assert figures["excluded_m"] == pytest.approx(2.0, abs=0.06)
    assert "does not cover 2.0 m of the truth's way (40 of 201 points, 4.0 s)" in printed.err
    write_tum(tmp_path / "nearly.tum", truth.select(seconds >= 1.0))
    printed = cli("score", tmp_path / "nearly.tum", tmp_path / "truth.tum")
    assert printed.err == ""
    assert "excluded_m (that the truth travels then)" in printed.out


def test_nees_of_errors_drawn_from_the_covariance() -> None:
    rng = np.random.default_rng(7)
    n = 4000
    truth = walk(8, n, planar=True)
    a = rng.normal(size=(n, 6, 6)) * 0.02
    covariance = a @ np.swapaxes(a, 1, 2) + 1e-4 * np.eye(6)
    draw = np.einsum("nij,nj->ni", np.linalg.cholesky(covariance), rng.normal(size=(n, 6)))
    draw[0] = 0  # the first pose places the truth
    assert truth.orientation is not None
    turn = rotation.multiply(rotation.from_yaw(draw[:, 5]), truth.orientation)
    estimate = Trajectory(truth.time, truth.position + draw[:, :3], turn, covariance)
    estimate = estimate.transformed(rotation.yaw_matrix(-0.7), np.array([1.0, 2.0, 3.0]))
    figures = compare(Pairs(estimate, truth, 0), "se2", 3.0).figures
    assert figures.nees_xy == pytest.approx(2, abs=4 * 2 / np.sqrt(n))  # 4 standard deviations
    assert figures.nees_yaw == pytest.approx(1, abs=4 * np.sqrt(2 / n))


def test_prism_lever_arm() -> None:
    body = walk(10, planar=True)
    lever = np.array([0.3, -0.2, 0.9])
    assert body.orientation is not None
    by_hand = [
        p + rotation.yaw_matrix(float(yaw)) @ lever
        for p, yaw in zip(body.position, rotation.yaw_of(body.orientation), strict=True)
    ]
    assert body.moved(lever).position == pytest.approx(np.array(by_hand), abs=1e-12)


def test_tum_round_trip_keeps_microseconds(tmp_path: Path) -> None:
    path = tmp_path / "a.tum"
    written = walk(11)
    write_tum(path, written)
    read = read_tum(path)
    assert np.array_equal(read.time, written.time)
    assert read.position == pytest.approx(written.position, abs=1e-9)
    assert read.orientation == pytest.approx(written.orientation, abs=1e-8)


@pytest.fixture
def files(tmp_path: Path) -> tuple[Path, Path]:
    """A TUM estimate and a ts_meas.csv truth of points, in frames of their own."""
    pairs = pair(12, planar=True)
    estimate, folder = tmp_path / "imu_wheel.tum", tmp_path / "1700000000-0-yard-cmu-gpr"
    folder.mkdir()
    write_tum(estimate, pairs.estimate)
    header, places = "Time[s],Px[m],Py[m],Pz[m]", [*pairs.truth.position.T]
    write_csv(folder / "ts_meas.csv", header, pairs.truth.time, places)
    return estimate, folder / "ts_meas.csv"


def test_command_prints_the_figures_and_writes_the_pictures(
    files: tuple[Path, Path], tmp_path: Path, cli: Cli, drawn: list[Figure]
) -> None:
    plots = tmp_path / "plots"
    figures = cli.json("score", *files, "--plot", plots)
    assert set(FIGURE_NAMES) <= set(figures)
    assert (figures["sequence"], figures["scene"]) == ("1700000000-0-yard-cmu-gpr", "yard")
    assert figures["ate_rmse_m"] == pytest.approx(0.05 * np.sqrt(2), rel=0.1)
    assert figures["nees_xy"] is None
    assert {path.name for path in plots.iterdir()} == {"trajectory.png", "error.png", "report.html"}
    above, error = (figure.axes[0] for figure in drawn)
    truth, estimate = line(above, "truth"), line(above, "estimate")
    off = np.linalg.norm(estimate - truth, axis=0)
    assert np.sqrt(np.mean(off**2)) == pytest.approx(figures["ate_rmse_m"], rel=0.01)
    np.testing.assert_allclose(error.get_lines()[0].get_ydata(), off, atol=1e-6)
    assert line(error, "RMS")[1, 0] == pytest.approx(figures["ate_rmse_m"])
    report = (plots / "report.html").read_text()
    assert report.count("data:image/png;base64,") == 2
    assert "http" not in report  # fetches nothing
    assert "ate_rmse_m" in cli("score", *files).out


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("hello\n", "not a kind that can be scored"),
        ("1.0 0 0 0 0 0 0 1\n2.0 0 0 0 0 0 0 1\n", "do not overlap"),
        ("1.0 0 0 0 0 0 0 1\n2.0 0 0 0 0 0 0\n", ":2: expected 8 numbers"),
    ],
)
def test_bad_input_ends_with_one_line(
    files: tuple[Path, Path], tmp_path: Path, cli: Cli, content: str, message: str
) -> None:
    bad = tmp_path / "bad.txt"
    bad.write_text(content)
    said = cli.error("score", bad, files[1])
    assert message in said
    assert said.count("\n") == 1


def test_standing_still_cannot_be_aligned() -> None:
    with pytest.raises(Error, match="does not move"):
        fit_planar(np.zeros((20, 3)), np.zeros((20, 3)))
