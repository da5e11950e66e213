"""What a running gprodomd publishes, as a Rerun recording that grows.

Messages come faster than anybody can look: of each channel no more are kept than are drawn, and
what was kept is decoded and sent twice a second, a whole array at a time. So the process takes a
few percent of a core.
"""

import signal
import struct
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from threading import Event
from time import monotonic, sleep
from typing import Any

import numpy as np

from gprodom.arrays import Floats, Ints
from gprodom.console import warn
from gprodom.drive.imu_mounting import ImuMounting
from gprodom.drive.imu_speed import SPAN_S as IMU_SPAN_S
from gprodom.drive.imu_speed import imu_speed
from gprodom.drive.log import turned_onto
from gprodom.drive.radargram import SHOWN_RMS, of_one_antenna
from gprodom.errors import Error
from gprodom.lcm import LCM, wire
from gprodom.lcm.constants import flag, health
from gprodom.lcm.logs import Channel
from gprodom.lcm.messages import by_fingerprint, message
from gprodom.plot.log import SPEED_SPAN_S, radar_speed, wheel_speed
from gprodom.plot.revisits import find_revisits
from gprodom.score.sources import odometry
from gprodom.trajectory import Trajectory, interpolate, joined, thin
from gprodom.view.ground import TILE_COLUMNS, AlongWay, ByTime, as_bytes
from gprodom.view.log import FLAG_LANES, LEAST_PERIOD_S
from gprodom.view.reckoning import Reckoning
from gprodom.view.record import ON, Recorder

SEND_S = 0.5  # between two times that what was kept is sent
TAKE_S = 0.05  # between two times that what has come is taken, and to an interruption, at most
KEPT_US = {"odometry": 100_000, "odometry_map": 100_000}  # the others are kept whole
ROLES = (
    "odometry",
    "odometry_map",
    "imu",
    "wheel",
    "wheels",
    "displacement",
    "status",
    "gpr_trace",
)
GROUND_S = 1.0  # between two pictures of the newest piece of ground
SPACING_M = 0.02  # of a column along the way
WAY_COLUMNS = 1600  # of those that are in sight: 32 m


class Live:
    """Takes messages (`take` is the callback of subscriptions), and sends (`send`)."""

    def __init__(self, recorder: Recorder, names: Mapping[str, str], mounting: ImuMounting) -> None:
        """names: of the channels by role. mounting: of the IMU."""
        self._recorder = recorder
        self._roles = {name: role for role, name in names.items()}
        self._kept: dict[str, list[bytes]] = {}
        self._last: dict[str, int] = {}
        self._path: Trajectory | None = None  # so far, in map, thinned
        self._odom: Trajectory | None = None  # the last pose in odom, as drawn
        self._place: tuple[Floats, Floats] | None = None  # of odom in map, at its first pose
        self._driven = np.zeros(0)  # along `_path`
        self._told: set[str] = set()
        self._ground = Ground(recorder)
        self._wheel: Channel | None = None  # of the last second
        self._wheel_sent = 0  # time of the last speed of it that was sent (us)
        self._reckoning = Reckoning()
        self._mounting = mounting
        self._recent: dict[str, Channel] = {}  # IMU and estimate, for the IMU's speed
        self._imu_sent = 0  # time of the last speed of it that was sent (us)

    def subscribe(self, lcm: LCM) -> None:
        """To the channels that are drawn, and no others: they cost processor time."""
        for name in self._roles:
            lcm.subscribe(name, self.take).set_queue_capacity(1000)

    def take(self, channel: str, data: bytes) -> None:
        """Keeps a message, or not."""
        if bytes(data[:8]) not in by_fingerprint() or len(data) < 16:
            return
        role = self._roles[channel]
        period = KEPT_US.get(role)
        if period is not None:
            (utime,) = struct.unpack_from(">q", data, 8)  # the first field of all our types
            if 0 <= utime - self._last.get(role, -period) < period:
                return
            self._last[role] = utime
        self._kept.setdefault(role, []).append(data)

    def send(self) -> None:
        """Sends what was kept."""
        kept, self._kept = self._kept, {}
        found = {role: each for role, data in kept.items() if (each := decode(data)) is not None}
        if "odometry_map" in found:
            self._send_odometry(found["odometry_map"])
        elif "odometry" in found and "odometry_map" not in self._last:
            self._send_odometry(found["odometry"])
        if "odometry" in found and "odometry_map" in self._last:
            self._send_uncorrected(odometry(found["odometry"]))
        self._send_wheel(found)
        self._send_reckoned(found)
        self._send_imu(found)
        if "displacement" in found:
            self._send_displacements(found["displacement"])
        if "status" in found:
            self._send_status(found["status"]["messages"])
        if "gpr_trace" in found and self._path is not None:
            self._ground.add(found["gpr_trace"], self._path.time, self._driven)

    def finish(self) -> None:
        """Sends all of what is left."""
        self.send()
        self._send_reckoned({}, is_all=True)
        self._ground.send()

    def _send_odometry(self, content: Channel) -> None:
        path = odometry(content)
        drawn, before = replace(path, covariance=None), self._path
        if before is not None:  # with the pose before it, so that lines join
            drawn = joined([before.select(np.array([len(before) - 1])), drawn])
        self._recorder.path("map", drawn, 1 << 62)
        self._recorder.robot(path)
        self._recorder.sigmas(path)
        self._recorder.scalars("/speed/estimate", content["utime"], content["velocity"][:, 0])
        for name, bit in FLAG_LANES.items():
            on = (content["flags"] & flag(bit)) != 0
            if on.any() or self._recorder.has_state(name):
                self._recorder.state(name, content["utime"], [ON if each else "" for each in on])
        bare = replace(path, covariance=None)
        self._path = bare if before is None else joined([before, bare])
        driven = np.interp(path.time, content["utime"], content["distance"])
        self._driven = np.concatenate([self._driven, driven])

    def _send_uncorrected(self, odom: Trajectory) -> None:
        """The path in `odom`, moved to begin where that in `map` does."""
        path = self._path
        if path is None:
            return
        if self._place is None:
            common = np.flatnonzero((odom.time >= path.time[0]) & (odom.time <= path.time[-1]))
            if not len(common):
                return
            first = odom.select(common[:1])
            self._place = turned_onto(first, interpolate(path, first.time))
        moved = odom.transformed(*self._place)
        before = self._odom
        self._recorder.path("odom", moved if before is None else joined([before, moved]), 1 << 62)
        self._odom = moved.select(np.array([len(moved) - 1]))

    def _send_wheel(self, found: dict[str, Channel]) -> None:
        """Its speed."""
        role = next((each for each in ("wheel", "wheels") if each in found), None)
        if role is None:
            return
        whole = found[role] if self._wheel is None else _joined(self._wheel, found[role])
        measured = wheel_speed({role: whole})
        assert measured is not None
        time, speed = measured
        # A speed is taken over some time before and after it.
        new = (time > self._wheel_sent) & (time < time[-1] - 0.5e6 * SPEED_SPAN_S)
        self._recorder.scalars("/speed/wheel", time[new], speed[new])
        self._wheel_sent = int(time[new][-1]) if new.any() else self._wheel_sent
        recent = time >= time[-1] - round(2e6 * SPEED_SPAN_S)
        self._wheel = {name: value[recent] for name, value in whole.items()}

    def _send_imu(self, found: dict[str, Channel]) -> None:
        """The speed by the IMU."""
        for role in ("imu", "odometry"):
            if role not in found:
                continue
            before = self._recent.get(role)
            whole = found[role] if before is None else _joined(before, found[role])
            kept = whole["utime"] >= whole["utime"][-1] - round(2e6 * IMU_SPAN_S)
            self._recent[role] = {name: value[kept] for name, value in whole.items()}
        if len(self._recent) < 2:
            return
        time, speed = imu_speed(self._recent["imu"], self._recent["odometry"], self._mounting)
        new = time > self._imu_sent
        self._recorder.scalars("/speed/IMU", time[new], speed[new])
        self._imu_sent = int(time[new][-1]) if new.any() else self._imu_sent

    def _send_reckoned(self, found: dict[str, Channel], is_all: bool = False) -> None:
        """The way by wheel and gyro alone."""
        way = self._reckoning.add(found, self._path, is_all)
        if way is not None:
            self._recorder.path("wheel and gyro", thin(way, KEPT_US["odometry"]), 1 << 62)

    def _send_displacements(self, content: Channel) -> None:
        self._recorder.scalars("/speed/radar", *radar_speed(content))
        if self._path is None:
            return
        path = self._path
        revisits = find_revisits({"displacement": content}).within(path)
        ends = revisits.start, revisits.end
        there, here = (interpolate(path, each).position for each in ends)
        self._recorder.links(revisits.end, there, here, 1)
        metres = [np.interp(each, path.time, self._driven) for each in ends]
        self._ground.links(revisits.end, *metres)

    def _send_status(self, messages: list[Any]) -> None:
        for status in messages:
            when = np.array([status.utime], np.int64)
            word = health(int(status.health))
            self._recorder.state("health", when, [word])
            self._told = self._recorder.reasons(status, word, self._told)


@dataclass
class _Tile:
    """A piece of ground that is not full: its number, echoes (samples, columns)."""

    number: int
    echoes: Floats


class Ground:
    """Traces as pieces of ground, by time and along the way, relative to the strength so far."""

    def __init__(self, recorder: Recorder) -> None:
        self._recorder = recorder
        self._by_time: ByTime | None = None
        self._way = AlongWay(recorder, SPACING_M)
        self._count = 0
        self._sum = self._squares = np.zeros(0)
        self._origin, self._period = 0, 0.05
        self._tiles: dict[str, _Tile] = {}
        self._due = 0.0
        self._metres = 0.0

    def add(self, radar: Channel, time: Ints, driven: Floats) -> None:
        """Traces, and the way so far: distance (m,), m, at times (m,), us."""
        stamps, traces = of_one_antenna(radar)
        if traces.shape[1] != self._sum.size:
            self._begin(radar, stamps, traces)
        self._count += len(traces)
        self._sum = self._sum + traces.sum(axis=0)
        self._squares = self._squares + (traces.astype(float) ** 2).sum(axis=0)
        mean = self._sum / self._count
        deviation = np.sqrt(np.maximum(self._squares / self._count - mean**2, 1e-9))
        echoes = np.clip((traces - mean) / (SHOWN_RMS * deviation), -1, 1).T
        seconds = (stamps - self._origin) * 1e-6
        metres = np.interp(stamps, time, driven)
        assert self._by_time is not None
        self._fill("time", np.rint(seconds / self._period).astype(int), echoes)
        self._fill("way", (metres / SPACING_M).astype(int), echoes)
        self._by_time.now(stamps[-1:], seconds[-1:])
        self._way.here(stamps[-1:], metres[-1:])
        if metres[-1] > self._metres:
            self._metres = float(metres[-1]) + 10.0
            self._way.metres(max(self._metres, WAY_COLUMNS * SPACING_M))
        if monotonic() >= self._due:
            self._due = monotonic() + GROUND_S
            self.send()

    def send(self) -> None:
        """The pieces that are not full."""
        for name in self._tiles:
            self._send(name)

    def links(self, utime: Ints, then: Floats, now: Floats) -> None:
        """Revisits along the way."""
        self._way.links(utime, then, now)

    def _begin(self, radar: Channel, stamps: Ints, traces: Floats) -> None:
        """At the first trace, and where the radar's setting changes."""
        self._count = 0
        self._sum = self._squares = np.zeros(traces.shape[1])
        self._tiles = {}
        if self._by_time is None:
            steps = np.diff(stamps) * 1e-6
            self._period = max(float(np.median(steps)), LEAST_PERIOD_S) if len(steps) else 0.05
            self._origin = int(stamps[0])
            self._by_time = ByTime(self._recorder, 1 / self._period)
            zero, interval = float(radar["time_zero"][0]), float(radar["sample_interval"][0])
            span = (-1e9 * zero, 1e9 * (traces.shape[1] * interval - zero))
            self._by_time.depth_labels(span)
            self._way.depth_labels(span)

    def _fill(self, name: str, columns: Ints, echoes: Floats) -> None:
        for number in np.unique(columns // TILE_COLUMNS):
            tile = self._tiles.get(name)
            if tile is None or tile.number != number:
                if tile is not None:
                    self._send(name)
                tile = self._tiles[name] = _Tile(int(number), np.zeros((len(echoes), TILE_COLUMNS)))
            these = columns // TILE_COLUMNS == number
            tile.echoes[:, columns[these] % TILE_COLUMNS] = echoes[:, these]

    def _send(self, name: str) -> None:
        tile = self._tiles[name]
        strip = self._by_time if name == "time" else self._way
        assert strip is not None
        strip.tile(tile.number, as_bytes(tile.echoes))


def decode(data: list[bytes]) -> Channel | None:
    """Messages of one of our types as arrays, or as `messages`; None where they are damaged."""
    name = by_fingerprint()[bytes(data[-1][:8])]
    same = [each for each in data if each[:8] == data[-1][:8]]
    try:
        if name in wire.LAYOUTS:
            return dict(wire.decode(name, same, name))
        return {"messages": [message(name).decode(each) for each in same]}
    except (Error, ValueError, struct.error) as error:
        warn(f"left out: {error}")
        return None


def _joined(one: Channel, other: Channel) -> Channel:
    return {name: np.concatenate([one[name], other[name]]) for name in other}


@contextmanager
def interruptions() -> Iterator[Event]:
    """An event that is set by Ctrl-C, in place of an exception: that would come in the middle of
    anything, sending what is left included."""
    interrupted = Event()
    before = signal.signal(signal.SIGINT, lambda *_: interrupted.set())
    try:
        yield interrupted
    finally:
        signal.signal(signal.SIGINT, before)


def listen(lcm: LCM, live: Live, goes_on: Callable[[], bool], interrupted: Event) -> None:
    """Takes and sends, while `goes_on` and until interrupted.

    It wakes for what has come in a while, not for each message: the waking costs more than taking.
    """
    due = monotonic() + SEND_S
    while not interrupted.is_set():
        sleep(TAKE_S)
        try:
            while monotonic() < due and lcm.handle_timeout(0) > 0:
                pass
        except OSError:  # of the call that a signal interrupts
            if not interrupted.is_set():
                raise
        if monotonic() >= due:
            if not goes_on():
                return
            live.send()
            due = monotonic() + SEND_S
