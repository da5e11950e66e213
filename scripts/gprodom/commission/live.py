"""Records a running robot, and guides its drive meanwhile: what to do next, by wheel and gyro.

Neither the unit of the wheel nor the mounting of the IMU is known yet. So standstills and the
pieces between them count, not metres; and turns are about the axis of gravity, left being positive
however the IMU is mounted.
"""

import select
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from gprodom.arrays import Floats
from gprodom.commission.parameter import CIRCLES, STAND, STARTS, STRAIGHT
from gprodom.config import TRUTH_CHANNEL, Channels
from gprodom.errors import Error
from gprodom.lcm import LCM, EventLog
from gprodom.lcm.messages import by_fingerprint, message

BACK = "stop, and then drive the 10 m back to a standstill"
STEPS = (STAND, STRAIGHT, STARTS, CIRCLES, BACK)
STANDING, STRETCH, HARD_STARTS, CIRCLING, RETURN = range(5)

STANDS_S = 30.0
RESTS_S = 1.0  # then a standstill has begun, and a piece has ended
RESTS_M = 0.01  # as counted; the wheel is within it at rest
PIECE_M = 0.1  # as counted; less is no piece
STARTS_WANTED = 10  # five times there and back
CIRCLE = 2 * np.pi
CIRCLES_WANTED = 2 * CIRCLE  # rad to either side
CLOSE = 0.95  # of that is enough: nobody ends a circle to the degree


class Guide:
    """Follows the drive. `step` is the number in `STEPS` of what is to be done now, and their count
    when all is done."""

    def __init__(self) -> None:
        self.step = STANDING
        self._stood_s = 0.0
        self._anchor_m: float | None = None
        self._rests_from = 0
        self._moving, self._path_m, self._last_m = False, 0.0, 0.0
        self._pieces = 0  # ended in this step, each begun in it
        self._began_in_step = False
        self._left = self._right = 0.0  # rad, in this step
        self._count, self._force, self._rate = 0, np.zeros(3), np.zeros(3)
        self._imu_last: int | None = None

    @property
    def done(self) -> bool:
        """All of it."""
        return self.step >= len(STEPS)

    def next_step(self) -> None:
        """Leaves this step, done or not."""
        self.step += 1
        self._pieces, self._began_in_step = 0, False
        self._left = self._right = 0.0

    def wheel(self, utime: int, distance: float) -> None:
        """A message of it: us, and counted m (of two sides the mean)."""
        if self._anchor_m is None:
            self._anchor_m = self._last_m = distance
            self._rests_from = utime
        self._path_m += abs(distance - self._last_m)
        self._last_m = distance
        if abs(distance - self._anchor_m) > RESTS_M:
            self._anchor_m, self._rests_from = distance, utime
            if not self._moving:
                self._moving, self._path_m, self._began_in_step = True, 0.0, True
            if self.step == STANDING:
                self._count, self._force, self._rate = 0, np.zeros(3), np.zeros(3)
        self._stood_s = (utime - self._rests_from) * 1e-6
        if self._moving and self._stood_s >= RESTS_S:
            self._moving = False
            if self._path_m >= PIECE_M and self._began_in_step:
                self._pieces += 1
        self._go_on()

    def imu(self, utime: int, acceleration: Floats, rate: Floats) -> None:
        """A message of it: us, m/s^2 and rad/s (3,)."""
        before, self._imu_last = self._imu_last, utime
        if self.step == STANDING and self._stood_s >= RESTS_S:
            self._count += 1
            self._force = self._force + acceleration
            self._rate = self._rate + rate
        if self.step != CIRCLING or before is None or not self._count:
            return
        up = self._force / np.linalg.norm(self._force)
        turned = float((rate - self._rate / self._count) @ up) * min((utime - before) * 1e-6, 0.2)
        self._left += max(turned, 0.0)
        self._right += max(-turned, 0.0)

    def _go_on(self) -> None:
        wanted = {STRETCH: 1, HARD_STARTS: STARTS_WANTED, RETURN: 1}
        circled = min(self._left, self._right) >= CLOSE * CIRCLES_WANTED
        if (
            (self.step == STANDING and self._stood_s >= STANDS_S)
            or self._pieces >= wanted.get(self.step, STARTS_WANTED + 1)
            or (self.step == CIRCLING and circled)
        ):
            self.next_step()

    def line(self) -> str:
        """What to do, and how far it is."""
        if self.done:
            return "done: stop the robot"
        far = {
            STANDING: f"{self._stood_s:.0f} of {STANDS_S:.0f} s",
            HARD_STARTS: f"{self._pieces} of {STARTS_WANTED} starts and stops",
            CIRCLING: f"{self._left / CIRCLE:.1f} of 2 to the left, "
            f"{self._right / CIRCLE:.1f} of 2 to the right",
        }.get(self.step, "driving" if self._moving else "standing")
        return f"{self.step + 1} of {len(STEPS)}: {STEPS[self.step]} ({far})"


ROLES = ("imu", "wheel", "wheels", "gpr_trace")
SHOWN_S = 1.0  # between two lines
SILENT_S = 2.0
CLOSES_S = 1.0  # recorded after the last step: what is on its way


class Recorder:
    """Writes what the sensors send, and shows it to the guide; `take` is the callback."""

    def __init__(self, log: EventLog, names: dict[str, str], guide: Guide) -> None:
        """names: of the channels by role."""
        self._log, self._guide = log, guide
        self._roles = {name: role for role, name in names.items()}
        self._heard: dict[str, float] = {}

    def take(self, channel: str, data: bytes) -> None:
        """A message."""
        self._log.write_event(time.time_ns() // 1000, channel, data)
        role = self._roles.get(channel, "")
        kind = by_fingerprint().get(bytes(data[:8]))
        self._heard[role] = time.monotonic()
        if kind not in ("imu_t", "wheel_t", "wheels_t"):
            return
        try:
            sent: Any = message(kind).decode(data)
        except (ValueError, EOFError) as error:
            raise Error(f"{channel}: a damaged message ({error})") from None
        if kind == "imu_t":
            self._guide.imu(
                sent.utime, np.array(sent.linear_acceleration), np.array(sent.angular_velocity)
            )
        elif kind == "wheel_t":
            self._guide.wheel(sent.utime, sent.ticks * sent.metres_per_tick)
        else:
            mean = 0.5 * (sent.left_ticks + sent.right_ticks) * sent.metres_per_tick
            self._guide.wheel(sent.utime, mean)

    def silent(self) -> list[str]:
        """Sensors that are needed and do not send; the radar only if it has sent."""
        now = time.monotonic()
        speaks = {role for role, heard in self._heard.items() if now - heard < SILENT_S}
        missing = [] if "imu" in speaks else ["IMU"]
        missing += [] if speaks & {"wheel", "wheels"} else ["wheel"]
        return missing + (["radar"] if "gpr_trace" in set(self._heard) - speaks else [])


def record(lcm: LCM, path: Path, channels: Channels, show: Callable[[str], None]) -> Guide:
    """Until the drive is done, or interrupted. show: takes what to do next, once a second.

    On a terminal Enter leaves a step. Returns the guide, which says what was done.
    """
    guide = Guide()
    log = EventLog(path, "w", overwrite=True)
    names = channels.of(*ROLES)
    recorder = Recorder(log, names, guide)
    for name in (*names.values(), TRUTH_CHANNEL):
        lcm.subscribe(name, recorder.take).set_queue_capacity(10_000)
    due, ends = 0.0, None
    try:
        while ends is None or time.monotonic() < ends:
            lcm.handle_timeout(50)
            if _entered() and not guide.done:
                guide.next_step()
            if guide.done and ends is None:
                ends = time.monotonic() + CLOSES_S
            if time.monotonic() >= due:
                due = time.monotonic() + SHOWN_S
                silent = recorder.silent()
                said = f"   [nothing from: {', '.join(silent)}]" if silent else ""
                show(guide.line() + said)
    except KeyboardInterrupt:
        pass
    finally:
        log.close()
    return guide


def _entered() -> bool:
    """Whether a line was typed since the last call."""
    if sys.stdin is None or not sys.stdin.isatty():
        return False
    return bool(select.select([sys.stdin], [], [], 0)[0]) and bool(sys.stdin.readline())
