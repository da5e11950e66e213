"""A job: one method on one sequence. Its results are kept, so that a later run can continue."""

import fcntl
import hashlib
import json
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from gprodom.benchmark.curves import Curves, measure_curves
from gprodom.calibrate.k import Fit, Shifts, fit_k, measure_shifts
from gprodom.config import Channels, config_files, read_channels
from gprodom.errors import Error
from gprodom.files import replacing, temporary_folder, write_text
from gprodom.lcm import logs
from gprodom.odometry.displacement import Displacements, reckon
from gprodom.odometry.estimate import Estimate, as_log, estimate
from gprodom.odometry.method import Method
from gprodom.odometry.replay import find_program
from gprodom.own_code import digest_of_code
from gprodom.score.align import Alignment
from gprodom.score.associate import associate
from gprodom.score.figures import Comparison, compare
from gprodom.score.frames import FrameStart, in_last_frame
from gprodom.score.jumps import MapJumps
from gprodom.score.record import Mode, Record, make_record, scene_of
from gprodom.score.sources import known_truth
from gprodom.trajectory import Trajectory, write_tum

CAUSAL = "causal"
SMOOTHED = "smoothed"


@dataclass(frozen=True)
class Sequence:
    """A sequence of the benchmark and where its results go."""

    name: str
    source: Path
    folder: Path
    sample_interval: float | None  # s, of the radar; None: what the sequence says

    @property
    def scene(self) -> str:
        """The scene in the name; all sequences without one form one scene."""
        return scene_of(self.name)

    @property
    def log(self) -> Path:
        """Its converted log, while the benchmark runs."""
        return self.folder / "input.lcmlog"


@dataclass(frozen=True)
class Settings:
    """What all jobs of a benchmark share."""

    configs: tuple[Path, ...]
    overrides: tuple[str, ...]
    align: Alignment
    first_m: float

    @property
    def channels(self) -> Channels:
        """The channels' names."""
        return read_channels(self.configs, self.overrides)


@dataclass(frozen=True)
class Outcome:
    """Result of one job: records, causal first, and curves of the causal one (none without
    truth), or a failure."""

    sequence: str
    method: str
    records: tuple[Record, ...] = ()
    curves: Curves | None = None
    failure: str = ""
    k: Fit | None = None
    fitted_on: tuple[str, ...] = ()  # the sequences of K


def fingerprint(sequence: Sequence, method: Method, settings: Settings, *more: object) -> str:
    """A fingerprint of everything that the result depends on."""
    facts: list[object] = [sequence.sample_interval, method, settings, digest_of_code(), *more]
    facts.append(_stamp(sequence.source))
    if method.reckoned != "wheel":
        facts.append(_stamp(find_program()))
        facts += [file.read_text(encoding="utf-8") for file in config_files(settings.configs)]
    if method.source is not None:
        facts.append(_stamp(method.source))
    return hashlib.sha256(repr(facts).encode()).hexdigest()


def _newest(path: Path) -> float:
    files = path.rglob("*.csv") if path.is_dir() else [path]
    return max((file.stat().st_mtime for file in files), default=0.0)


def _stamp(path: Path) -> list[tuple[str, int, int]]:
    files = sorted(path.rglob("*.csv")) if path.is_dir() else [path]
    stats = [(file.name, file.stat()) for file in files]
    return [(name, stat.st_size, stat.st_mtime_ns) for name, stat in stats]


def convert(sequence: Sequence, channels: Channels) -> None:
    """Makes the sequence's log, of `channels`, unless it is there.

    If several jobs need it, one of them makes it.
    """
    with (sequence.folder / ".lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        log, source = sequence.log, sequence.source
        # The log of an interrupted run can be used, unless the sequence has changed since.
        if log.exists() and not log.is_symlink() and log.stat().st_mtime < _newest(source):
            log.unlink()
        if not log.exists():
            made = as_log(source, sequence.folder, sequence.sample_interval, channels)
            if made != sequence.log:
                sequence.log.symlink_to(made.resolve())


def clean(sequence: Sequence) -> None:
    """Removes files that only the jobs needed."""
    for name in (sequence.log.name, ".lock"):
        (sequence.folder / name).unlink(missing_ok=True)


def shifts_path(sequence: Sequence, front_end: str) -> Path:
    """Where the shifts of a front end on a sequence are kept."""
    return sequence.folder / f"{front_end}.shifts.npz"


def save_shifts(sequence: Sequence, method: Method, settings: Settings) -> None:
    """Measures the shifts of the method's front end, unless they are already stored."""
    path = shifts_path(sequence, method.front_end)
    key = fingerprint(sequence, method, settings)
    if path.exists() and str(np.load(path)["key"]) == key:
        return
    path.unlink(missing_ok=True)  # shifts of another configuration must not be used for this one
    convert(sequence, settings.channels)
    with temporary_folder() as folder:
        output = folder / "output.lcmlog"
        truth = known_truth(sequence.source)
        overrides = settings.overrides
        shifts = measure_shifts(sequence.log, method, settings.configs, overrides, truth, output)
    with replacing(path) as part, part.open("wb") as file:
        np.savez(file, key=key, **vars(shifts))


def load_shifts(sequence: Sequence, front_end: str) -> Shifts:
    """Reads what `save_shifts` has stored."""
    path = shifts_path(sequence, front_end)
    if not path.exists():
        raise Error(f"the shifts of {front_end} on {sequence.name} could not be measured")
    with np.load(path) as data:
        return Shifts(*(data[name] for name in ("start", "end", "shift", "distance")))


def fit_on_others(
    sequence: Sequence, method: Method, others: list[Sequence]
) -> tuple[Fit, tuple[str, ...]]:
    """K for `sequence`, and the names of the sequences that it is fitted on: of `others` those of
    its scene that have shifts; where there is none, or they have too few, all that have.
    """
    found = [other for other in others if shifts_path(other, method.front_end).exists()]
    if not found:
        raise Error(
            f"no other sequence with {method.front_end} shifts to fit K on: give more sequences, "
            "best of the same scene"
        )
    scene = [other for other in found if other.scene == sequence.scene]
    if scene and scene != found:
        try:
            return _fit(method, scene)
        except Error:  # too few windows of its scene have an answer
            pass
    return _fit(method, found)


def _fit(method: Method, sequences: list[Sequence]) -> tuple[Fit, tuple[str, ...]]:
    fit = fit_k([load_shifts(each, method.front_end) for each in sequences])
    return fit, tuple(each.name for each in sequences)


def run_job(
    sequence: Sequence, method: Method, settings: Settings, others: list[Sequence]
) -> Outcome:
    """Runs and scores one method on one sequence, or reuses the result of an earlier run.

    Never raises: an error becomes the outcome's `failure`, so that other jobs continue.
    """
    try:
        if not method.k_key:
            return _run_job(sequence, method, settings, None)
        fit, fitted_on = fit_on_others(sequence, method, others)
        return replace(_run_job(sequence, method, settings, fit), fitted_on=fitted_on)
    except Error as error:
        return Outcome(sequence.name, method.name, failure=str(error))
    except Exception as error:  # a defect in one job must not lose the results of the others
        return Outcome(sequence.name, method.name, failure=f"{type(error).__name__}: {error}")


def _run_job(sequence: Sequence, method: Method, settings: Settings, fit: Fit | None) -> Outcome:
    tum = sequence.folder / f"{method.name}.tum"
    kept = sequence.folder / f"{method.name}.json"
    key = fingerprint(sequence, method, settings, fit)
    if tum.exists() and kept.exists():
        before: dict[str, Any] = json.loads(kept.read_text(encoding="utf-8"))
        if before["key"] == key:
            records = tuple(Record(**record) for record in before["records"])
            curves = Curves(**before["curves"]) if before["curves"] else None
            return Outcome(sequence.name, method.name, records, curves, k=fit)
    convert(sequence, settings.channels)
    result = _estimate(sequence, method, settings, fit)
    write_tum(tum, result.trajectory)
    if result.smoothed is not None:
        write_tum(sequence.folder / f"{method.name}.smoothed.tum", result.smoothed)
    records, curves = _score(sequence, method, settings, result)
    content = {
        "key": key,
        "records": [record.as_dict() for record in records],
        "curves": asdict(curves) if curves else None,
    }
    write_text(kept, json.dumps(content))
    return Outcome(sequence.name, method.name, records, curves, k=fit)


def _estimate(sequence: Sequence, method: Method, settings: Settings, fit: Fit | None) -> Estimate:
    if method.reckoned == "displacements" and fit is not None:
        # The shifts are measured already; the front end need not run again.
        shifts = load_shifts(sequence, method.front_end)
        sensors = logs.read_roles(sequence.log, settings.channels.of("imu", "wheel"))
        displacements = Displacements(shifts.start, shifts.end, fit.k * shifts.shift)
        return Estimate(reckon(sensors, displacements))
    overrides = [*settings.overrides, *([f"{method.k_key}={fit.k!r}"] if fit else [])]
    with temporary_folder() as folder:
        output = folder / "output.lcmlog"
        return estimate(sequence.log, method, settings.configs, overrides, output, smooth=True)


def _score(
    sequence: Sequence, method: Method, settings: Settings, result: Estimate
) -> tuple[tuple[Record, ...], Curves | None]:
    truth = known_truth(sequence.source)
    if truth is None:
        return (), None

    def score(trajectory: Trajectory) -> Comparison:
        return compare(associate(trajectory, truth), settings.align, settings.first_m)

    def record(
        mode: Mode,
        comparison: Comparison,
        jumps: MapJumps | None = None,
        frame: FrameStart | None = None,
    ) -> Record:
        name, figures, told = method.name, comparison.figures, result.answered
        return make_record(sequence.name, name, mode, settings.align, figures, jumps, told, frame)

    causal = score(in_last_frame(result.trajectory, result.frame))
    records = [record(CAUSAL, causal, result.jumps, result.frame)]
    if result.smoothed is not None:
        records.append(record(SMOOTHED, score(result.smoothed)))
    return tuple(records), measure_curves(causal)
