"""A layout for Foxglove with the panels of `gprodom view`, for a file of `gprodom export --mcap`.

Foxglove's own format: settings of each panel by its name (KIND!NAME), and a tree that divides the
screen.
"""

from pathlib import Path
from typing import Any

import numpy as np

from gprodom import canvas
from gprodom.console import to_json
from gprodom.files import write_text
from gprodom.trajectory import Trajectory

BLUE, ORANGE, GREEN, PINK, AMBER, SKY = canvas.COLOURS[:6]
GREY = "#9a9a9a"
LINE_M = 0.03
FIELD_OF_VIEW_DEG = 45.0

PATHS = {
    "/gprodom/path": BLUE,
    "/gprodom/path_odom": GREEN,
    "/gprodom/path_wheel_gyro": ORANGE,
    "/gprodom/truth": GREY,
}
VARIANCE = "/gprodom/odometry_map.pose.covariance[{}].@sqrt"
CURVES: dict[str, dict[str, tuple[str, str]]] = {
    "Speed (m/s)": {
        "estimate": ("/gprodom/odometry_map.twist.twist.linear.x", BLUE),
        "wheel": ("/gprodom/speed/wheel.twist.linear.x", ORANGE),
        "radar, unsigned": ("/gprodom/speed/radar.twist.linear.x", GREEN),
    },
    "Position, standard deviation (m)": {
        "x": (VARIANCE.format(0), BLUE),
        "y": (VARIANCE.format(7), SKY),
    },
    "Heading, standard deviation (rad)": {"heading": (VARIANCE.format(35), GREEN)},
}
STATES = {
    "health (0 ok, 1 degraded, 2 failed)": "/diagnostics.status[0].level",
    "standing": "/gprodom/standing.data",
    "slipping": "/gprodom/slipping.data",
}


def layout(path: Trajectory) -> dict[str, Any]:
    """For a drive along `path`, which the camera looks at from above."""
    panels = {
        "3D!way": _way(path),
        "Image!ground": {"imageMode": {"imageTopic": "/gprodom/bscan"}},
        **{f"Plot!{i}": _plot(title, lines) for i, (title, lines) in enumerate(CURVES.items())},
        "StateTransitions!states": {
            "isSynced": True,
            "paths": [
                {"value": value, "label": label, "timestampMethod": "receiveTime"}
                for label, value in STATES.items()
            ],
        },
        "DiagnosticSummary!told": {
            "topicToRender": "/diagnostics",
            "minLevel": 0,
            "pinnedIds": [],
            "hardwareIdFilter": "",
            "sortByLevel": True,
        },
    }
    names = [
        "Image!ground",
        *(f"Plot!{i}" for i in range(len(CURVES))),
        "StateTransitions!states",
        "DiagnosticSummary!told",
    ]
    return {
        "configById": panels,
        "globalVariables": {},
        "userNodes": {},
        "playbackConfig": {"speed": 1},
        "layout": {
            "direction": "row",
            "first": "3D!way",
            "second": _stacked(names),
            "splitPercentage": 50,
        },
    }


def write_layout(file: Path, path: Trajectory) -> None:
    """As JSON."""
    write_text(file, to_json(layout(path)) + "\n")


def _stacked(names: list[str]) -> Any:
    """One above the other, of equal height."""
    if len(names) == 1:
        return names[0]
    return {
        "direction": "column",
        "first": names[0],
        "second": _stacked(names[1:]),
        "splitPercentage": 100 / len(names),
    }


def _plot(title: str, lines: dict[str, tuple[str, str]]) -> dict[str, Any]:
    paths = [
        {
            "value": value,
            "label": label,
            "color": colour,
            "enabled": True,
            "timestampMethod": "receiveTime",
        }
        for label, (value, colour) in lines.items()
    ]
    return {
        "title": title,
        "foxglovePanelTitle": title,
        "paths": paths,
        "xAxisVal": "timestamp",
        "showXAxisLabels": True,
        "showYAxisLabels": True,
        "showLegend": True,
        "legendDisplay": "left",  # beside the curves
        "isSynced": True,
        "sidebarDimension": 160,
    }


def _way(path: Trajectory) -> dict[str, Any]:
    low, high = (each(path.position[:, :2], axis=0) for each in (np.min, np.max))
    middle, extent = (low + high) / 2, float(np.max(high - low))
    square = canvas.grid_square(extent)
    squares = 2 * int(np.ceil((extent + 1) / square))
    topics: dict[str, Any] = {
        topic: {"visible": True, "type": "line", "lineWidth": LINE_M, "gradient": [colour] * 2}
        for topic, colour in PATHS.items()
    }
    topics["/gprodom/pose"] = {"visible": True, "showCovariance": True, "covarianceColor": SKY}
    topics["/gprodom/revisits"] = {"visible": True}
    grid = {
        "visible": True,
        "layerId": "foxglove.Grid",
        "instanceId": "grid",
        "label": f"{square:g} m",
        "size": squares * square,
        "divisions": squares,
        "color": "#808080ff",
        "position": [0, 0, 0],
        "rotation": [0, 0, 0],
        "frameId": "map",
    }
    return {
        "foxglovePanelTitle": f"The way from above: squares of {square:g} m",
        "followMode": "follow-none",
        "followTf": "map",
        "topics": topics,
        "layers": {"grid": grid},
        "cameraState": {
            "perspective": False,
            "phi": 0,
            "thetaOffset": 0,
            "distance": 1.2 * extent / np.tan(np.radians(FIELD_OF_VIEW_DEG / 2)) / 2 + 1,
            "target": [*middle, 0],
            "targetOffset": [*middle, 0],
            "targetOrientation": [0, 0, 0, 1],
            "fovy": FIELD_OF_VIEW_DEG,
            "near": 0.1,
            "far": 5000,
        },
    }
