"""Survey lines over ground that repeats: what an antenna sees anywhere along and beside them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from gprodom.arrays import Floats, Ints
from gprodom.errors import Error
from gprodom.files import also_read, write_npz

FULL_SCALE = 30_000  # counts, of the strongest sample of a survey
SHIPPED = Path(__file__).parent / "lines"
_BEYOND = 0.1  # m; so far past its ends the ground is that of its ends
_FINER = 16  # samples between two traces of a line, by its spectrum; linear in between


@dataclass(frozen=True)
class Survey:
    """Parallel lines of traces: `lines` (k, n, samples) int16, counts.

    spacing: m between traces. aside: (k,) m, where each line lies, ascending. closed: the ground
    repeats after n * spacing; else it ends there, and there is none before 0.
    """

    name: str
    lines: Ints
    spacing: float
    aside: Floats
    sample_interval: float  # s
    surface_time: float  # s, from the first sample to the middle of the wavelet that leaves
    closed: bool = True

    @property
    def length(self) -> float:
        """After which the ground repeats or ends, m."""
        return float((self.lines.shape[1] - (not self.closed)) * self.spacing)

    @cached_property
    def _fine(self) -> Floats:
        """(k, m, samples), counts, traces at a fraction of the spacing, both ends included.

        Round closed ground band-limited; between traces of other ground as they are: real lines
        are often spaced too widely for more.
        """
        lines = self.lines.astype(np.float32)
        if not self.closed:
            return lines
        spectrum = np.fft.rfft(lines, axis=1)
        n = lines.shape[1] * _FINER
        fine = np.fft.irfft(spectrum, n, axis=1) * _FINER
        return np.concatenate([fine, fine[:, :1]], axis=1).astype(np.float32)

    def traces(self, along: Floats, beside: Floats) -> Floats:
        """Traces (m, samples), counts, at `along` and `beside` (m,), m, from the first line.

        Beside the outer lines the outer lines are seen, between two of them their mean by distance.
        """
        n = self._fine.shape[1] - 1
        if self.closed:
            along = np.mod(along, self.length)
        elif np.min(along) < -_BEYOND or np.max(along) > self.length + _BEYOND:
            raise Error(
                f"ground {self.name} ends after {self.length:.2f} m, the drive goes from "
                f"{np.min(along):.2f} to {np.max(along):.2f} m: take --route line or stops, or a "
                "shorter --distance"
            )
        place = np.clip(along / self.length, 0, 1) * n
        column = np.minimum(place.astype(np.int64), n - 1)
        part = (place - column)[:, None]
        beside = np.clip(beside, self.aside[0], self.aside[-1])
        line = np.clip(np.searchsorted(self.aside, beside, side="right") - 1, 0, None)
        line = np.minimum(line, max(len(self.aside) - 2, 0))
        other = np.minimum(line + 1, len(self.aside) - 1)
        apart = np.maximum(self.aside[other] - self.aside[line], 1e-9)
        weight = ((beside - self.aside[line]) / apart)[:, None]

        def on(lines: Ints) -> Floats:
            fine = self._fine
            return np.asarray((1 - part) * fine[lines, column] + part * fine[lines, column + 1])

        return np.asarray((1 - weight) * on(line) + weight * on(other), np.float64)


def to_counts(volts: Floats) -> Ints:
    """int16, with the greatest sample at `FULL_SCALE`."""
    scale = FULL_SCALE / max(float(np.abs(volts).max()), 1e-300)
    return np.asarray(np.rint(volts * scale), np.int16)


def write_survey(path: Path, survey: Survey) -> None:
    """Compressed npz. Each trace is kept as its difference from the one before, modulo 2^16, each
    sample of that from the sample before: half the size of the traces themselves."""
    steps = np.diff(survey.lines, axis=1, prepend=np.int16(0))
    write_npz(
        path,
        {
            "steps": np.diff(steps, axis=2, prepend=np.int16(0)),
            "spacing": np.array(survey.spacing),
            "aside": np.asarray(survey.aside, np.float64),
            "sample_interval": np.array(survey.sample_interval),
            "surface_time": np.array(survey.surface_time),
            "closed": np.array(survey.closed),
        },
    )


def read_survey(path: Path) -> Survey:
    """What `write_survey` wrote."""
    try:
        with np.load(path) as data:
            steps = np.cumsum(data["steps"], axis=2, dtype=np.int16)
            return Survey(
                name=path.stem,
                lines=np.cumsum(steps, axis=1, dtype=np.int16),
                spacing=float(data["spacing"]),
                aside=data["aside"],
                sample_interval=float(data["sample_interval"]),
                surface_time=float(data["surface_time"]),
                closed=bool(data["closed"]) if "closed" in data else True,
            )
    except (KeyError, ValueError) as error:
        raise Error(f"{path}: expected a survey that `gprodom ground` wrote: {error}") from None


def shipped() -> tuple[str, ...]:
    """Names of the surveys that come with the package."""
    return tuple(sorted(path.stem for path in SHIPPED.glob("*.npz")))


def find_survey(name: str) -> Survey:
    """A shipped survey by its name, else the file `name`."""
    if name in shipped():
        return read_survey(SHIPPED / f"{name}.npz")
    path = Path(name)
    if not path.is_file():
        raise Error(f"{name}: expected a survey file or one of {', '.join(shipped())}")
    also_read(path)
    return read_survey(path)
