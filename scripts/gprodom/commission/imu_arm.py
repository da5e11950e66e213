"""Where the IMU sits, by what turning adds to its accelerations.

In the axes of the robot, with the wheel's point P, which moves ahead at v and not sideways, and the
turn rate w, an IMU at P + (x, y) feels

    ahead     v' - w^2 x - w' y
    sideways  v w + w' x - w^2 y

With a yaw of the mounting that is off by e and a wheel that tells (1 + k) times the way, both by
some per cent, this is linear in (x, y, e, k) and in the two biases, which have the tilt in them.
All of it goes through one filter: what that does to accelerations it does to speeds and turns, too.
"""

import math

import numpy as np
from scipy.ndimage import gaussian_filter1d

from gprodom.arrays import Floats, Ints, integral
from gprodom.commission.parameter import CIRCLES, Parameter, listed
from gprodom.doctor.finding import Log
from gprodom.drive.imu_mounting import matrix_of, smoothed
from gprodom.errors import Error
from gprodom.odometry.dead_reckoning import standstill, wheel_distance

NAME = "lever arm of the IMU"
STEP_S = 0.05
# Standard deviation of the weights of a filter that keeps how turns set in, and not the wheel's
# counts.
FILTER_S = 0.2
EDGE = round(4 * FILTER_S / STEP_S)
BLOCK_S = 10.0  # what slope and slip do to the accelerations lasts for some seconds
FEWEST_BLOCKS = 10
# Tyres give way in bends, which moves the point that goes straight ahead by centimetres, in all of
# a drive alike.
LEAST_SIGMA_M = 0.015
LARGEST_SIGMA_M = 0.1  # of an arm that is of use
CLEARLY = 3.0  # standard deviations off the configured arm
SMALLEST_M = 0.03  # what a tape is good to, and what hardly matters


def lever_arm(
    log: Log, rpy: tuple[float, ...], configured: tuple[float, ...], wheel_arm: tuple[float, ...]
) -> Parameter:
    """Forwards and to the left, m, from a log whose accelerations are as the IMU's own place feels
    them. rpy: of its mounting, which may be off by some degrees. configured: imu.lever_arm, whose
    height stays. wheel_arm: wheel.lever_arm, of P."""
    try:
        rows, wanted, block = _rows(log, rpy)
    except Error as error:
        return Parameter(NAME, remark=str(error), manoeuvre=CIRCLES)
    if block.max() + 1 < FEWEST_BLOCKS:
        remark = f"less than {FEWEST_BLOCKS * BLOCK_S:.0f} s of IMU and wheel"
        return Parameter(NAME, remark=remark, manoeuvre=CIRCLES)
    shown, sigma = _shown(rows, wanted, block)
    x, y = (float(shown[i] + wheel_arm[i]) for i in range(2))
    sigmas = math.hypot(sigma[0], LEAST_SIGMA_M), math.hypot(sigma[1], LEAST_SIGMA_M)
    if not max(sigmas) < LARGEST_SIGMA_M:
        remark = "forwards and to the left; too uncertain to be used: use a tape"
        return Parameter(NAME, "m", (x, y), sigmas, (), remark, CIRCLES)
    off = x - configured[0], y - configured[1]
    remark = (
        "forwards and to the left of the point that the wheel measures; its height does not show, "
        "and hardly matters"
    )
    clearly = any(
        abs(each) > max(CLEARLY * s, SMALLEST_M) for each, s in zip(off, sigmas, strict=True)
    )
    if not clearly:
        remark += "; not different from what is configured"
        return Parameter(NAME, "m", (x, y), sigmas, (), remark)
    setting = f"imu.lever_arm={listed((x, y, configured[2]), 3)}"
    return Parameter(NAME, "m", (x, y), sigmas, (setting,), remark + "; check it with a tape")


def _rows(log: Log, rpy: tuple[float, ...]) -> tuple[Floats, Floats, Ints]:
    """Of the linear system: (2 n, 6) for x, y, e, k and the biases, (2 n,), and the number of the
    block of time of each. Ahead and sideways take turns."""
    time, way = wheel_distance(log)
    imu = log["imu"]
    stamps, R = imu["utime"], matrix_of(rpy)
    start, end = max(time[0], stamps[0]), min(time[-1], stamps[-1])
    grid = np.arange(start, end, round(STEP_S * 1e6))
    if len(grid) < BLOCK_S / STEP_S:
        raise Error("IMU and wheel overlap for too short a time")
    seconds = (stamps - stamps[0]) * 1e-6
    turn = smoothed(imu["angular_velocity"] @ R.T, seconds)[:, 2]
    still = standstill(time, way)
    rests = (stamps >= still[0]) & (stamps <= still[1])
    turn = turn - (turn[rests].mean() if rests.sum() > 1 else 0.0)
    force = (imu["linear_acceleration"] - imu["linear_acceleration"].mean(axis=0)) @ R.T

    def integrated(of: Floats) -> Floats:
        return np.asarray(np.interp(grid, stamps, integral(of, seconds)))

    # Of what is like a speed, means between the steps of the grid.
    def slope(of: Floats) -> Floats:
        return np.asarray(gaussian_filter1d(np.diff(of) / STEP_S, FILTER_S / STEP_S))

    def between(of: Floats) -> Floats:
        return np.asarray(0.5 * (of[1:] + of[:-1]))

    way_steps, turn_steps = np.diff(np.interp(grid, time, way)), np.diff(integrated(turn))
    across = np.concatenate([[0.0], np.cumsum(way_steps * turn_steps / STEP_S)])
    faster, turning = slope(way_steps / STEP_S), slope(turn_steps / STEP_S)
    square, sideways = slope(between(integrated(turn**2))), slope(between(across))
    felt = [slope(between(integrated(force[:, axis]))) for axis in range(2)]
    one, none = np.ones(len(square)), np.zeros(len(square))
    rows = np.stack(
        [
            np.column_stack([-square, -turning, sideways, faster, one, none]),
            np.column_stack([turning, -square, -faster, sideways, none, one]),
        ]
    )
    wanted = np.stack([felt[0] - faster, felt[1] - sideways])
    inside = slice(EDGE, -EDGE)
    block = ((grid[1:-1] - grid[0]) // round(BLOCK_S * 1e6)).astype(np.int64)[inside]
    return (
        rows[:, inside].reshape(-1, 6),
        wanted[:, inside].ravel(),
        np.concatenate([block, block]) - block[0],
    )


def _shown(rows: Floats, wanted: Floats, block: Ints) -> tuple[Floats, Floats]:
    """x and y, m, and their standard deviations by a jackknife over the blocks."""
    count = int(block.max()) + 1
    normal, right = np.zeros((count, 6, 6)), np.zeros((count, 6))
    for i in range(count):
        part = rows[block == i]
        normal[i], right[i] = part.T @ part, part.T @ wanted[block == i]
    whole, of_all = normal.sum(axis=0), right.sum(axis=0)

    def solve(matrix: Floats, vector: Floats) -> Floats:
        return np.asarray(np.linalg.lstsq(matrix, vector, rcond=1e-12)[0][:2])

    left_out = [solve(whole - n, of_all - r) for n, r in zip(normal, right, strict=True)]
    spread = np.std(left_out, axis=0) * math.sqrt(count - 1)
    return solve(whole, of_all), np.asarray(spread)
