"""A drive as a Rerun recording: what is logged, whether it comes from a log or live.

Entities are named as a user reads them in the viewer. All times are those of the data.
"""

from __future__ import annotations

import re
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

import numpy as np

from gprodom import canvas
from gprodom.arrays import Floats, Ints
from gprodom.drive.doubt import half_axes, position_sigma, yaw_sigma
from gprodom.errors import Error
from gprodom.trajectory import Trajectory

if TYPE_CHECKING:
    import rerun as rr

BLUE, ORANGE, GREEN, PINK, AMBER, SKY = canvas.COLOURS[:6]
GREY = "#9a9a9a"
TIMELINE = "time"
ON = "yes"  # the state of a lane that is a flag; without a text, its colour says it

WAY = "/way"
PATHS = {"wheel and gyro": ORANGE, "truth": GREY, "odom": GREEN, "map": BLUE}  # the last on top
LAYER_M = 0.01  # a line lies above the one before it
SPEEDS = {"IMU": PINK, "wheel": ORANGE, "radar": GREEN, "estimate": BLUE}
SIGMAS = {"position": BLUE, "heading": GREEN}
HEALTH = {"ok": GREEN, "degraded": AMBER, "failed": ORANGE}
STATES = {"standing": SKY, "slipping": AMBER, "radar missing": ORANGE, "wheel missing": ORANGE}
LINE_PX = 1.5
LEGEND = """\
**blue** map: the estimate, corrected by ground known again · **green** odom: without corrections ·
**orange** wheel and gyro alone · **grey** truth, where there is one · **pink** from where ground
was first seen to where it is known again · **sky blue** ring: holds the position with 95 % ·
**brown** ground of an earlier day (`--map`)
"""

WAY_MARK_PX = 1.0


NOT_INSTALLED = Error(
    "the Rerun library is not installed: pip install 'gprodom[view]' in a virtual environment "
    "(Debian has no package of it)"
)


def is_installed() -> bool:
    """Whether there is the library; does not import it."""
    try:
        return find_spec("rerun") is not None
    except ValueError:
        return False


def load_rerun() -> Any:
    """The library."""
    try:
        import rerun
    except ImportError:
        raise NOT_INSTALLED from None
    return rerun


def new_stream(name: str) -> rr.RecordingStream:
    """A recording of that name, which goes nowhere yet. Its statistics are those of
    `gprodom.view.viewer.without_statistics`."""
    stream: rr.RecordingStream = load_rerun().RecordingStream("gprodom", recording_id=name)
    stream.send_recording_name(name)
    return stream


def rgba(colour: str, alpha: int = 255) -> int:
    """As Rerun takes it, of #rrggbb."""
    return (int(colour[1:], 16) << 8) | alpha


def plain(entity: str) -> str:
    """The path of an entity in letters that Rerun takes as they are."""
    return re.sub(r"[^\w/.-]+", "_", entity)


class Recorder:
    """Logs to one Rerun recording."""

    def __init__(self, stream: rr.RecordingStream) -> None:
        self._rr = load_rerun()
        self.stream = stream
        self._states: dict[str, str] = {}
        self._styles()
        self.static("/legend", self._rr.TextDocument(LEGEND, media_type="text/markdown"))

    def _styles(self) -> None:
        """What does not change with time."""
        rr = self._rr
        px = rr.components.Radius.ui_points
        self.static(WAY, rr.ViewCoordinates.RIGHT_HAND_Z_UP)
        for group, colours in (("speed", SPEEDS), ("sigma", SIGMAS)):
            for name, colour in colours.items():
                series = rr.SeriesLines(colors=[rgba(colour)], names=[name], widths=[1.5])
                self.static(f"/{group}/{name}", series)
        self.state_style("health", HEALTH)
        for name, colour in STATES.items():
            self.state_style(name, {ON: colour})
        forward = rr.Arrows3D(vectors=[[0.6, 0.0, 0.0]], colors=[rgba("#ffffff")], radii=[px(4.0)])
        self.static(f"{WAY}/robot/heading", forward)
        angle = np.linspace(0, 2 * np.pi, 60)
        circle = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(60)])
        line = rr.LineStrips3D([circle], colors=[rgba(SKY)], radii=[px(LINE_PX)])
        self.static(f"{WAY}/ring/95 percent", line)

    def arrow(self, length_m: float) -> None:
        """The robot, as an arrow that can be seen: of that length."""
        px = self._rr.components.Radius.ui_points
        level = [0.0, 0.0, LAYER_M * len(PATHS)]
        forward = self._rr.Arrows3D(
            origins=[level],
            vectors=[[length_m, 0.0, 0.0]],
            colors=[rgba("#ffffff")],
            radii=[px(3.0)],
        )
        self.static(f"{WAY}/robot/heading", forward)

    def state_style(self, name: str, colours: dict[str, str]) -> None:
        """The colours of a lane's states."""
        self.static(
            f"/state/{name}",
            self._rr.StateConfiguration(
                values=list(colours),
                labels=[" " if each == ON else each for each in colours],
                colors=np.array([rgba(each) for each in colours.values()], np.uint32),
            ),
        )

    def static(self, entity: str, archetype: Any) -> None:
        """Logs what holds at all times."""
        self.stream.log(plain(entity), archetype, static=True)

    def columns(self, entity: str, utime: Ints, columns: Any) -> None:
        """Logs a row for each time (n,), us."""
        when = self._rr.TimeColumn(TIMELINE, timestamp=utime.astype("datetime64[us]"))
        self.stream.send_columns(plain(entity), indexes=[when], columns=columns)

    # ---- the way ----

    def path(self, name: str, path: Trajectory, piece_us: int) -> None:
        """A line that grows with time, in pieces of `piece_us`."""
        pieces = cut(path.time, piece_us)
        if not pieces:
            return
        level = [0.0, 0.0, LAYER_M * list(PATHS).index(name)]
        strips = [(path.position[a : b + 1] + level).astype(np.float32) for a, b in pieces]
        ends = path.time[[b for _, b in pieces]]
        self.lines(f"{WAY}/{name}", ends, strips, PATHS[name], 2.0 if name == "map" else 1.2)

    def lines(
        self, entity: str, utime: Ints, strips: list[Floats], colour: str, width_px: float
    ) -> None:
        """A line (m, 3) for each time."""
        rr = self._rr
        count = len(strips)
        columns = rr.LineStrips3D.columns(
            strips=strips,
            colors=np.full(count, rgba(colour), np.uint32),
            radii=[rr.components.Radius.ui_points(width_px / 2)] * count,
        )
        self.columns(entity, utime, columns)

    def robot(self, path: Trajectory) -> None:
        """Where it is, and the ellipse that holds it with 95 %; `path` needs orientations."""
        assert path.orientation is not None and path.covariance is not None
        rr = self._rr
        xyzw = np.roll(path.orientation, -1, axis=1)
        moved = rr.Transform3D.columns(translation=path.position, quaternion=xyzw)
        self.columns(f"{WAY}/robot", path.time, moved)
        axes = np.zeros((len(path), 3, 3))
        axes[:, :2, :2], axes[:, 2, 2] = half_axes(path), 1.0
        ring = rr.Transform3D.columns(translation=path.position, mat3x3=list(axes))
        self.columns(f"{WAY}/ring", path.time, ring)

    def links(self, utime: Ints, then: Floats, now: Floats, piece_us: int) -> None:
        """Revisits, each as a line from where the ground was first seen to where it is seen again:
        places (n, 3) at times (n,) that do not decrease. Those of `piece_us` come at once, with the
        last of them: rows cost a viewer more than lines do."""
        if not len(utime):
            return
        rr = self._rr
        lines = (np.stack([then, now], axis=1) - [0.0, 0.0, LAYER_M]).astype(np.float32)
        ends = np.append(np.flatnonzero(np.diff(utime // piece_us)), len(utime) - 1)
        columns = rr.LineStrips3D.columns(
            strips=list(lines),
            colors=np.full(len(lines), rgba(PINK), np.uint32),
            radii=[rr.components.Radius.ui_points(0.4)] * len(lines),
        ).partition(np.diff(ends, prepend=-1))
        self.columns(f"{WAY}/revisits", utime[ends], columns)

    def ground_of_map(self, name: str, places: Floats) -> None:
        """Ground (n, 2) of an earlier drive."""
        rr = self._rr
        xyz = np.column_stack([places, np.full(len(places), -0.01)])
        points = rr.Points3D(
            xyz, colors=[rgba("#b08d57", 220)], radii=[rr.components.Radius.ui_points(2.5)]
        )
        self.static(f"{WAY}/{name}", points)

    # ---- along time ----

    def scalars(self, entity: str, utime: Ints, values: Floats) -> None:
        """A curve."""
        if len(utime):
            columns = self._rr.Scalars.columns(scalars=np.asarray(values, float))
            self.columns(entity, utime, columns)

    def sigmas(self, path: Trajectory) -> None:
        """How sure."""
        self.scalars("/sigma/position", path.time, position_sigma(path))
        self.scalars("/sigma/heading", path.time, np.degrees(yaw_sigma(path)))

    def state(self, name: str, utime: Ints, values: list[str]) -> None:
        """A lane of states; only what changes is logged."""
        before = self._states.get(name)
        rows = [i for i, value in enumerate(values) if value != (values[i - 1] if i else before)]
        if rows:
            self._states[name] = values[rows[-1]]
            changes = self._rr.StateChange.columns(state=[values[i] for i in rows])
            self.columns(f"/state/{name}", utime[rows], changes)

    def has_state(self, name: str) -> bool:
        """Whether that lane has begun."""
        return name in self._states

    def reasons(self, status: Any, health: str, told: set[str]) -> set[str]:
        """Logs what reasons a STATUS gives that are not in `told`; returns those that it gives."""
        new = [reason for reason in status.reasons if reason not in told]
        if new:
            level = {"ok": "INFO", "degraded": "WARN", "failed": "ERROR"}[health]
            columns = self._rr.TextLog.columns(text=new, level=[level] * len(new))
            self.columns("/told", np.full(len(new), status.utime, np.int64), columns)
        return set(status.reasons)


def cut(time: Ints, piece_us: int) -> list[tuple[int, int]]:
    """First and last row of each piece; a piece begins where the one before it ends."""
    if len(time) < 2:
        return []
    number = (time - time[0]) // piece_us
    ends = np.append(np.flatnonzero(np.diff(number)) + 1, len(time) - 1)
    starts = np.concatenate([[0], ends[:-1]])
    return [(int(a), int(b)) for a, b in zip(starts, ends, strict=True) if b > a]
