"""What went wrong in a drive, and when, from what the estimator itself said."""

import re
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

import numpy as np

from gprodom.arrays import Bools, Floats, runs
from gprodom.drive.log import Drive
from gprodom.lcm.constants import flag_bits, health

Level = Literal["failed", "degraded", "note"]
LEVELS: tuple[Level, ...] = ("failed", "degraded", "note")

STATUS_S = 1.0  # between two STATUS
JOINED_S = 1.0  # shorter pauses do not part two stretches
SILENT_S = 1.0  # between two poses; the daemon itself counts silence of a sensor from here

# Flags of odometry_t that are told; standing is none of them, and WHEEL_FAST and WHEEL_SLOW say
# which way the wheel slips.
FLAGS: dict[str, tuple[Level, str]] = {
    "solver failed": ("degraded", "the solver failed: poses by IMU alone"),
    "IMU gap": ("degraded", "IMU data were missing"),
    "no wheel": ("degraded", "no wheel data in use"),
    "no radar": ("degraded", "no radar data in use"),
    "immobilised": ("degraded", "the wheels turn, and the ground under the antenna stands"),
    "wheel fast": ("note", "the wheel slips: it is faster than the ground (spins)"),
    "wheel slow": ("note", "the wheel slips: it is slower than the ground (skids)"),
    "left slips": ("note", "the left wheels slip"),
    "right slips": ("note", "the right wheels slip"),
}


@dataclass(frozen=True)
class Trouble:
    """One thing that went wrong. spans: (start, duration) of each time, seconds after the first
    pose, in order; count: how often, where that is counted and not seen."""

    what: str
    level: Level
    spans: tuple[tuple[float, float], ...]
    count: int | None = None

    @property
    def times(self) -> int:
        """How often it happened."""
        return len(self.spans) if self.count is None else self.count

    @property
    def total_s(self) -> float:
        """How long all together."""
        return sum(duration for _, duration in self.spans)

    @property
    def longest(self) -> tuple[float, float]:
        """Start and duration of the longest time."""
        return max(self.spans, key=lambda span: span[1])


def covered_s(troubles: Iterable[Trouble]) -> float:
    """How long there was one of them at least, s."""
    covered, until = 0.0, -np.inf
    for start, lasted in sorted(span for each in troubles for span in each.spans):
        end = start + lasted
        covered += max(end - max(start, until), 0.0)
        until = max(until, end)
    return covered


def find_troubles(drive: Drive) -> list[Trouble]:
    """All of them: the worst level first, and in each the longest first."""
    found = [*_silences(drive), *_reasons(drive), *_flagged(drive), *_counted(drive)]
    return sorted(found, key=lambda each: (LEVELS.index(each.level), -each.total_s, -each.times))


def stretches(seconds: Floats, on: Bools, joined_s: float = JOINED_S) -> list[tuple[float, float]]:
    """(start, duration) of each stretch of samples at `seconds` (n,) in which `on` (n,) holds, up
    to the sample after it; pauses shorter than `joined_s` are none."""
    last = len(seconds) - 1
    found: list[tuple[float, float]] = []
    for first, after in runs(on):
        begin, end = float(seconds[first]), float(seconds[min(after, last)])
        if found and begin - sum(found[-1]) < joined_s:
            begin = found.pop()[0]
        found.append((begin, end - begin))
    return found


def _silences(drive: Drive) -> Iterable[Trouble]:
    seconds = drive.clock(drive.log["odometry"]["utime"])
    gaps = np.diff(seconds)
    spans = tuple((float(seconds[i]), float(gaps[i])) for i in np.flatnonzero(gaps > SILENT_S))
    if spans:
        yield Trouble("no pose was published", "failed", spans)


def _reasons(drive: Drive) -> Iterable[Trouble]:
    """The reasons in STATUS. Reasons of several levels can stand in one message, so a reason is as
    bad as the best health that it was told with."""
    if "status" not in drive.log:
        return
    levels: tuple[Level, ...] = ("note", "degraded", "failed")
    kinds: dict[str, tuple[str, int, list[int]]] = {}
    messages = drive.log["status"]["messages"]
    for row, status in enumerate(messages):
        for reason in status.reasons:
            key = re.sub(r"\d+(?:\.\d+)?", "N", reason)  # the figures in it change
            text, level, rows = kinds.setdefault(key, (reason, int(status.health), []))
            rows.append(row)
            kinds[key] = (text, min(level, int(status.health)), rows)
    seconds = drive.clock(drive.log["status"]["utime"])
    seconds = np.append(seconds, seconds[-1:] + STATUS_S)
    for text, level, rows in kinds.values():
        told = np.zeros(len(seconds), bool)
        told[rows] = True
        at_start = seconds[max(rows)] <= 0  # while it waits for the first pose nothing is wrong
        spans = tuple(stretches(seconds, told, STATUS_S))
        yield Trouble(text, "note" if at_start else levels[level], spans)


def _flagged(drive: Drive) -> Iterable[Trouble]:
    odometry = drive.log["odometry"]
    seconds = drive.clock(odometry["utime"])
    for name, bit in flag_bits().items():
        if name in FLAGS:
            spans = stretches(seconds, (odometry["flags"] & bit) != 0)
            if spans:
                level, text = FLAGS[name]
                yield Trouble(text, level, tuple(spans))


def _counted(drive: Drive) -> Iterable[Trouble]:
    """Events that STATUS counts by channel, with the seconds in which the counts rose. What is told
    as a flag is left out."""
    if "status" not in drive.log:
        return
    counts: dict[str, list[tuple[float, float]]] = {}
    for second, status in zip(
        drive.clock(drive.log["status"]["utime"]), drive.log["status"]["messages"], strict=True
    ):
        for name, value in zip(status.names, status.values, strict=True):
            if ": " in name and ": slip: " not in name:
                counts.setdefault(name, []).append((float(second), float(value)))
    for name, seen in counts.items():
        before = 0.0  # the first STATUS of a recording tells what was counted since the start
        rises = np.zeros(len(seen), bool)
        total = 0
        for row, (_, value) in enumerate(seen):
            risen = value - before if value >= before else value  # a reset begins anew
            rises[row] = risen > 0
            total += int(risen)
            before = value
        if total:
            seconds = np.array([second for second, _ in seen])
            spans = [(second - STATUS_S, STATUS_S) for second in seconds[rises]]
            yield Trouble(name, "note", tuple(spans), total)


def health_spans(drive: Drive) -> dict[str, list[tuple[float, float]]]:
    """(start, duration), s, of each stretch of one health, by its name, worst last."""
    if "status" not in drive.log:
        return {}
    seconds = drive.clock(drive.log["status"]["utime"])
    values = np.array([int(status.health) for status in drive.log["status"]["messages"]])
    seconds = np.append(seconds, seconds[-1:] + STATUS_S)
    return {
        health(int(value)): stretches(seconds, np.append(values == value, False), 0.0)
        for value in np.unique(values)
    }
