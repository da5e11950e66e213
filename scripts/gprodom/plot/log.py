"""A replayed or recorded log against time: speed, standing, slipping, uncertainty."""

import numpy as np

from gprodom import canvas
from gprodom.arrays import Floats, Ints
from gprodom.drive.troubles import stretches
from gprodom.lcm import logs
from gprodom.lcm.constants import flag_bits, kind
from gprodom.odometry.dead_reckoning import has_wheel, wheel_distance
from gprodom.trajectory import Times

SPEED_SPAN_S = 0.5  # over which the wheel's speed is taken


def log_figure(log: logs.Log, title: str) -> canvas.Figure:
    """Speed of robot and wheel, uncertainty of position and yaw, flags, along time."""
    odometry = log["odometry"]
    origin = int(odometry["utime"][0])
    seconds = (odometry["utime"] - origin) * 1e-6
    figure, axes = canvas.new_figure(4, 1, width=9.0, height=8.0, sharex=True)
    speed, position, heading, flags = axes
    _draw_speed(speed, log, seconds, origin)
    _draw_sigmas(position, heading, odometry, seconds)
    _draw_flags(flags, odometry["flags"], seconds)
    speed.set_title(title)
    flags.set_xlabel("time (s)")
    figure.align_ylabels(axes)
    return figure


def wheel_speed(log: logs.Log) -> tuple[Times, Floats] | None:
    """Times (n,), us, and speed (n,) over `SPEED_SPAN_S` about them, m/s; None without a wheel."""
    if not has_wheel(log):
        return None
    time, distance = wheel_distance(log)
    clock = (time - time[0]) * 1e-6
    ends = clock[:1], clock[-1:]  # of what was driven: at either end the span is shorter
    ahead, behind = (np.clip(clock + s * SPEED_SPAN_S / 2, *ends) for s in (1, -1))
    moved = np.interp(ahead, clock, distance) - np.interp(behind, clock, distance)
    return time, moved / np.maximum(ahead - behind, 1e-3)


def radar_speed(displacement: logs.Channel) -> tuple[Times, Floats]:
    """Times (n,), us, and speeds (n,), m/s, that the radar's coherence tells, without a sign."""
    moves = (displacement["kind"] == kind("MOTION")) & displacement["valid"].astype(bool)
    seconds = (displacement["utime_to"] - displacement["utime_from"])[moves] * 1e-6
    speed = displacement["distance"][moves] / np.maximum(seconds, 1e-3)
    order = np.argsort(displacement["utime_to"][moves], kind="stable")
    return displacement["utime_to"][moves][order], speed[order]


def _draw_speed(axis: canvas.Axes, log: logs.Log, seconds: Floats, origin: int) -> None:
    measured = wheel_speed(log)
    if measured is not None:
        clock = (measured[0] - origin) * 1e-6
        axis.plot(clock, measured[1], color=canvas.COLOURS[1], lw=0.8, ls="--", label="wheel")
    speed = log["odometry"]["velocity"][:, 0]
    axis.plot(seconds, speed, color=canvas.COLOURS[0], lw=0.8, label="estimate")
    axis.set_ylabel("forward speed (m/s)")
    canvas.legend_beside(axis)


def _draw_sigmas(
    position: canvas.Axes, heading: canvas.Axes, odometry: logs.Channel, seconds: Floats
) -> None:
    """Each with an axis of its own: metres and degrees have no common scale."""
    variance = odometry["pose_covariance"].reshape(-1, 6, 6)
    metres = np.sqrt(np.maximum(variance[:, 0, 0] + variance[:, 1, 1], 0))
    degrees = np.degrees(np.sqrt(np.maximum(variance[:, 5, 5], 0)))
    position.plot(seconds, metres, color=canvas.COLOURS[0], lw=1.0)
    position.set(ylabel="position σ\nin odom (m)", ylim=(0, None))
    heading.plot(seconds, degrees, color=canvas.COLOURS[2], lw=1.0)
    heading.set(ylabel="heading σ\nin odom (°)", ylim=(0, None))


def _draw_flags(axis: canvas.Axes, flags: Ints, seconds: Floats) -> None:
    """A lane each; standing is no trouble, so it has another colour than the rest."""
    bits = flag_bits()
    for row, (name, bit) in enumerate(bits.items()):
        bars = stretches(seconds, (flags & bit) != 0, 0.0)
        colour = canvas.COLOURS[5] if name == "standing" else canvas.COLOURS[4]
        axis.broken_barh(bars, (row - 0.35, 0.7), color=colour)
    axis.set(yticks=range(len(bits)), yticklabels=list(bits), ylim=(len(bits) - 0.5, -0.5))


def flag_shares(log: logs.Log) -> dict[str, float]:
    """Share of the odometry messages in which each flag is set, 0 to 1."""
    flags = log["odometry"]["flags"]
    return {name: float(np.mean((flags & bit) != 0)) for name, bit in flag_bits().items()}
