"""Fixes made from the truth of a drive, with noise and faults of GNSS; the same for a seed."""

import heapq
from collections.abc import Sequence
from dataclasses import dataclass, replace
from operator import itemgetter
from pathlib import Path

import numpy as np

from gprodom.arrays import Bools, Floats, Ints
from gprodom.files import replacing
from gprodom.fixes.record import Fixes, Frame, Quality, diagonal
from gprodom.geodesy import Datum
from gprodom.lcm import EventLog
from gprodom.lcm.log_scan import events
from gprodom.lcm.log_writer import Stream
from gprodom.random_streams import stream
from gprodom.trajectory import Trajectory, path_length

DATUM = Datum(52.39, 13.06, 40.0)  # where the truth's frame is put, where fixes are in degrees
_ALONG_M = 0.5  # steps in which the truth's way is measured


@dataclass(frozen=True)
class Noise:
    """Error of each axis, standard deviation in m; of a Gauss-Markov process with that correlation
    time (s), or white where it is 0. The vertical one is twice as large."""

    sigma_m: float
    correlation_s: float = 0.0
    quality: Quality = Quality.FIXED


CENTIMETRES = Noise(0.03)
METRES = Noise(1.0, 100.0, Quality.SINGLE)


def errors(utime: Ints, noise: Noise, seed: int) -> Floats:
    """Of fixes at these times (n, 3), m."""
    random = stream(seed, "position fixes").standard_normal((len(utime), 3))
    random *= noise.sigma_m * np.array([1.0, 1.0, 2.0])
    if noise.correlation_s <= 0 or not len(utime):
        return np.asarray(random)
    kept = np.exp(-np.diff(utime) * 1e-6 / noise.correlation_s)
    found = random.copy()
    for i, share in enumerate(kept.tolist(), start=1):
        found[i] = share * found[i - 1] + np.sqrt(1 - share**2) * random[i]
    return found


def fixes_of_truth(truth: Trajectory, noise: Noise, seed: int, interval_s: float = 0.2) -> Fixes:
    """Fixes in `site`, which is the truth's frame, at most one in `interval_s`. Their covariance
    is that of the noise: nothing in it tells how long errors last."""
    slot = (truth.time - truth.time[0]) // round(interval_s * 1e6)
    chosen = truth.select(np.flatnonzero(np.diff(slot, prepend=-1)))
    position = chosen.position + errors(chosen.time, noise, seed)
    sigmas = np.tile(noise.sigma_m * np.array([1.0, 1.0, 2.0]), (len(chosen), 1))
    quality = np.full(len(chosen), int(noise.quality), np.int64)
    return Fixes(chosen.time, Frame.SITE, position, diagonal(sigmas), quality)


def share_of_way(truth: Trajectory, utime: Ints) -> Floats:
    """What part of the truth's way has been driven at these times (n,), 0 to 1."""
    way = path_length(truth.position[:, :2], _ALONG_M)
    return np.asarray(np.interp(utime, truth.time, way) / max(float(way[-1]), 1e-9))


def within(shares: Floats, spans: Sequence[tuple[float, float]]) -> Bools:
    """Which of the shares (n,) lie in one of the spans."""
    inside = [(shares >= low) & (shares <= high) for low, high in spans]
    return np.asarray(np.any(inside, axis=0))


ENDS = ((0.0, 0.1), (0.9, 1.0))  # the first and the last tenth of the way

# ---- faults ----

JUMP_M = 3.0
WALK_M = 5.0  # of a receiver that has just found its satellites again
WALK_S = 15.0  # time constant in which that error goes
REPLAY_S = 30.0
DATUM_M = np.array([85.0, -120.0, 0.0])  # as between ED50 and WGS 84 in central Europe
FAULTS = {
    "jump": f"positions {JUMP_M:g} m aside, as good by their own word as before",
    "outage": "no position (quality none), as good as before afterwards",
    "reacquisition": f"no position in the first half; then {WALK_M:g} m off, which goes in some "
    f"{WALK_S:g} s, with the quality of before",
    "drag_1": "drawn aside at 1 cm/s, and back at once",
    "drag_10": "drawn aside at 10 cm/s, and back at once",
    "replay": f"positions of {REPLAY_S:g} s before, with stamps of now",
    "swapped": "latitude and longitude swapped",
    "datum": "in another datum, 147 m aside, from then on",
}


def with_fault(fixes: Fixes, fault: str, begin: int, end: int, seed: int) -> Fixes:
    """Fixes in degrees (round `DATUM`) that have one of `FAULTS` between two times (us)."""
    local = fixes.in_site(DATUM).copy()
    quality = fixes.quality.copy()
    since = (fixes.utime - begin) * 1e-6
    inside = (fixes.utime >= begin) & (fixes.utime < end)
    angle = stream(seed, "fault").uniform(0, 2 * np.pi)
    aside = np.array([np.cos(angle), np.sin(angle), 0.0])
    if fault == "jump":
        local[inside] += JUMP_M * aside
    elif fault in ("outage", "reacquisition"):
        half = begin + (end - begin) // 2
        lost = inside & ((fixes.utime < half) | (fault == "outage"))
        quality[lost] = Quality.NONE
        if fault == "reacquisition":
            again = inside & ~lost
            gone = np.exp(-(fixes.utime[again] - half) * 1e-6 / WALK_S)
            local[again] += WALK_M * gone[:, None] * aside
    elif fault in ("drag_1", "drag_10"):
        local[inside] += 0.01 * float(fault.split("_")[1]) * since[inside, None] * aside
    elif fault == "replay":
        before = np.searchsorted(fixes.utime, fixes.utime[inside] - round(REPLAY_S * 1e6))
        local[inside] = local[before]
    elif fault == "datum":
        local[fixes.utime >= begin] += DATUM_M
    elif fault != "swapped":
        raise ValueError(fault)
    position = DATUM.to_geographic(local)
    if fault == "swapped":
        position[inside] = position[inside][:, [1, 0, 2]]
    position[quality == Quality.NONE] = 0.0
    return replace(fixes, frame=Frame.GEODETIC, position=position, quality=quality)


def in_degrees(fixes: Fixes) -> Fixes:
    """The same fixes, in `site`, as latitude, longitude and height."""
    return replace(fixes, frame=Frame.GEODETIC, position=DATUM.to_geographic(fixes.position))


# ---- logs ----


def add_to_log(log: Path, output: Path, added: Sequence[Stream]) -> None:
    """A copy of a log with more messages, each before the first that is stamped later there."""
    more = heapq.merge(
        *(
            [(time, one.channel, data) for time, data in zip(times, one.payloads, strict=True)]
            for one in added
            for times in [one.utime.tolist()]
        ),
        key=itemgetter(0),
    )
    with replacing(output) as part:
        written = EventLog(str(part), "w", overwrite=True)
        waiting = next(more, None)
        for channel, stamp, data in events(log):
            while waiting is not None and waiting[0] < stamp:
                written.write_event(*waiting)
                waiting = next(more, None)
            written.write_event(stamp, channel, data)
        while waiting is not None:
            written.write_event(*waiting)
            waiting = next(more, None)
        written.close()
