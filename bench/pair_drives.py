"""Simulated drives with two antennas in a row, and what the estimator's pair says on them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from gprodom.arrays import Floats, Ints
from gprodom.files import temporary_folder
from gprodom.ground.survey import FULL_SCALE, Survey, find_survey, shipped, write_survey
from gprodom.lcm import logs
from gprodom.lcm.log_writer import write_log
from gprodom.odometry.methods import find_method
from gprodom.odometry.replay import run_replay
from gprodom.random_streams import stream
from gprodom.simulate.antennas import AntennaSpec, draw_antennas
from gprodom.simulate.drive import Bend, DriveSpec, Move, Stop, Track
from gprodom.simulate.recording import log_streams
from gprodom.simulate.robot import RADAR
from gprodom.simulate.sequence import Simulated, Spec, SurveySpec, simulate
from gprodom.simulate.wheel import WheelSpec

GROUNDS = ("fdtd", "beach", "field")
STANDSTILL_S = 4.0
TRUE_WHEEL = WheelSpec(scale_sigma=0.0, scale_walk=0.0, noise=0.0, quantum=1e-4)
_ASIDE_M = 0.2  # between real lines
_BEACH_SAMPLES = 201
_SLOWEST = 1e8  # m/s, of waves in sand and dry soil


def make_ground(name: str, seed: int, data: Path) -> Survey:
    """Closed ground of its own for each seed: FDTD lines begun anywhere, or two neighbouring real
    lines, driven over to and fro without turning. data: folder real_ground."""
    draw = stream(seed, f"pair ground {name}")
    if name == "fdtd":
        survey = find_survey(shipped()[seed % len(shipped())])
        begin = int(draw.randint(survey.lines.shape[1]))
        return replace(survey, lines=np.roll(survey.lines, begin, axis=1))
    if name == "beach":
        first = int(draw.randint(1, 20))
        files = [np.load(data / f"seal_beach/line_{first + k:02}.npz") for k in (0, 1)]
        count = min(len(file["traces"]) for file in files)
        lines = np.array([file["traces"][:count, :_BEACH_SAMPLES] for file in files])
        spacing, interval = float(files[0]["spacing"]), float(files[0]["sample_interval"])
    else:
        file = np.load(data / "field/lines.npz")
        first = int(draw.randint(len(file["traces"]) - 1))
        lines = file["traces"][first : first + 2]
        spacing, interval = float(file["spacing"]), float(file["sample_interval"])
    there_and_back = np.concatenate([lines, lines[:, ::-1]], axis=1).astype(np.float64)
    lines = _without_recorded_noise(there_and_back, spacing, interval)
    loudest = np.quantile(np.abs(lines).max(axis=2), 0.999)  # a few traces are glitches
    lines = np.clip(np.rint(lines * (FULL_SCALE / loudest)), -32768, 32767).astype(np.int16)
    return Survey(name, lines, spacing, np.array([0.0, _ASIDE_M]), interval, 0.0)


def _without_recorded_noise(lines: Floats, spacing: float, interval: float) -> Floats:
    """Lines (k, n, samples) less what is no echo: at a frequency, an echo's phase turns along the
    track by there and back at the speed of waves at most. Else both antennas would see the noise
    of the recording, as if it were ground of the finest grain."""
    spectrum = np.fft.rfft2(lines, axes=(1, 2))
    along = np.abs(np.fft.fftfreq(lines.shape[1], spacing))[:, None]  # 1/m
    frequency = np.fft.rfftfreq(lines.shape[2], interval)  # Hz
    spectrum *= along <= 2 * frequency / _SLOWEST
    spectrum[:, 0] = np.fft.rfft2(lines, axes=(1, 2))[:, 0]  # the mean trace stays
    return np.asarray(np.fft.irfft2(spectrum, lines.shape[1:], axes=(1, 2)))


def strength(survey: Survey) -> float:
    """RMS of what changes along the first line, counts."""
    line = survey.lines[0].astype(np.float64)
    return float(np.std(line - line.mean(axis=0)))


def antennas_in_a_row(
    seed: int, b_m: float, aside_m: float, noise: float
) -> tuple[AntennaSpec, ...]:
    """Two with faults of their own, `b_m` apart and the rear one aside, truly as told.

    noise: counts at the ground's own gain.
    """
    drawn = draw_antennas(
        [(b_m / 2, 0.0), (-b_m / 2, aside_m)], RADAR, stream(seed, "pair antennas")
    )
    return tuple(
        replace(each, radar=replace(each.radar, lever_arm=each.told, noise=each.gain * noise))
        for each in drawn
    )


def straight(steps: Sequence[Move | Stop]) -> DriveSpec:
    """A straight track, after a standstill."""
    return DriveSpec(Track((Bend(1000.0),)), (Stop(STANDSTILL_S), *steps, Stop(1.0)))


def to_and_fro(distance_m: float, speed: float, draw: np.random.RandomState) -> DriveSpec:
    """The same with stops of 1 to 4 s, and every third piece backwards."""
    steps: list[Move | Stop] = []
    left, back = distance_m, False
    while left > 0:
        way = min(left, draw.uniform(1.0, 2.0) if back else draw.uniform(2.0, 5.0))
        steps += [Move(-way if back else way, speed), Stop(draw.uniform(1.0, 4.0))]
        left, back = left - way, draw.uniform() < 1 / 3
    return straight(steps)


def drive(
    spec: DriveSpec,
    survey: Survey,
    antennas: tuple[AntennaSpec, ...],
    seed: int,
    rate: float = 20.0,
    wheel: WheelSpec = TRUE_WHEEL,
) -> Simulated:
    """The drive. Its wheel tells the truth, unless another is given."""
    with temporary_folder() as folder:
        path = folder / "ground.npz"
        write_survey(path, survey)
        return simulate(
            Spec(
                spec,
                wheel=wheel,
                radar=replace(antennas[0].radar, rate=rate),
                antennas=antennas,
                ground=SurveySpec(str(path)),
            ),
            seed,
        )


@dataclass(frozen=True)
class Passages:
    """What the pair said on a drive, and what is true: of each passage (n,)."""

    told: Floats  # m along the track, signed
    true: Floats  # m
    sigma: Floats  # m
    time: Floats  # s from the start, of its end
    reasons: tuple[str, ...]  # that STATUS gave during the drive, once each

    @property
    def wrong(self) -> Ints:
        """Those that are wrong by more than 3 sigma and 2 cm."""
        error = np.abs(self.told - self.true)
        return np.flatnonzero((error > 3 * self.sigma) & (error > 0.02))


def antennas_setting(antennas: Sequence[AntennaSpec]) -> str:
    """The setting gpr.antennas, as told."""
    places = ", ".join(f"{i}: [{a.told[0]}, {a.told[1]}, 0]" for i, a in enumerate(antennas))
    return f"gpr.antennas={{{places}}}"


def passages(
    simulated: Simulated, settings: Sequence[str] = (), method: str = "gprodom"
) -> Passages:
    """Replays a drive and reads its passages."""
    told = antennas_setting(simulated.spec.antennas)
    with temporary_folder() as folder:
        log, output = folder / "in.lcmlog", folder / "out.lcmlog"
        write_log(log, log_streams(simulated))
        run_replay(log, output, (), (*find_method(method).overrides, told, *settings))
        read = logs.read(output, ["GPR_DISPLACEMENT", "STATUS"])
    said = dict.fromkeys(r for each in read["STATUS"]["messages"] for r in each.reasons)
    found = read.get("GPR_DISPLACEMENT")
    if found is None:
        return Passages(*np.zeros((4, 0)), tuple(said))
    mine = np.array([source == "pair" for source in found["source"]]) & found["valid"]
    ends = [simulated.motion_at(found[key][mine]).s for key in ("utime_from", "utime_to")]
    return Passages(
        found["distance"][mine],
        ends[1] - ends[0],
        found["sigma"][mine],
        (found["utime_to"][mine] - simulated.spec.start_utime) * 1e-6,
        tuple(said),
    )
