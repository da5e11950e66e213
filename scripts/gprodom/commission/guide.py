"""The guided drive of ``gprodom commission --live``: what to do next, by wheel and gyro.

Neither the unit of the wheel nor the mounting of the IMU is known yet. So standstills and the
pieces between them count, not metres; and turns are about the axis of gravity, left being positive
however the IMU is mounted.
"""

import numpy as np

from gprodom.arrays import Floats
from gprodom.commission.parameter import CIRCLES, STAND, STARTS, STRAIGHT

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
