"""Scores standstill, slip and coherence of a replay against the truth beside the sequence.

A sequence needs `.json` (slip episodes: start s, duration s, wheel factor) and `.truth.npz` (t, s
along the track, v) beside it, as `gprodom simulate` writes them; the estimator sees neither.
"""

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from gprodom import gpr
from gprodom.arrays import Bools, Floats, runs
from gprodom.convert.cmu import read_recording
from gprodom.convert.sampling import SAMPLE_INTERVAL
from gprodom.convert.streams import streams
from gprodom.lcm import logs
from gprodom.lcm.constants import flag, kind
from gprodom.lcm.log_writer import write_log
from gprodom.odometry.estimate import estimate
from gprodom.odometry.methods import find_method
from gprodom.score.align import FIRST_M
from gprodom.score.associate import associate
from gprodom.score.figures import compare
from gprodom.score.sources import read_truth
from gprodom.trajectory import Trajectory

STANDING = 0.005  # m/s
SHORTEST = 1.0  # s of standstill
EDGE = 0.2  # s of standstill left out at its edges
PROMPT = 0.5  # s from the start of a slip; from any slip to a false flag
LEAST = 0.1  # m over which the coherence is scored


@dataclass(frozen=True)
class Truth:
    """Times (s), distance along the track (m), speed (m/s); slip episodes (n, 2), begin and end
    (s).
    """

    t: Floats
    s: Floats
    speed: Floats
    slips: Floats

    def path(self, times: Floats) -> Floats:
        """Unsigned distance (m) up to `times` (s)."""
        steps = np.abs(np.diff(self.s, prepend=self.s[0]))
        return np.asarray(np.interp(times, self.t, np.cumsum(steps)))


@dataclass(frozen=True)
class Standing:
    """Figures of standstill: shares, and metres moved within a detection."""

    recall: float
    flagged: float
    false: float
    unseen_mm: float


@dataclass(frozen=True)
class Outcome:
    """Figures of one sequence."""

    sequence: str
    standing: Standing
    episodes: int
    prompt: int
    false_flags: int
    metres: float
    coherence_error: float
    coherence_covered: float
    coherence_spans: int
    rmse: dict[str, float]
    told: list[list[float]]  # of each span: true way, coherence's distance and its sigma, m


def joined(spans: Floats) -> Floats:
    """Spans (n, 2) in time order, with overlapping ones merged."""
    result: list[list[float]] = []
    for start, end in sorted(spans.tolist()):
        if result and start <= result[-1][1]:
            result[-1][1] = max(result[-1][1], end)
        else:
            result.append([start, end])
    return np.array(result).reshape(-1, 2)


def read_beside(sequence: Path) -> tuple[Truth, float]:
    """Truth and radar sample interval (s) from the files beside a sequence."""
    facts = json.loads(sequence.with_suffix(".json").read_text())
    truth = np.load(sequence.with_suffix(".truth.npz"))
    t = truth["t"]
    starts = np.array([[start, start + duration] for start, duration, _ in facts["slip"]])
    slips = joined(t[0] + starts.reshape(-1, 2))
    interval = facts.get("gpr_sample_interval", SAMPLE_INTERVAL)
    return Truth(t, truth["s"], np.abs(truth["v"]), slips), interval


def covered(t: Floats, spans: Floats) -> Bools:
    """Which of `t` lie in one of the spans (n, 2)."""
    result = np.zeros(len(t), bool)
    for start, end in spans:
        result[np.searchsorted(t, start) : np.searchsorted(t, end, "right")] = True
    return result


def judge_standing(claims: Floats, flagged: Bools, alive: Bools, truth: Truth) -> Standing:
    """Scores the radar's standstills (n, 2), s, and the published flag at the truth's times."""
    t, standing = truth.t, truth.speed < STANDING
    inner = np.zeros(len(t), bool)
    for first, end in runs(standing):
        if t[end - 1] - t[first] >= SHORTEST:
            inner |= (t >= t[first] + EDGE) & (t <= t[end - 1] - EDGE)
    claimed = covered(t, claims)
    unseen = [abs(np.interp(b, t, truth.s) - np.interp(a, t, truth.s)) for a, b in claims]
    return Standing(
        float(claimed[inner & alive].mean()),
        float(flagged[inner].mean()),
        float(claimed[~standing].mean()),
        1e3 * max(unseen, default=0.0),
    )


def judge_slips(t: Floats, flagged: Bools, slips: Floats) -> tuple[int, int]:
    """Episodes flagged within PROMPT of their start; flags (runs) away from any episode."""
    prompt = sum(bool(flagged[(t >= start) & (t <= start + PROMPT)].any()) for start, _ in slips)
    near = covered(t, slips + np.array([-PROMPT, PROMPT]))
    false = sum(not near[first:end].any() for first, end in runs(flagged))
    return prompt, false


def coherence_spans(content: logs.Channel, truth: Truth) -> Floats:
    """(n, 3): true distance, coherence's distance and its standard deviation, m, of each published
    span.
    """
    told = content["valid"] & (content["source"] == "coherence")
    start, end = content["utime_from"][told] * 1e-6, content["utime_to"][told] * 1e-6
    moved = truth.path(end) - truth.path(start)
    return np.stack([moved, content["distance"][told], content["sigma"][told]], axis=1)


def judge_coherence(told: Floats) -> tuple[float, float, int]:
    """RMS relative error, share within two standard deviations, number of distances."""
    moved, distance, sigma = told[told[:, 0] >= LEAST].T
    if len(moved) == 0:
        return float("nan"), float("nan"), 0
    error = distance - moved
    inside = np.abs(error) <= 2 * sigma
    return float(np.sqrt(np.mean((error / moved) ** 2))), float(inside.mean()), len(moved)


def rmse(trajectory: Trajectory, truth: Trajectory) -> float:
    """RMS distance (m) after SE(2) alignment."""
    return compare(associate(trajectory, truth), "se2", FIRST_M).figures.ate_rmse_m


def measure(sequence: Path, overrides: list[str], folder: Path) -> Outcome:
    """Replays a sequence by each method and scores what was published."""
    truth, interval = read_beside(sequence)
    recording = read_recording(sequence)
    log, output = folder / "in.lcmlog", folder / "out.lcmlog"
    write_log(log, streams(recording, interval))
    total_station = read_truth(log).trajectory
    errors = {
        name: rmse(
            estimate(log, find_method(name), (), overrides, output).trajectory, total_station
        )
        for name in ("wheel", "imu_wheel", "gprodom")  # the last one's output stays
    }
    said = logs.read(output, ["ODOMETRY", "GPR_DISPLACEMENT"])
    radar, odometry = said["GPR_DISPLACEMENT"], said["ODOMETRY"]
    is_claim = radar["valid"] & (radar["kind"] == kind("MOTION")) & (radar["distance"] == 0)
    claims = np.stack([radar["utime_from"], radar["utime_to"]], axis=1)[is_claim] * 1e-6
    t, flags = odometry["utime"] * 1e-6, odometry["flags"]
    at = np.clip(np.searchsorted(t, truth.t), 0, len(t) - 1)
    nearest = np.searchsorted(recording.gpr_utime * 1e-6, truth.t)
    dead = gpr.check_traces(recording.traces) == 1
    alive = ~dead[np.clip(nearest, 0, len(dead) - 1)]
    prompt, false = judge_slips(t, (flags & flag("SLIPPING")) != 0, truth.slips)
    told = coherence_spans(radar, truth)
    return Outcome(
        sequence.stem,
        judge_standing(claims, (flags[at] & flag("STANDING")) != 0, alive, truth),
        len(truth.slips),
        prompt,
        false,
        float(truth.path(truth.t[-1:])[0]),
        *judge_coherence(told),
        errors,
        told.tolist(),
    )
