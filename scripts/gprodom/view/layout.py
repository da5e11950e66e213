"""Which views there are, where they stand, and what they show from the start."""

from typing import Any

import numpy as np

from gprodom import canvas
from gprodom.arrays import Floats
from gprodom.drive.doubt import position_sigma, yaw_sigma
from gprodom.drive.log import Drive
from gprodom.view import ground
from gprodom.view.record import TIMELINE, WAY, load_rerun

SPEED = "Speed (m/s): estimate blue, wheel orange, radar (unsigned) green, IMU over 1 s pink"
SIGMAS = {
    "/sigma/position": "Position, standard deviation (m)",
    "/sigma/heading": "Heading, standard deviation (°)",
}
MOST_TICKS = 3.5  # for which a low panel has room
ABOVE_TICK = 1.15  # the figure at the very end of an axis is not drawn
LIVE_COLUMNS = 1600.0  # of the radargram along the way that are in sight


def for_drive(drive: Drive, earlier: Floats | None, way_columns: float) -> Any:
    """For a log. earlier: ground of a map (n, 2), m; way_columns: of the radargram along the way, 0
    where there is none."""
    places = drive.path.position[:, :2]
    if earlier is not None:
        places = np.concatenate([places, earlier[np.isfinite(earlier).all(axis=1)]])
    reckoned = drive.dead_reckoning
    if reckoned is not None:  # as far as it is near; it may be anywhere
        room = np.ptp(places, axis=0).max() / 2
        low, high = places.min(axis=0) - room, places.max(axis=0) + room
        places = np.concatenate([places, np.clip(reckoned.position[:, :2], low, high)])
    span = int(drive.path.time[0]), int(drive.path.time[-1])
    largest = (position_sigma(drive.path).max(), np.degrees(yaw_sigma(drive.path).max()))
    tops = {
        origin: top
        for origin, most in zip(SIGMAS, largest, strict=True)
        if (top := axis_top(float(most))) is not None
    }
    return _blueprint(places.min(axis=0), places.max(axis=0), way_columns, span, tops)


def axis_top(largest: float) -> float | None:
    """Where an axis ends that begins at 0; None: where the viewer would end it. It labels powers of
    ten and, where there is room, their multiples: an axis to 0.08 has no figure but its 0, so it
    goes on beyond 0.1."""
    if not 0 < largest < np.inf:
        return None
    decade = 10.0 ** np.floor(np.log10(largest))
    return None if largest <= MOST_TICKS * decade else float(ABOVE_TICK * 10 * decade)


def for_live(earlier: Floats | None) -> Any:
    """For what comes: some metres about the start, or the map."""
    known = np.zeros((0, 2)) if earlier is None else earlier[np.isfinite(earlier).all(axis=1)]
    places = np.concatenate([known, [[-5.0, -5.0], [5.0, 5.0]]])
    return _blueprint(places.min(axis=0), places.max(axis=0), LIVE_COLUMNS, None, {})


def _blueprint(
    low: Floats,
    high: Floats,
    way_columns: float,
    span_us: tuple[int, int] | None,
    tops: dict[str, float],
) -> Any:
    """For a way within `low` to `high` (2,), m, whose radargram has `way_columns` columns (0: there
    is none). span_us: of time, where it is known; None: live. tops: of the curves of an origin,
    where they are known; those begin at 0."""
    load_rerun()
    import rerun.blueprint as rrb

    so_far = rrb.VisibleTimeRange(
        TIMELINE,
        start=rrb.TimeRangeBoundary.infinite(),
        end=rrb.TimeRangeBoundary.cursor_relative(),
    )
    middle = (low + high) / 2
    extent = float(np.max(high - low))
    above = 1.1 * extent + 1.0
    square = canvas.grid_square(extent)
    eye = rrb.EyeControls3D(
        kind=rrb.Eye3DKind.Orbital,
        position=[middle[0], middle[1] - 0.02 * above, above],
        look_target=[middle[0], middle[1], 0.0],
        eye_up=[0.0, 1.0, 0.0],
    )
    way = rrb.Spatial3DView(
        origin=WAY,
        name=f"The way from above: squares of {square:g} m",
        time_ranges=[so_far],
        eye_controls=eye,
        line_grid=rrb.LineGrid3D(visible=True, spacing=square, stroke_width=0.7),
        background=[18, 20, 24],
    )
    left = rrb.Vertical(
        way, rrb.TextDocumentView(origin="/legend", name="Legend"), row_shares=[7, 1]
    )
    rows: list[Any] = []
    axis, legend = None, rrb.PlotLegend(visible=False)  # it would cover the curves
    if span_us is not None:
        first, last = (rrb.TimeRangeBoundary.absolute(nanos=1000 * each) for each in span_us)
        axis = rrb.TimeAxis(view_range=rrb.TimeRange(start=first, end=last))
    if way_columns:
        rows += [
            rrb.Spatial2DView(
                origin=ground.BY_WAY,
                name="Ground along the way, and what was known again",
                time_ranges=[so_far],
                visual_bounds=rrb.VisualBounds2D(
                    x_range=[-0.03 * way_columns, 1.02 * way_columns],
                    y_range=[-0.48 * ground.WAY_HEIGHT, 1.25 * ground.WAY_HEIGHT],
                ),
                background=[18, 20, 24],
            ),
            rrb.Spatial2DView(
                origin=ground.BY_TIME,
                name="Ground as it comes",
                visual_bounds=rrb.VisualBounds2D(
                    x_range=[-(ground.SHOWN_S + 0.6) * ground.SECOND, ground.SECOND],
                    y_range=[-0.05 * ground.TIME_HEIGHT, 1.2 * ground.TIME_HEIGHT],
                ),
                background=[18, 20, 24],
            ),
        ]

    def curves(origin: str, name: str) -> Any:
        axis_y = rrb.ScalarAxis(range=(0.0, tops[origin])) if origin in tops else None
        return rrb.TimeSeriesView(
            origin=origin, name=name, axis_x=axis, axis_y=axis_y, plot_legend=legend
        )

    rows += [
        curves("/speed", SPEED),
        rrb.Horizontal(*(curves(*each) for each in SIGMAS.items())),
        rrb.StateTimelineView(origin="/state", name="Health, standstill, slip", time_view=axis),
        rrb.TextLogView(origin="/told", name="What STATUS told"),
    ]
    shares = [*([1.2, 1.05] if way_columns else []), 0.85, 0.85, 1.2, 0.85]
    return rrb.Blueprint(
        rrb.Horizontal(left, rrb.Vertical(*rows, row_shares=shares), column_shares=[1, 1.1]),
        rrb.TimePanel(state="collapsed", timeline=TIMELINE, play_state="following"),
        rrb.BlueprintPanel(state="collapsed"),
        rrb.SelectionPanel(state="collapsed"),
        auto_views=False,
    )
