"""``gprodom calibrate imu``: noise of the IMU by its Allan deviation at a standstill."""

import argparse
from collections.abc import Sequence
from dataclasses import asdict, dataclass

import numpy as np

from gprodom import canvas
from gprodom.arrays import Floats
from gprodom.calibrate.fragment import Found, add_output_option, tell_found
from gprodom.errors import Error, need_module
from gprodom.files import PictureFile
from gprodom.lcm import logs
from gprodom.odometry.dead_reckoning import SETTLED_S, has_wheel, standstill, wheel_distance
from gprodom.odometry.estimate import read_sensors
from gprodom.options import Subparsers, add_command

MIN_S = 20.0  # of standstill
WHITE_S = 1.0  # up to this averaging time the deviation is taken to be white noise's
FLOOR = 0.664  # of the bias instability, at the Allan deviation's lowest

DESCRIPTION = """\
Takes the noise of an IMU from a recording at rest by its overlapping Allan deviation (allantools,
the extra `calibrate`): the density of the white noise from averaging times up to a second, the
random walk of the bias from the longest ones. If the recording has a wheel, its standstill is used
(the first, else the longest); without a wheel it must be at rest all the time. The random walk
needs hours; a few minutes give an upper bound only, and the output says so. For the estimator,
record a robot that stands with its motors on.

examples:
  gprodom calibrate imu standstill.lcmlog -o imu.yaml --plot allan.png
  gprodom calibrate imu drive.lcmlog
"""


@dataclass(frozen=True)
class Noise:
    """Noise of one sensor, root mean square over its axes.

    density: per sqrt(Hz). walk: of the bias, per s sqrt(Hz); an upper bound where `walk_is_bound`.
    instability: of the bias, in the sensor's unit. sigmas: one standard deviation, relative.
    """

    density: float
    density_sigma: float
    walk: float
    walk_sigma: float
    walk_is_bound: bool
    instability: float

    @property
    def walk_is_known(self) -> bool:
        """Whether the value is more than two standard deviations above zero."""
        return not self.walk_is_bound and self.walk_sigma < 0.5


def allan(values: Floats, rate: float) -> tuple[Floats, Floats, Floats]:
    """Averaging times (m,), s, overlapping Allan deviation (m,) and its standard error (m,)."""
    allantools = need_module("allantools", "calibrate")
    longest = len(values) / rate / 3
    taus = np.geomspace(1 / rate, longest, 40)
    tau, deviation, error, _ = allantools.oadev(values, rate=rate, data_type="freq", taus=taus)
    return np.asarray(tau), np.asarray(deviation), np.asarray(error)


def measure_noise(values: Floats, rate: float) -> Noise:
    """Noise of samples (n, 3) at rest, at `rate` (Hz)."""
    curves = [allan(column, rate) for column in values.T]
    tau = curves[0][0]
    deviation = np.sqrt(np.mean([each[1] ** 2 for each in curves], axis=0))
    relative = np.mean([each[2] / each[1] for each in curves], axis=0) / np.sqrt(len(curves))
    white = tau <= WHITE_S
    density = float(np.sqrt(np.mean(deviation[white] ** 2 * tau[white])))
    # The longest averaging times: what is left there over white noise is a walk or less.
    long = tau >= tau[-1] / 4
    excess = np.maximum(deviation[long] ** 2 - density**2 / tau[long], 0)
    walk = float(np.median(np.sqrt(excess * 3 / tau[long])))
    # The error of overlapping averages is told as if they were independent. As many are as there
    # are stretches of that length, on each axis; the walk's square is what is over white noise.
    independent = np.maximum(len(values) / rate / tau[long] - 1, 1) * len(curves)
    share = np.maximum(excess / deviation[long] ** 2, 1e-6)
    walk_sigma = float(np.median(1 / np.sqrt(2 * independent) / share))
    slope = np.polyfit(np.log(tau[long]), np.log(deviation[long]), 1)[0]
    return Noise(
        density=density,
        density_sigma=float(1 / np.sqrt(len(values) * len(curves)) + relative[white][0]),
        walk=walk if slope > 0.2 else float(np.median(deviation[long] * np.sqrt(3 / tau[long]))),
        walk_sigma=walk_sigma,
        walk_is_bound=bool(slope <= 0.2),
        instability=float(deviation.min() / FLOOR),
    )


def at_rest(log: logs.Log) -> tuple[Floats, Floats, float]:
    """Acceleration and angular rate (n, 3) at rest, and their rate (Hz)."""
    imu = logs.need(log, "imu")
    time = imu["utime"]
    if has_wheel(log):
        start, end = standstill(*wheel_distance(log))
        end -= round(SETTLED_S * 1e6)  # it is felt to drive off before the wheel shows it
    else:
        start, end = int(time[0]), int(time[-1])
    during = (time >= start) & (time <= end)
    seconds = float(np.ptp(time[during])) * 1e-6 if during.any() else 0.0
    if seconds < MIN_S:
        raise Error(
            f"the robot stands for {seconds:.1f} s; at least {MIN_S:g} s are needed, and some "
            "minutes to say anything of the bias"
        )
    rate = 1e6 / float(np.median(np.diff(time[during])))
    return imu["linear_acceleration"][during], imu["angular_velocity"][during], rate


def allan_figure(acceleration: Floats, gyro: Floats, rate: float) -> canvas.Figure:
    """Allan deviation of both sensors, axis by axis."""
    figure, axes = canvas.new_figure(1, 2, width=9.0, height=3.8)
    for axis, values, what in (
        (axes[0], gyro, "angular rate (rad/s)"),
        (axes[1], acceleration, "acceleration (m/s²)"),
    ):
        for i, (column, name) in enumerate(zip(values.T, "xyz", strict=True)):
            tau, deviation, error = allan(column, rate)
            axis.errorbar(tau, deviation, error, label=name, **canvas.line_style(i, 3))
        canvas.log_scales(axis, "x", "y")
        axis.set(xlabel="averaging time (s)", ylabel="Allan deviation, " + what)
        canvas.legend_below(axis, 3)
    return figure


def add_parser(subjects: Subparsers) -> None:
    """Adds ``calibrate imu``."""
    parser = add_command(subjects, "imu", "noise of the IMU at a standstill", DESCRIPTION, run)
    parser.operand("source", "SEQ|LOG")
    add_output_option(parser)
    parser.option("--plot PICTURE", PictureFile, "of the Allan deviations")
    parser.common_options()


def run(args: argparse.Namespace) -> int:
    """Runs ``calibrate imu``."""
    acceleration, gyro, rate = at_rest(read_sensors(args, args.source, "imu", "wheel"))
    noise = {"gyro": measure_noise(gyro, rate), "accel": measure_noise(acceleration, rate)}
    found = [item for name, each in noise.items() for item in _as_found(name, each)]
    if args.plot is not None:
        canvas.save(allan_figure(acceleration, gyro, rate), args.plot)
    figures = {name: asdict(each) for name, each in noise.items()}
    return tell_found(args, found, {"seconds": len(gyro) / rate, **figures})


def _as_found(name: str, noise: Noise) -> Sequence[Found]:
    sure = f"+- {100 * noise.density_sigma:.1f} %"
    walk = (
        "at most: too short to tell"
        if noise.walk_is_bound
        else f"+- {100 * noise.walk_sigma:.0f} %"
    )
    walk += f"; bias instability {noise.instability:.2g}"
    return (
        Found(f"imu.{name}_noise_density", f"{noise.density:.4g}", sure),
        Found(f"imu.{name}_bias_walk", f"{noise.walk:.4g}", walk, noise.walk_is_known),
    )
