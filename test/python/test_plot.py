"""Pictures: the data that they show, and that they are drawn."""

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure

from conftest import SAMPLE, Cli, line, run_cli
from gprodom import canvas
from gprodom.benchmark.curves import Curves
from gprodom.benchmark.pictures import paths_figure, time_figure
from gprodom.config import STANDARD
from gprodom.convert.cmu import read_recording
from gprodom.lcm import logs
from gprodom.plot.radar import make_windows
from gprodom.plot.revisits import Revisits, find_revisits, revisits_figure
from gprodom.score.pictures import draw_paths
from gprodom.trajectory import Trajectory
from packets import packet, pose, write_events


@pytest.mark.usefixtures("compiled")
def test_radar_picture(tmp_path: Path, cli: Cli, drawn: list[Figure]) -> None:
    out = tmp_path / "radar.png"
    cli("plot", "radar", SAMPLE, "--at", "30", "-o", out)
    [figure] = drawn
    raw, kept, trace, matrix, later, match, _ = figure.axes
    traces = read_recording(SAMPLE).traces
    first = int(np.searchsorted(np.arange(len(traces)) / 20, 30))
    shown = raw.get_images()[0].get_array().T  # the window less the mean of what is about it
    window = traces[first : first + 100]
    assert np.corrcoef(np.diff(shown, axis=0).ravel(), np.diff(window, axis=0).ravel())[0, 1] > 0.99
    assert len(kept.get_lines()[0].get_xdata()) > 100  # a peak a trace and more
    np.testing.assert_allclose(
        trace.get_lines()[0].get_xdata(), kept.get_images()[0].get_array().T[50]
    )
    assert matrix.get_images()[0].get_array().any()
    assert (matrix.get_images()[0].get_array() != later.get_images()[0].get_array()).any()
    shifts, distances = np.array(match.get_lines()[0].get_data())
    assert line(match, "shift")[0, 0] == shifts[np.nanargmin(distances)]
    assert "too early" in cli.error("plot", "radar", SAMPLE, "--at", "3000", "-o", out, code=2)


@pytest.mark.usefixtures("compiled")
def test_windows_of_one_stream_differ_by_the_step() -> None:
    """A reflector that slopes: its cells move by the new traces from window to window."""
    from gprodom import gpr

    time, place = np.arange(160), np.arange(900)
    depth = 90 + 25 * np.sin(2 * np.pi * place / 160)
    pulse = (time - depth[:, None]) / 5.0
    traces = 3000 * np.cos(2.2 * pulse) * np.exp(-(pulse**2) / 2)
    traces = traces + np.random.default_rng(1).normal(0, 20, traces.shape)
    one, two = make_windows(traces, 2e-10, 700, 100, 20)
    assert one.matrix.any()
    match, _ = gpr.align_sfm(one.matrix, two.matrix)
    assert match.shift == -10  # 20 of 100 traces, 50 columns
    np.testing.assert_array_equal(one.kept[20:], two.kept[:-20])


def revisit_log(path: Path) -> None:
    events = []
    for utime, angle in zip(1_000_000 * np.arange(100), np.arange(100) / 8, strict=True):
        sent = pose(int(utime), np.cos(angle), np.sin(angle), 1.0)
        events.append((int(utime), "ODOMETRY_MAP", sent))
    for end, kind, valid, mirrored in (
        (60, 2, True, False),
        (70, 2, True, True),
        (80, 2, False, False),
        (90, 1, True, False),
    ):
        utime = 1_000_000 * end
        times = {"utime": utime, "utime_from": utime - 50_000_000, "utime_to": utime}
        told = {"kind": kind, "valid": valid, "mirrored": mirrored, "distance": 0.02}
        sent = packet("displacement_t", source="revisit", **times, **told)
        events.append((utime, "GPR_DISPLACEMENT", sent))
    write_events(path, events)


def test_revisits_are_the_valid_ones(tmp_path: Path, cli: Cli, drawn: list[Figure]) -> None:
    revisit_log(tmp_path / "out.lcmlog")
    found = find_revisits(logs.read_roles(tmp_path / "out.lcmlog", STANDARD.of("displacement")))
    assert found.end.tolist() == [60_000_000, 70_000_000]
    assert found.mirrored.tolist() == [False, True]
    picture = tmp_path / "revisits.png"
    counted = cli.json("plot", "revisits", tmp_path / "out.lcmlog", "-o", picture)
    assert counted == {"revisits": 2, "mirrored": 1, "corrections": 0}
    [figure] = drawn
    assert picture.is_file()
    above, pairs, apart, _ = figure.axes
    path = np.array(above.get_lines()[0].get_data())
    np.testing.assert_allclose(path, [np.cos(np.arange(100) / 8), np.sin(np.arange(100) / 8)])
    for label, now, then in (("as then", 60, 10), ("mirrored", 70, 20)):
        # From the place seen first to that of now; and along time.
        np.testing.assert_allclose(line(above, label), path[:, [then, now]])
        np.testing.assert_allclose(line(pairs, label), [[now], [then]])
    gaps = [float(each.get_ydata()[0]) for each in apart.get_lines()]
    assert gaps == pytest.approx([2 * np.sin(50 / 16)] * 2, abs=1e-9)


def test_lines_of_paths_and_errors_differ_without_colour_and_do_not_hide_each_other() -> None:
    """Of equal curves the later is thinner, and each has dashes of its own."""
    time = 1_700_000_000_000_000 + 100_000 * np.arange(50)
    path = Trajectory(time, np.stack([np.arange(50.0), np.zeros(50), np.zeros(50)], axis=1))
    _, (axis,) = canvas.new_figure()
    draw_paths(axis, path.position, dict.fromkeys("abcd", path))
    grows, straight = [1.0, 2.0, 3.0], [[0.0, 0.0], [1.0, 0.0]]
    curves = Curves(grows, grows, grows, grows, [None], straight, straight)
    each = dict.fromkeys("abcd", curves)
    drawn = [axis, paths_figure(each, list(each), "equal").axes[0]]
    over_time = time_figure({"1-0-yard-cmu-gpr": each}, ["yard"], list(each))
    assert over_time is not None
    drawn.append(over_time.axes[0])
    for one in drawn:
        lines = [each_line for each_line in one.get_lines() if each_line.get_label() in each]
        assert len(lines) == 4
        assert len({str(dashed._unscaled_dash_pattern) for dashed in lines}) == 4
        widths = [each_line.get_linewidth() for each_line in lines]
        assert all(a > b + 0.2 for a, b in pairwise(widths)), widths


@pytest.fixture
def tum(tmp_path: Path) -> Path:
    """A bend of twelve poses."""
    path = tmp_path / "wheel.tum"
    rows = [f"{1.7e9 + i:.1f} {i} {0.1 * i * i} 0 0 0 0 1" for i in range(12)]
    path.write_text("\n".join(rows) + "\n")
    return path


@pytest.mark.parametrize(
    ("ending", "begins"),
    [(".png", b"\x89PNG"), (".svg", b"<?xml"), (".pdf", b"%PDF"), ("", b"\x89PNG")],
)
def test_a_picture_is_what_its_ending_says(
    ending: str, begins: bytes, tum: Path, tmp_path: Path
) -> None:
    path = tmp_path / f"path{ending}"
    made = []
    for _ in range(2):  # equal data give equal files
        run_cli("plot", "trajectory", tum, "-o", path)
        made.append(path.read_bytes())
    assert made[0].startswith(begins) and made[0] == made[1]


def test_a_picture_of_another_ending_is_refused(tum: Path, tmp_path: Path, cli: Cli) -> None:
    assert "ending in .png, .svg, .pdf" in cli.error(
        "plot", "trajectory", tum, "-o", tmp_path / "path.txt", code=2
    )
    assert list(tmp_path.iterdir()) == [tum]


def test_a_legend_shows_names_and_not_files(
    tum: Path, tmp_path: Path, drawn: list[Figure], cli: Cli
) -> None:
    other = tmp_path / "1700000000-0-yard.tum"
    other.write_bytes(tum.read_bytes())
    line_of = ["plot", "trajectory", str(tum), str(other), "-o", str(tmp_path / "path.png")]
    for more, names in (([], ["wheel", "estimate 2"]), (["--labels", "a, b"], ["a", "b"])):
        cli(*line_of, *more)
        legend = drawn[-1].axes[0].get_legend()
        assert legend is not None
        assert [text.get_text() for text in legend.get_texts()] == names
    assert "expected 2 different names" in cli.error(*line_of, "--labels", "a", code=2)


@pytest.mark.parametrize("most", [1.1, 3.0, 40.0, 1e5])
def test_ticks_of_logarithmic_axes_read_as_numbers(most: float) -> None:
    figure, (axis,) = canvas.new_figure()
    axis.plot([0.5, 20], [0.6, 0.6 * most])
    canvas.log_scales(axis, "x", "y")
    canvas.png(figure)
    for one in (axis.xaxis, axis.yaxis):
        low, high = one.get_view_interval()
        shown = [tick.get_text() for tick in one.get_ticklabels(which="both") if tick.get_text()]
        inside = [value for value in map(float, shown) if low <= value <= high]
        assert len(inside) >= 2, shown
        assert not any("$" in text for text in shown)


def test_revisits_of_earlier_drives_are_counted_beside_those_drawn() -> None:
    time = 1_700_000_000_000_000 + 1_000_000 * np.arange(10)
    path = Trajectory(time, np.column_stack([np.arange(10.0), np.zeros(10), np.zeros(10)]))
    start = np.array([time[0] - 10**9, time[1]])
    found = Revisits(start, time[[5, 6]], np.zeros(2), np.zeros(2, bool))
    figure = revisits_figure(path, found, None, "drive")
    assert figure.axes[0].get_title() == "places known again (1 more of earlier drives)"
    for axis in figure.axes[1:]:
        assert axis.get_xlim() == (0.0, 9.0)
