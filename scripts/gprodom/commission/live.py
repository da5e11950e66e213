"""Records a running robot, and guides its drive meanwhile."""

import select
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from gprodom.commission.guide import Guide
from gprodom.config import TRUTH_CHANNEL, Channels
from gprodom.errors import Error
from gprodom.lcm import LCM, EventLog
from gprodom.lcm.messages import by_fingerprint, message

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
