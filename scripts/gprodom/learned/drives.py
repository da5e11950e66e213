"""Examples to train on from recorded sequences: the way between traces is that of the truth."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from gprodom.arrays import Bools, Floats
from gprodom.convert.cmu import read_recording
from gprodom.errors import Error
from gprodom.learned.examples import REACH, Examples, joined
from gprodom.learned.windows import COLUMN, LENGTH, MOST_STEP, WINDOW, image, step_at, to_rows
from gprodom.random_streams import Random, stream

THINNED = (1, 2, 4)  # all traces, every second, every fourth: trace rates apart from the speed
# s, standard deviation of the kernel over the truth's positions; a longer one rounds off reversals.
_SMOOTH_S = 0.1
_GAP_S = 1.0  # s; no example lies across a longer gap of traces or truth
_MOVES = 0.03  # m/s
_EVERY = 0.3  # m, from an image to the next
_BESIDE = 0.12  # m; pairs so close side by side show the same ground
_PARALLEL = math.radians(10)
_MOST = 400  # pairs of a sequence on the same ground, and as many on different ground


@dataclass(frozen=True)
class Drive:
    """Of each trace: rows, time (s), position (m), the way until then (m), and the velocity."""

    rows: Floats
    time: Floats
    position: Floats  # (n, 2)
    way: Floats
    velocity: Floats  # (n, 2), m/s


def drive_examples(sequences: list[Path], on_sequence: Callable[[], None]) -> list[Examples]:
    """Of each sequence."""
    made = []
    for path in sequences:
        drive, random = read_drive(path), stream(0, f"learned drive {path.name}")
        made.append(joined([*by_windows(drive, random), by_images(drive, random)]))
        on_sequence()
    return made


def read_drive(sequence: Path) -> Drive:
    """The traces of a sequence for which there is truth."""
    from scipy.ndimage import gaussian_filter1d

    recording = read_recording(sequence)
    if len(recording.truth_utime) < 2 or not len(recording.traces):
        raise Error(f"{sequence}: expected a sequence with radar and truth, to train on")
    time, known = recording.gpr_utime * 1e-6, recording.truth_utime * 1e-6
    after = np.clip(np.searchsorted(known, time), 1, len(known) - 1)
    near = (known[after] - known[after - 1] < _GAP_S) & (time >= known[0]) & (time <= known[-1])
    time, traces = time[near], recording.traces[near]
    if len(time) < 2 * WINDOW:
        raise Error(f"{sequence}: expected truth while the radar runs, to train on")
    rate = 1 / float(np.median(np.diff(time)))
    position = np.column_stack([np.interp(time, known, x) for x in recording.truth[:, :2].T])
    position = gaussian_filter1d(position, _SMOOTH_S * rate, axis=0)
    steps = np.linalg.norm(np.diff(position, axis=0, prepend=position[:1]), axis=1)
    return Drive(
        to_rows(traces, recording.sample_interval),
        time,
        position,
        np.cumsum(steps),
        np.gradient(position, time, axis=0),
    )


def by_windows(drive: Drive, random: Random) -> list[Examples]:
    """Two consecutive windows and the mean way from trace to trace, at each of the rates."""
    made = []
    for every in THINNED:
        rows, time, way = (x[::every] for x in (drive.rows, drive.time, drive.way))
        rate = 1 / float(np.median(np.diff(time)))
        end = WINDOW + MOST_STEP
        before, after, spacing, steps = [], [], [], []
        while end <= len(rows):
            step = int(np.clip(round(step_at(rate) * random.uniform(0.7, 1.4)), 4, WINDOW))
            begin = end - step - WINDOW
            if np.diff(time[begin:end]).max() < _GAP_S:
                before.append(rows[begin : end - step])
                after.append(rows[end - WINDOW : end])
                spacing.append((way[end - 1] - way[end - 1 - step]) / step)
                steps.append(step)
            end += step
        if before:
            made.append(
                {
                    "before": np.array(before, np.float16),
                    "after": np.array(after, np.float16),
                    "spacing": np.array(spacing),
                    "step": np.array(steps),
                }
            )
    return made


def by_images(drive: Drive, random: Random) -> Examples:
    """Pairs of images of different passes, where the truth puts the second one from the first, and
    whether both show the same ground; both run as the first one was driven."""
    pictures, places = _images(drive)
    if len(pictures) < 2:
        return {}
    x, y, heading, way = np.array(places).T
    first, second = np.nonzero(np.subtract.outer(way, way).T > 1.5 * LENGTH)
    turn = heading[second] - heading[first]
    apart = np.column_stack([x[second] - x[first], y[second] - y[first]])
    ahead = np.column_stack([np.cos(heading[first]), np.sin(heading[first])])
    along = (apart * ahead).sum(1)
    beside = np.abs(apart[:, 1] * ahead[:, 0] - apart[:, 0] * ahead[:, 1])
    same = (np.abs(along) < REACH) & (beside < _BESIDE) & (np.abs(np.sin(turn)) < _PARALLEL)
    other = np.hypot(along, beside) > 2 * LENGTH
    chosen = _some(same, _MOST, random)
    chosen = np.concatenate([chosen, _some(other, len(chosen), random)])
    against = np.cos(turn) < 0
    query = [pictures[second[i]][:, :: -1 if against[i] else 1] for i in chosen]
    if not query:
        return {}
    return {
        "memory": np.array([pictures[first[i]] for i in chosen], np.float16),
        "query": np.array(query, np.float16),
        "offset": np.where(same, along, 0.0)[chosen],
        "same": same[chosen].astype(float),
    }


def _some(which: Bools, most: int, random: Random) -> np.ndarray:
    return np.asarray(random.permutation(np.flatnonzero(which))[:most])


def _images(drive: Drive) -> tuple[list[Floats], list[tuple[float, float, float, float]]]:
    """Images of the stretches driven one way; of each the middle's position, heading and way."""
    moves = np.linalg.norm(drive.velocity, axis=1) > _MOVES
    turned = (drive.velocity[1:] * drive.velocity[:-1]).sum(1) < 0
    cut = ~(moves[1:] & moves[:-1]) | turned | (np.diff(drive.time) > _GAP_S)
    pictures, places = [], []
    for part in np.split(np.arange(len(drive.way)), np.flatnonzero(cut) + 1):
        way = drive.way[part]
        if way[-1] - way[0] < LENGTH or np.diff(way).max() > 5 * COLUMN:
            continue
        for start in np.arange(way[0], way[-1] - LENGTH, _EVERY):
            middle = start + LENGTH / 2
            pictures.append(image(drive.rows[part], way, start))
            x, y = (float(np.interp(middle, way, p)) for p in drive.position[part].T)
            u, v = (float(np.interp(middle, way, p)) for p in drive.velocity[part].T)
            places.append((x, y, math.atan2(v, u), middle))
    return pictures, places
