"""What all pictures have in common: units, one scale for x and y, legends that cover nothing and
colours that are told apart."""

from pathlib import Path

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.colors import to_hex
from matplotlib.figure import Figure

from conftest import SAMPLE, run_cli
from gprodom import canvas

# Labels of counts and ratios, which have no unit; lanes have names in place of figures.
WITHOUT_UNIT = {"trace of the window", "1 - cosine", "level"}
COLOUR_MAPS = {"gray", "cividis", "viridis"}  # even in lightness, so seen by all and in print


def check_look(figure: Figure) -> None:
    """Fails where one of the figure's axes lacks something."""
    figure.draw_without_rendering()
    for axis in figure.axes:
        if not axis.axison:
            continue
        lanes = any(not text.get_text()[-1:].isdigit() for text in axis.get_yticklabels())
        labels = [axis.get_xlabel(), *([] if lanes else [axis.get_ylabel()])]
        if not is_bar(axis):
            shown = [label for label in labels if label]
            assert axis.get_ylabel() or lanes, axis.get_title()
            for label in shown:
                assert "(" in label or label in WITHOUT_UNIT, label
        for text in axis.get_legend_handles_labels()[1]:  # a curve with a unit of its own
            assert not text.endswith((" (m)", " (m/s)", " (s)", " (rad)", "(degrees)", "(°)")), text
        if axis.get_xlabel() == "x (m)":
            assert axis.get_ylabel() == "y (m)" and axis.get_aspect() in (1.0, "equal")
        legend = axis.get_legend()
        if legend is not None:
            box = legend.get_window_extent()
            for other in figure.axes:
                assert not overlap(box, other.get_window_extent()), axis.get_title()
            whole = figure.bbox
            assert box.x0 >= whole.x0 and box.x1 <= whole.x1 and box.y0 >= whole.y0, "cut off"
            for handle in legend.get_texts():
                assert handle.get_text()
        for line in axis.get_lines():
            colour = to_hex(line.get_color())
            assert is_told_apart(colour) and contrast_on_white(colour) > 1.6, line.get_label()
        for image in axis.get_images():
            assert image.get_cmap().name in COLOUR_MAPS


def is_bar(axis: Axes) -> bool:
    """A colour bar's."""
    return hasattr(axis, "_colorbar")


def overlap(one: object, other: object) -> bool:
    """Whether two boxes share more than a rim of a pixel."""
    a, b = np.array(one.extents), np.array(other.extents)  # type: ignore[attr-defined]
    return bool(np.all(np.minimum(a[2:], b[2:]) - np.maximum(a[:2], b[:2]) > 1.0))


def is_told_apart(colour: str) -> bool:
    """Of Okabe and Ito's palette, or grey."""
    known = {each.lower() for each in canvas.COLOURS}
    return colour.lower() in known or colour[1:3] == colour[3:5] == colour[5:7]


def contrast_on_white(colour: str) -> float:
    """As WCAG has it: 1 is not seen, 21 is black."""
    parts = np.array([int(colour[i : i + 2], 16) for i in (1, 3, 5)]) / 255
    linear = np.where(parts <= 0.04045, parts / 12.92, ((parts + 0.055) / 1.055) ** 2.4)
    return float(1.05 / (linear @ [0.2126, 0.7152, 0.0722] + 0.05))


@pytest.mark.parametrize("what", ["trajectory", "log", "revisits", "score"])
def test_pictures_of_a_drive(
    what: str, made_log: Path, tmp_path: Path, drawn: list[Figure]
) -> None:
    output = ["-o", tmp_path / "picture.png"]
    command = {
        "trajectory": ["plot", "trajectory", made_log, "--truth", made_log, *output],
        "log": ["plot", "log", made_log, *output],
        "revisits": ["plot", "revisits", made_log, *output],
        "score": ["score", made_log, made_log, "--plot", tmp_path / "score"],
    }[what]
    run_cli(*command)
    assert drawn
    for figure in drawn:
        check_look(figure)


@pytest.mark.usefixtures("compiled")
def test_picture_of_radar_windows(tmp_path: Path, drawn: list[Figure]) -> None:
    run_cli("plot", "radar", SAMPLE, "--at", "30", "-o", tmp_path / "a.png")
    check_look(drawn[0])


def test_a_legend_on_the_curves_and_two_units_on_one_axis_are_found() -> None:
    """The check itself."""
    figure, (axis,) = canvas.new_figure()
    axis.plot([0, 1], [0, 1], color=canvas.COLOURS[0], label="a curve")
    axis.set_xlabel("time (s)")
    axis.set_ylabel("speed (m/s)")
    canvas.legend_below(axis, 1)
    check_look(figure)
    axis.legend(loc="best")
    with pytest.raises(AssertionError):
        check_look(figure)
    axis.plot([0, 1], [1, 0], color=canvas.COLOURS[1], label="heading (°)")
    canvas.legend_below(axis, 1)
    with pytest.raises(AssertionError, match="heading"):
        check_look(figure)


def test_lines_of_many_are_seen_and_told_apart() -> None:
    styles = [canvas.line_style(i, 35) for i in range(35)]
    assert len({(each["color"], str(each["linestyle"])) for each in styles}) == 35
    assert min(contrast_on_white(each["color"]) for each in styles) > 2.0
