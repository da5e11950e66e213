"""Errors that a radar adds to the traces of the ground: drifts, ringing, spikes, noise, counts."""

from dataclasses import dataclass

import numpy as np

from gprodom.arrays import Floats, Ints
from gprodom.random_streams import Random, gauss_markov

_FULL_SCALE = 32767
_GAIN_TIME, _ZERO_TIME = 60.0, 120.0  # s, over which gain and time zero drift
_SPIKE = (2000.0, 20000.0)  # counts


@dataclass(frozen=True)
class RadarSpec:
    """A radar on a robot. All errors but noise are off by default."""

    rate: float = 20.0  # Hz, traces
    spacing: float = 0.0  # m of the wheel from trace to trace, in place of `rate`; 0: by time
    lever_arm: tuple[float, float] = (0.0, 0.0)  # m; the antenna's middle in body
    noise: float = 30.0  # counts, of each sample
    gain_drift: float = 0.0  # relative, standard deviation
    time_zero_drift: float = 0.0  # s, standard deviation
    gain_jitter: float = 0.0  # relative, from trace to trace, standard deviation
    time_zero_jitter: float = 0.0  # s, from trace to trace, standard deviation
    ringing: float = 0.0  # counts, of the antenna's own at time zero
    ringing_time: float = 6e-9  # s, in which it falls to 1/e
    spikes: float = 0.0  # of a trace: the chance that a sample of it is far off


def measure(
    clean: Floats, time: Floats, sample_interval: float, spec: RadarSpec, random: Random
) -> Ints:
    """Traces (n, samples), counts, of noise-free ones `clean` at the times `time` (n,), s."""
    n, samples = clean.shape
    traces = clean
    if spec.ringing:
        after = np.arange(samples) * sample_interval
        ring = np.exp(-after / spec.ringing_time) * np.sin(2 * np.pi * 4.2e8 * after)
        traces = traces + spec.ringing * ring
    if spec.time_zero_drift or spec.time_zero_jitter:
        late = _wander(spec.time_zero_drift, spec.time_zero_jitter, time, _ZERO_TIME, random)
        traces = delayed(traces, late, sample_interval)
    if spec.gain_drift or spec.gain_jitter:
        gain = 1 + _wander(spec.gain_drift, spec.gain_jitter, time, _GAIN_TIME, random)
        traces = traces * gain[:, None]
    noisy = traces + spec.noise * random.standard_normal((n, samples))
    if spec.spikes:
        struck = np.flatnonzero(random.uniform(size=n) < spec.spikes)
        where = random.randint(samples, size=len(struck))
        sign = random.choice([-1.0, 1.0], len(struck))
        noisy[struck, where] += sign * random.uniform(*_SPIKE, len(struck))
    return np.clip(np.rint(noisy), -_FULL_SCALE - 1, _FULL_SCALE).astype(np.int32)


def delayed(traces: Floats, late: Floats, sample_interval: float, phase: float = 0.0) -> Floats:
    """Traces (n, samples) that come `late` (n,), s, their pulse turned by `phase` (rad)."""
    samples = traces.shape[1]
    frequency = np.fft.rfftfreq(2 * samples, sample_interval)
    spectrum = np.fft.rfft(traces, 2 * samples, axis=1)
    spectrum *= np.exp(1j * (phase - 2 * np.pi * np.outer(late, frequency)))
    return np.fft.irfft(spectrum, 2 * samples, axis=1)[:, :samples]


def _wander(drift: float, jitter: float, time: Floats, constant: float, random: Random) -> Floats:
    """A drift, and what changes from trace to trace; of what is not there nothing is drawn."""
    slow = drift * _drift(time, constant, random) if drift else np.zeros(len(time))
    return slow + jitter * random.standard_normal(len(time)) if jitter else slow


def _drift(time: Floats, constant: float, random: Random) -> Floats:
    """A stationary random process of unit variance that forgets over `constant` (s)."""
    if not len(time):
        return np.zeros(0)
    kept = float(np.exp(-np.median(np.diff(time)) / constant)) if len(time) > 1 else 0.0
    return gauss_markov((len(time),), kept, random)
