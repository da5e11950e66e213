"""Survey lines over ground that repeats: what an antenna sees anywhere along and beside them."""

from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np

from gprodom.arrays import Floats, Ints
from gprodom.errors import Error
from gprodom.files import also_read, write_npz

FULL_SCALE = 30_000  # counts, of the strongest sample of a survey
SHIPPED = Path(__file__).parent / "lines"
# m: offset l to the side of the antenna's track at which the ground's correlation has the curvature
# of cos(l / LATERAL). From neighbouring real lines, by bench/lateral.py; see docs/simulation.md.
LATERAL = 0.11
_BEYOND = 0.1  # m; so far past its ends the ground is that of its ends
_FINER = 16  # samples between two traces of a line, by its spectrum; linear in between


@dataclass(frozen=True)
class Survey:
    """Parallel lines of traces: `lines` (k, n, samples) int16, counts.

    spacing: m between traces. aside: (k,) m, where each line lies, ascending. closed: the ground
    repeats after n * spacing; else it ends there, and there is none before 0.
    """

    name: str
    lines: Ints | Floats
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

    def decorrelating(self) -> "Survey":
        """The same ground for antennas beside each other, which see it by `turned_traces`.

        Lines nearer than `LATERAL` are 2-D simulations, which do not say how alike they should be:
        each is made as much like the one before as real ground is.
        """
        lines = self.lines.astype(np.float64)
        other = np.roll(lines[:1], lines.shape[1] // 2, axis=1)  # beside a single line
        lines = np.concatenate([lines, other]) if len(lines) == 1 else lines
        aside = np.array([0.0, 0.5 * LATERAL]) if len(self.lines) == 1 else self.aside
        for k, apart in enumerate(np.diff(aside)):
            if apart < LATERAL:
                here, mean = _without_mean(lines[k])
                there, _ = _without_mean(lines[k + 1])
                there = there - here * (np.sum(there * here) / np.sum(here**2))
                there = there * np.sqrt(np.sum(here**2) / np.sum(there**2))
                angle = apart / LATERAL
                lines[k + 1] = mean + np.cos(angle) * here + np.sin(angle) * there
        # As float: rounding to counts again would add noise where the ground is faint.
        return replace(self, lines=lines, aside=aside)

    @cached_property
    def _angles(self) -> Floats:
        """(k - 1,) rad: arc cosine of the correlation of neighbouring lines."""
        parts = [_without_mean(line)[0] for line in self.lines.astype(np.float64)]
        norms = [np.linalg.norm(part) for part in parts]
        cosines = [
            np.sum(parts[k] * parts[k + 1]) / (norms[k] * norms[k + 1])
            for k in range(len(parts) - 1)
        ]
        return np.asarray(np.arccos(np.clip(cosines, 0.0, 0.999)))

    def turned_traces(self, along: Floats, beside: Floats) -> Floats:
        """As `traces`, but the ground turns evenly from each line to the next, by the angle whose
        cosine is their correlation: it is as strong between lines as on them, and two places aside
        of each other have the same correlation everywhere."""
        return self._seen(along, beside, turning=True)

    def traces(self, along: Floats, beside: Floats) -> Floats:
        """Traces (m, samples), counts, at `along` and `beside` (m,), m, from the first line.

        Beside the outer lines the outer lines are seen, between two of them their mean by distance.
        """
        return self._seen(along, beside, turning=False)

    def _seen(self, along: Floats, beside: Floats, turning: bool) -> Floats:
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
        if not turning:
            beside = np.clip(beside, self.aside[0], self.aside[-1])
        line = np.clip(np.searchsorted(self.aside, beside, side="right") - 1, 0, None)
        line = np.minimum(line, max(len(self.aside) - 2, 0))
        other = np.minimum(line + 1, len(self.aside) - 1)
        apart = np.maximum(self.aside[other] - self.aside[line], 1e-9)
        weight = ((beside - self.aside[line]) / apart)[:, None]

        def on(lines: Ints) -> Floats:
            fine = self._fine
            return np.asarray((1 - part) * fine[lines, column] + part * fine[lines, column + 1])

        if not turning:
            return np.asarray((1 - weight) * on(line) + weight * on(other), np.float64)
        angle = self._angles[line][:, None]
        near, far = (np.sin(w * angle) / np.sin(angle) for w in (1 - weight, weight))
        means = self._fine.mean(axis=1)
        mean = (1 - weight) * means[line] + weight * means[other]
        turned = near * (on(line) - means[line]) + far * (on(other) - means[other])
        return np.asarray(mean + turned, np.float64)


def _without_mean(line: Floats) -> tuple[Floats, Floats]:
    """A line (n, samples) less its mean trace, and that."""
    mean = line.mean(axis=0)
    return line - mean, mean


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
