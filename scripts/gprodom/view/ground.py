"""The radargram in Rerun: pictures side by side, each of a piece of time or of the way.

One picture of it all would be sent anew with every trace; pieces are sent once. In the view by time
their common parent moves, so that what is taken now is at 0 and the past goes to the left.
"""

from typing import Any

import numpy as np

from gprodom.arrays import Floats, Ints
from gprodom.view.record import PINK, SKY, WAY_MARK_PX, Recorder, load_rerun, rgba

BY_TIME, BY_WAY = "/ground_by_time", "/ground_along_the_way"
# In units of the views, in which a column of the way is 1 wide: heights of the radargrams, whatever
# their number of samples, and a second of that by time. Views are some six times as wide as high.
WAY_HEIGHT, TIME_HEIGHT, SECOND = 180.0, 240.0, 50.0
TILE_COLUMNS = 256  # of a piece that comes live
WHOLE_COLUMNS = 2048  # of a piece of what is all there: each one costs time with each picture
SHOWN_S = 30.0  # of time that is seen at once
LABELS_NS = 10.0


class Strip:
    """A radargram of pieces side by side: column i lies at `column_width` i."""

    def __init__(
        self, recorder: Recorder, entity: str, column_width: float, height: float, left: float
    ) -> None:
        """left: where the depth is written."""
        self._recorder, self._entity = recorder, entity
        self._width, self._height, self._left = column_width, height, left
        self._rr: Any = load_rerun()

    def tile(self, number: int, grey: Ints, columns: int = TILE_COLUMNS) -> None:
        """Piece `number`, of pieces of `columns`, as grey (samples, columns) uint8; may be sent
        again."""
        rr, entity = self._rr, f"{self._entity}/pieces/{number}"
        left = number * columns * self._width
        scale = [self._width, self._height / len(grey), 1.0]
        self._recorder.static(entity, rr.Transform3D(translation=[left, 0.0, 0.0], scale=scale))
        self._recorder.static(entity, rr.Image(grey, color_model="L"))

    def whole(self, grey: Ints) -> None:
        """All pieces of a radargram (samples, columns)."""
        for number, first in enumerate(range(0, grey.shape[1], WHOLE_COLUMNS)):
            part = np.ascontiguousarray(grey[:, first : first + WHOLE_COLUMNS])
            self.tile(number, part, WHOLE_COLUMNS)

    def depth_labels(self, span_ns: tuple[float, float]) -> None:
        """The two-way time."""
        first, last = span_ns
        marks = np.arange(np.ceil(first / LABELS_NS) * LABELS_NS, 0.95 * last, LABELS_NS)
        at = np.column_stack(
            [np.full(len(marks), self._left), (marks - first) / (last - first) * self._height]
        )
        self.labels("ns", at, [f"{mark + 0.0:.0f} ns" for mark in marks])

    def labels(self, name: str, at: Floats, texts: list[str]) -> None:
        """Texts at places (n, 2)."""
        rr = self._rr
        points = rr.Points2D(
            at, labels=texts, show_labels=True, colors=[rgba("#9a9a9a")],
            radii=[rr.components.Radius.ui_points(2.0)], draw_order=20.0,
        )  # fmt: skip
        self._recorder.static(f"{self._entity}/labels/{name}", points)


class ByTime(Strip):
    """The traces as they come."""

    def __init__(self, recorder: Recorder, columns_per_s: float) -> None:
        super().__init__(recorder, BY_TIME, SECOND / columns_per_s, TIME_HEIGHT, -SHOWN_S * SECOND)
        marks = np.arange(0, -SHOWN_S + 1, -5.0)
        at = np.column_stack([marks * SECOND, np.full(len(marks), TIME_HEIGHT + 5)])
        self.labels("s", at, [f"{mark:.0f} s" if mark else "now" for mark in marks])

    def now(self, utime: Ints, seconds: Floats) -> None:
        """Where time is: seconds (n,) after the first column, at times (n,), us."""
        rr = self._rr
        left = np.column_stack([-SECOND * seconds, np.zeros((len(seconds), 2))])
        moved = rr.Transform3D.columns(translation=left)
        self._recorder.columns(f"{self._entity}/pieces", utime, moved)


class AlongWay(Strip):
    """The traces by distance driven, with the revisits as arcs above them."""

    def __init__(self, recorder: Recorder, spacing_m: float) -> None:
        super().__init__(recorder, BY_WAY, 1.0, WAY_HEIGHT, -20.0)
        self._spacing = spacing_m
        rr = self._rr
        line = rr.LineStrips2D(
            [[[0.0, -60.0], [0.0, WAY_HEIGHT]]], colors=[rgba(SKY)],
            radii=[rr.components.Radius.ui_points(WAY_MARK_PX)], draw_order=30.0,
        )  # fmt: skip
        recorder.static(f"{BY_WAY}/here/line", line)

    def metres(self, length_m: float) -> None:
        """Labels of the distance."""
        step = 10.0 ** np.ceil(np.log10(max(length_m, 1.0) / 10))
        step = step / 2 if length_m / step < 5 else step
        marks = np.arange(step, length_m, step)
        at = np.column_stack([marks / self._spacing, np.full(len(marks), WAY_HEIGHT + 5)])
        self.labels("m", at, [f"{mark:g} m" for mark in marks])

    def here(self, utime: Ints, distance: Floats) -> None:
        """A line across the radargram at the distance (n,), m, at times (n,), us."""
        rr = self._rr
        moved = np.column_stack([distance / self._spacing, np.zeros((len(distance), 2))])
        self._recorder.columns(
            f"{self._entity}/here", utime, rr.Transform3D.columns(translation=moved)
        )

    def links(self, utime: Ints, then: Floats, now: Floats) -> None:
        """Revisits: arcs from the distance `then` (n,), m, to `now` (n,)."""
        if not len(utime):
            return
        rr = self._rr
        angle = np.linspace(0, np.pi, 24)
        middle, half = (then + now) / 2 / self._spacing, (now - then) / 2 / self._spacing
        height = 0.4 * WAY_HEIGHT * np.sqrt(np.abs(half) / max(np.abs(half).max(), 1.0))
        x = middle[:, None] - half[:, None] * np.cos(angle)
        y = -5.0 - height[:, None] * np.sin(angle)
        strips = list(np.stack([x, y], axis=2).astype(np.float32))
        columns = rr.LineStrips2D.columns(
            strips=strips,
            colors=np.full(len(strips), rgba(PINK, 120), np.uint32),
            radii=[rr.components.Radius.ui_points(0.5)] * len(strips),
        )
        self._recorder.columns(f"{self._entity}/revisits", utime, columns)


def as_bytes(echoes: Floats) -> Ints:
    """-1 to 1 as uint8; what is not known is mid-grey."""
    return np.asarray(np.rint(127.5 + 127.5 * np.nan_to_num(echoes)), np.uint8)
