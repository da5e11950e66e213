"""Dead reckoning of a running robot, placed where its estimate was first known."""

import numpy as np

from gprodom.arrays import Bools, Floats
from gprodom.drive.log import turned_onto
from gprodom.lcm.logs import Channel
from gprodom.odometry.dead_reckoning import Reckoner
from gprodom.trajectory import Trajectory, interpolate, joined, without_repeats

SENSORS = ("imu", "wheel", "wheels")
BACK_US = 1_000_000  # a clock that goes back further was set; by less, messages have changed places
GAP_US = 600_000_000  # of a sensor: it is another drive


class Reckoning:
    """`gprodom.odometry.dead_reckoning.Reckoner` in the frame of the estimate."""

    def __init__(self) -> None:
        self._begin()

    def _begin(self) -> None:
        self._reckoner = Reckoner()
        self._last: dict[str, int] = {}
        self._waiting: list[Trajectory] = []  # until it is known where they lie
        self._place: tuple[Floats, Floats] | None = None

    def add(
        self, found: dict[str, Channel], path: Trajectory | None, is_all: bool = False
    ) -> Trajectory | None:
        """The way from the pose told last on; None: no further.

        found: channels by role, what came since. path: the estimate so far. is_all: nothing more
        comes. After a step of the clock or a long silence it begins anew, from the estimate.
        """
        sensed = {role: found[role] for role in SENSORS if role in found}
        if any(self._is_another_drive(role, each) for role, each in sensed.items()):
            self._begin()
        kept = {role: self._new(role, each) for role, each in sensed.items()}
        way = self._reckoner.add(kept, is_all)
        if way is None and not self._waiting:
            return None
        self._waiting += [] if way is None else [way]
        if self._place is None:
            self._place = self._placed(path)
        if self._place is None:
            return None
        told, self._waiting = joined(self._waiting), []
        return told.transformed(*self._place)

    def _is_another_drive(self, role: str, content: Channel) -> bool:
        last = self._last.get(role)
        if last is None:
            return False
        step = int(content["utime"][0]) - last
        return step < -BACK_US or step > GAP_US

    def _new(self, role: str, content: Channel) -> Channel:
        """Without what is not later than all before it."""
        stamps = content["utime"]
        before = np.concatenate([[self._last.get(role, -(1 << 62))], stamps[:-1]])
        later: Bools = stamps > np.maximum.accumulate(before)
        self._last[role] = max(int(stamps.max()), self._last.get(role, -(1 << 62)))
        return {name: values[later] for name, values in content.items()}

    def _placed(self, path: Trajectory | None) -> tuple[Floats, Floats] | None:
        """Rotation and translation that bring it to the first pose of `path` of its time."""
        way = without_repeats(joined(self._waiting))
        if path is None:
            return None
        common = np.flatnonzero((path.time >= way.time[0]) & (path.time <= way.time[-1]))
        if not len(common):
            return None
        first = path.select(common[:1])
        return turned_onto(interpolate(way, first.time), first)
