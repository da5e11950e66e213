"""``gprodom calibrate wheel``: scale and lever arm of the wheel, against a truth of positions."""

import argparse
from collections.abc import Sequence
from dataclasses import asdict, dataclass

import numpy as np

from gprodom.arrays import Floats, sums
from gprodom.calibrate.fragment import Found, add_output_option, tell_found
from gprodom.console import format_table
from gprodom.errors import Error, UsageError
from gprodom.lcm import logs
from gprodom.odometry.dead_reckoning import gyro_yaw_of, standstill, wheel_distance
from gprodom.odometry.estimate import read_sensors
from gprodom.options import Subparsers, add_command, point
from gprodom.score.align import fit_planar
from gprodom.score.sources import read_truth
from gprodom.trajectory import Times, Trajectory, path_length

WINDOW_M, WINDOW_S = 3.0, 5.0  # a window is at least this long, and takes this long at usual speed
MIN_POINTS = 6  # of the truth in a window
TREAD_M = 0.05  # step of the truth's path, so that millimetres of noise do not add up
BLOCKS = 8  # of the jackknife

DESCRIPTION = """\
Fits wheel.scale (reported over true distance) and the lateral part of wheel.lever_arm on recordings
with a truth of positions. In windows of some metres, the path by wheel and gyro is aligned with the
truth's by a free rotation and translation, so that neither gyro bias nor the truth's frame matters.
Slip gets a low weight. The lever arm is observable in bends only, and is left out if there are too
few. The uncertainty is from a jackknife over blocks of windows.

With --fit-share the fit uses the first part of each recording, and the distance of the rest is
compared with the truth before and after the calibration.

examples:
  gprodom calibrate wheel drive.lcmlog -o wheel.yaml
  gprodom calibrate wheel 1700002000-0-gates_g-cmu-gpr.zip --prism 0.1,0
  gprodom calibrate wheel car.lcmlog --fit-share 0.5
"""


@dataclass(frozen=True)
class Window:
    """Points of the truth (n, 2), m, with the path by wheel and gyro at the same times.

    The path of the truth's point, apart from a rotation and a shift, is
    rolled / scale + turned * lever + R(yaw) prism.
    """

    truth: Floats
    rolled: Floats  # (n, 2), m: integral of e(yaw) dw
    turned: Floats  # (n, 2), rad: integral of e(yaw) dyaw
    yaw: Floats  # (n,), rad


@dataclass(frozen=True)
class WheelFit:
    """scale: reported over true distance; lever_m: of the contact point to the left, None if there
    are too few bends; sigmas by jackknife; residual_m: robust RMS of the residuals.
    """

    scale: float
    scale_sigma: float
    lever_m: float | None
    lever_sigma: float | None
    windows: int
    residual_m: float


@dataclass(frozen=True)
class Check:
    """Distance travelled in the rest of a recording, against the truth's, percent."""

    distance_m: float
    error_before_pct: float
    error_after_pct: float


def make_windows(
    log: logs.Log, truth: Trajectory, share: tuple[float, float] = (0.0, 1.0)
) -> list[Window]:
    """Windows of a recording between two shares of its time in which the robot moves."""
    wheel_time, distance = wheel_distance(log)
    imu_time, yaw = gyro_yaw_of(log, standstill(wheel_time, distance))
    first = max(int(t[0]) for t in (wheel_time, imu_time, truth.time))
    last = min(int(t[-1]) for t in (wheel_time, imu_time, truth.time))
    span = last - first
    first, last = first + int(share[0] * span), first + int(share[1] * span)
    heading = np.interp(wheel_time, imu_time, yaw)
    middle = 0.5 * (heading[1:] + heading[:-1])
    along = np.column_stack([np.cos(middle), np.sin(middle)])
    rolled = sums(along * np.diff(distance)[:, None])
    turned = sums(along * np.diff(heading)[:, None])
    use = (truth.time >= first) & (truth.time <= last)
    time, position = truth.time[use], truth.position[use, :2]
    travelled = np.interp(time, wheel_time, sums(np.abs(np.diff(distance))))
    speed = np.abs(np.diff(travelled)) / np.maximum(np.diff(time) * 1e-6, 1e-3)
    moving = speed[speed > 0.05]
    if not len(moving):
        raise Error("the wheel does not turn while there is truth: nothing to fit on")
    length = max(WINDOW_M, WINDOW_S * float(np.median(moving)))
    number = (travelled - travelled[0]) // length
    windows = []
    for i in np.unique(number)[:-1]:  # the last one is not full
        part = number == i
        if part.sum() >= MIN_POINTS:
            there = time[part]
            windows.append(
                Window(
                    position[part],
                    _interpolated(there, wheel_time, rolled),
                    _interpolated(there, wheel_time, turned),
                    np.interp(there, wheel_time, heading),
                )
            )
    return windows


def _interpolated(time: Times, at: Times, table: Floats) -> Floats:
    return np.column_stack([np.interp(time, at, column) for column in table.T])


def fit_wheel(windows: Sequence[Window], prism: tuple[float, float] = (0.0, 0.0)) -> WheelFit:
    """Scale and lever arm by robust least squares, with sigmas by jackknife."""
    if len(windows) < 3:
        raise Error(
            f"{len(windows)} windows of motion with truth, at least 3 are needed: give a longer "
            "recording"
        )
    # The lever arm is observable only in windows with a turn.
    bends = sum(float(np.ptp(window.yaw)) > 0.3 for window in windows) >= 4
    value, residual = _solve(windows, prism, bends)
    blocks = min(BLOCKS, len(windows))
    left_out = [
        _solve([w for j, w in enumerate(windows) if j % blocks != i], prism, bends)[0]
        for i in range(blocks)
    ]
    spread = np.std(left_out, axis=0) * np.sqrt(blocks - 1)
    return WheelFit(
        scale=float(value[0]),
        scale_sigma=float(spread[0]),
        lever_m=float(value[1]) if bends else None,
        lever_sigma=float(spread[1]) if bends else None,
        windows=len(windows),
        residual_m=residual,
    )


def _solve(
    windows: Sequence[Window], prism: tuple[float, float], bends: bool
) -> tuple[Floats, float]:
    """(scale, lever) and the robust spread of the residuals, m."""
    from scipy.optimize import least_squares

    def residuals(x: Floats) -> Floats:
        lever = x[1] if bends else 0.0
        return np.concatenate([_misfit(w, 1 / x[0], lever, prism) for w in windows])

    start = np.array([1.0, 0.0]) if bends else np.array([1.0])
    spread = 0.05
    for _ in range(4):
        start = least_squares(residuals, start, loss="cauchy", f_scale=2 * spread).x
        spread = max(1.4826 * float(np.median(np.abs(residuals(start)))), 1e-5)
    return start, spread


def _misfit(window: Window, inverse: float, lever: float, prism: tuple[float, float]) -> Floats:
    cos, sin = np.cos(window.yaw), np.sin(window.yaw)
    arm = np.column_stack([cos * prism[0] - sin * prism[1], sin * prism[0] + cos * prism[1]])
    path = inverse * window.rolled + lever * window.turned + arm
    flat = np.zeros((len(path), 1))
    source, target = np.hstack([path, flat]), np.hstack([window.truth, flat])
    try:
        placed = fit_planar(source, target)
    except Error:  # it stands
        return np.zeros(2 * len(path))
    return np.asarray((source @ placed.matrix.T + placed.translation - target)[:, :2].ravel())


def check_rest(log: logs.Log, truth: Trajectory, share: float, scale: float) -> Check:
    """Checks the distance of the rest of the recording, after the first `share`."""
    time, distance = wheel_distance(log)
    first = truth.time[0] + int(share * (truth.time[-1] - truth.time[0]))
    rest = truth.select((truth.time >= first) & (truth.time <= time[-1]))
    travelled = path_length(rest.position[:, :2], TREAD_M)
    true = float(travelled[-1])
    at = int(np.searchsorted(travelled, true))
    steps = np.abs(np.diff(np.interp(rest.time[[0, at]], time, sums(np.abs(np.diff(distance))))))
    if true <= 0:
        raise Error("the truth does not move in what is left to check on")
    reported = float(steps[0])
    return Check(true, 100 * (reported / true - 1), 100 * (reported / scale / true - 1))


def add_parser(subjects: Subparsers) -> None:
    """Adds ``calibrate wheel``."""
    parser = add_command(subjects, "wheel", "scale and lever arm of the wheel", DESCRIPTION, run)
    parser.operand("sources", "SEQ|LOG", "log with truth", nargs="+")
    parser.option(
        "--prism X,Y",
        point,
        "point whose position the truth measured (body, m)",
        default=(0.0, 0.0),
    )
    parser.option("--fit-share P", 1.0, "see above (default: all)")
    add_output_option(parser)
    parser.common_options()


def run(args: argparse.Namespace) -> int:
    """Runs ``calibrate wheel``."""
    if not 0 < args.fit_share <= 1:
        raise UsageError(f"--fit-share {args.fit_share:g}: expected above 0, at most 1")
    windows: list[Window] = []
    recordings = []
    for source in args.sources:
        log = read_sensors(args, source, "imu", "wheel")
        truth = read_truth(source, frame=None).trajectory
        windows += make_windows(log, truth, (0.0, args.fit_share))
        recordings.append((log, truth))
    found = fit_wheel(windows, args.prism)
    checks = []
    if args.fit_share < 1:
        checks = [check_rest(log, truth, args.fit_share, found.scale) for log, truth in recordings]
    figures = {**asdict(found), "rest": [asdict(check) for check in checks]}
    tell_found(args, _as_found(found), figures)
    if checks and not args.json:
        header = ["distance of the rest (m)", "error before (%)", "after (%)"]
        print(format_table(header, [list(asdict(check).values()) for check in checks]))
    return 0


def _as_found(found: WheelFit) -> list[Found]:
    sure = f"+- {found.scale_sigma:.5f} (one sigma), {found.windows} windows"
    sigma = max(found.scale_sigma, 1e-4)
    lines = [
        Found("wheel.scale", f"{found.scale:.5f}", sure),
        Found("wheel.scale_sigma", f"{sigma:.5f}", "prior of the scale: as sure as the fit"),
    ]
    if found.lever_m is not None:
        arm = f"[0, {found.lever_m:.3f}, 0]"
        sure = f"to the left +- {found.lever_sigma:.3f} m; forwards is not observable"
        far = abs(found.lever_m) > 2 * (found.lever_sigma or 0.0)
        lines.append(Found("wheel.lever_arm", arm, sure, far))
    return lines
