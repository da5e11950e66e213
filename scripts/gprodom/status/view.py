"""The state of a daemon, as a page for a terminal and as one line."""

import math
import time

from rich.console import Group
from rich.panel import Panel
from rich.table import Table
from rich.text import Text

from gprodom import rotation
from gprodom.lcm.constants import health
from gprodom.status.heard import Heard, figures, flags, sigmas

COLOURS = {"ok": "green", "degraded": "yellow", "failed": "red"}
CLOCKS_DIFFER_S = 3600.0  # a stamp further off is that of a replayed log, not late


def line(heard: Heard) -> str:
    """Health and the most important figures."""
    now = figures(heard)
    rates = ", ".join(f"{name} {rate:.0f} Hz" for name, rate in now["rates_hz"].items())
    parts = [rates]
    if "flags" in now:
        parts += [*now["flags"], f"position +-{now['position_sigma_m']:.3f} m"]
    parts.append(f"{now['revisits']} revisits")
    if "solver.mean_ms" in now["values"]:
        parts.append(f"solver {now['values']['solver.mean_ms']:.1f} ms")
    reasons = f" ({'; '.join(now['reasons'])})" if now["reasons"] else ""
    return f"{now['health']}{reasons}: {'; '.join(parts)}"


def page(heard: Heard, url: str) -> Group:
    """Health on top, then the estimate, the channels, and the daemon's own values."""
    return Group(_health(heard, url), _estimate(heard), _channels(heard), _values(heard))


def _health(heard: Heard, url: str) -> Panel:
    status = heard.status
    if status is None:
        return Panel(f"no STATUS yet on {url}: is gprodomd running?", style="yellow")
    word = health(status.health)
    text = "\n".join([word, *status.reasons])
    return Panel(text, title=f"gprodomd on {url}", style=COLOURS[word])


def _estimate(heard: Heard) -> Table:
    table = Table.grid(padding=(0, 2))
    odometry = heard.odometry
    if odometry is None:
        table.add_row("estimate", "none yet: the robot must stand still to start")
        return table
    position, yaw_sigma = sigmas(odometry)
    yaw = rotation.yaw_of(odometry.orientation)
    table.add_row("position", "{:.3f} {:.3f} {:.3f} m".format(*odometry.position))
    table.add_row("", f"+-{position:.3f} m in the plane")
    table.add_row("heading", f"{math.degrees(yaw):.1f} +-{math.degrees(yaw_sigma):.2f} deg")
    table.add_row("speed", f"{odometry.velocity[0]:.2f} m/s, {odometry.distance:.1f} m travelled")
    scale = f"{odometry.wheel_scale:.4f} +-{odometry.wheel_scale_sigma:.4f}"
    table.add_row("wheel scale", scale)
    correction = heard.correction
    table.add_row("revisits", str(correction.revisits if correction else 0))
    table.add_row("flags", Text(", ".join(flags(odometry)) or "none", style="bold"))
    return table


def _channels(heard: Heard) -> Table:
    table = Table(title="channels", title_justify="left")
    for name in ("channel", "type", "Hz", "delay ms"):
        table.add_column(name, justify="left" if name in ("channel", "type") else "right")
    now, clock = time.monotonic(), time.time()
    for name, channel in sorted(heard.channels.items()):
        delay = clock - channel.utime * 1e-6
        shown = f"{1e3 * delay:.0f}" if abs(delay) < CLOCKS_DIFFER_S else "other clock"
        table.add_row(name, channel.type, f"{channel.rate(now):.1f}", shown)
    return table


def _values(heard: Heard) -> Table:
    table = Table(title="counts and times", title_justify="left", show_header=False)
    if heard.status is not None:
        for name, value in zip(heard.status.names, heard.status.values, strict=True):
            table.add_row(name, f"{value:g}")
    return table
