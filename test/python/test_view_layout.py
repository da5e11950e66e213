"""gprodom view and export --layout: what the panels tell where a viewer writes no figures."""

import json
from typing import Any

import numpy as np
import pytest

from gprodom import canvas
from gprodom.export.layout import layout
from gprodom.trajectory import Trajectory


@pytest.mark.parametrize(
    ("extent_m", "square_m"),
    [(0.0, 1), (20, 1), (21, 2), (99, 5), (101, 10), (900, 50), (5e4, 5000)],
)
def test_squares_of_a_grid_can_be_counted(extent_m: float, square_m: float) -> None:
    assert canvas.grid_square(extent_m) == square_m


def views(blueprint: Any) -> dict[str, Any]:
    """All views of a blueprint by origin."""
    found: dict[str, Any] = {}
    inside = [blueprint.root_container]
    while inside:
        each = inside.pop()
        if hasattr(each, "kind"):  # it holds others
            inside += each.contents
        else:
            found[str(each.origin)] = each
    return found


def test_panel_of_the_way_tells_the_side_of_its_squares() -> None:
    pytest.importorskip("rerun", reason="rerun-sdk (the extra view) is not installed")
    from gprodom.view.layout import for_live

    for far, square in ((5.0, 1), (300.0, 20)):
        way = views(for_live(np.array([[0.0, 0.0], [far, 1.0]])))["/way"]
        assert way.name == f"The way from above: squares of {square} m"
        assert way.properties["LineGrid3D"].spacing.as_arrow_array().to_pylist() == [square]


def test_axis_of_a_standard_deviation_has_a_figure_beside_0() -> None:
    pytest.importorskip("rerun", reason="rerun-sdk (the extra view) is not installed")
    from gprodom.view.layout import axis_top

    for largest in (0.05, 0.099, 0.7, 6.0, 51.0):
        top = axis_top(largest)
        decade = 10.0 ** np.floor(np.log10(largest))
        assert top is not None and 10 * decade < top < 12 * decade
    for largest in (0.013, 0.35, 1.9, 30.0, 0.0, np.inf, np.nan):  # the viewer's own does
        assert axis_top(largest) is None


@pytest.mark.parametrize(("length_m", "square_m"), [(8.0, 1), (1000.0, 50)])
def test_foxglove_tells_the_side_of_its_squares(length_m: float, square_m: int) -> None:
    places = np.array([[0.0, 0.0, 0.0], [length_m, 3.0, 0.0]])
    panel = layout(Trajectory(np.array([0, 1_000_000]), places))["configById"]["3D!way"]
    assert panel["foxglovePanelTitle"] == f"The way from above: squares of {square_m} m"
    grid = panel["layers"]["grid"]
    assert grid["size"] == square_m * grid["divisions"]
    assert grid["size"] / 2 > length_m  # centred on the origin, it reaches the end
    json.dumps(grid)
