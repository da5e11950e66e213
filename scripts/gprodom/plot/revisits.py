"""``gprodom plot revisits``: the loop closures and their effect on the map."""

import argparse
from dataclasses import dataclass

import numpy as np

from gprodom import canvas
from gprodom.arrays import Bools, Floats, Ints
from gprodom.config import read_channels
from gprodom.console import format_table, tell
from gprodom.errors import Error
from gprodom.lcm import logs
from gprodom.lcm.constants import kind
from gprodom.options import Subparsers, add_command
from gprodom.score.sources import odometry
from gprodom.trajectory import Trajectory, interpolate

DESCRIPTION = """\
Draws the revisits (loop closures) of an estimator's log: pairs of places on its path that the radar
recognised as the same ground (in the same direction, or mirrored), the pairs along time, their
distance on the path, and the size of the map's corrections. Prints counts.

examples:
  gprodom plot revisits out.lcmlog -o revisits.png
"""


@dataclass(frozen=True)
class Revisits:
    """n pairs: times (n,), us; metres from one place to the other along the track (n,); mirrored
    (n,): matched back to front."""

    start: Ints
    end: Ints
    distance: Floats
    mirrored: Bools

    def select(self, chosen: Bools | Ints) -> "Revisits":
        """Those chosen."""
        return Revisits(*(values[chosen] for values in vars(self).values()))

    def within(self, path: Trajectory) -> "Revisits":
        """Those of which both sights are in the time of the path."""
        return self.select((self.start >= path.time[0]) & (self.end <= path.time[-1]))


def find_revisits(log: logs.Log) -> Revisits:
    """The valid ones of a log, in the order of their ends."""
    content = logs.need(log, "displacement")
    names = ("utime_from", "utime_to", "distance", "mirrored")
    wanted = (content["kind"] == kind("REVISIT")) & content["valid"]
    found = Revisits(*(content[name][wanted] for name in names))
    return found.select(np.argsort(found.end, kind="stable"))


def revisits_figure(
    path: Trajectory, found: Revisits, correction: logs.Channel | None, title: str
) -> canvas.Figure:
    """From above, and along time."""
    figure, axes = canvas.new_figure(2, 2, width=11.0, height=8.0)
    seen = found.within(path)
    start, end = (interpolate(path, t).position[:, :2] for t in (seen.start, seen.end))
    origin = int(path.time[0])
    above, pairs, apart, jumps = axes
    above.plot(*path.position[:, :2].T, color="0.6", lw=1.0, label="path")
    for mirrored, colour, marker, name in (
        (False, canvas.COLOURS[0], "o", "as then"),
        (True, canvas.COLOURS[1], "x", "mirrored"),
    ):
        those = seen.mirrored == mirrored
        count = int(those.sum())
        label: str | None = f"{name}: {count}"
        for a, b in zip(start[those], end[those], strict=True):
            above.plot(*np.stack([a, b]).T, f"{marker}-", color=colour, ms=3, lw=1.0, label=label)
            label = None
        clock = [(t[those] - origin) * 1e-6 for t in (seen.start, seen.end)]
        pairs.plot(clock[1], clock[0], marker, ms=3, color=colour, label=f"{name}: {count}")
        gap = np.linalg.norm(end[those] - start[those], axis=1)
        apart.plot(clock[1], gap, marker, ms=3, color=colour)
    canvas.seen_from_above(above)
    earlier = int(np.count_nonzero(found.start < path.time[0]))
    above.set_title(
        "places known again" + (f" ({earlier} more of earlier drives)" if earlier else "")
    )
    canvas.legend_below(above, 3)
    pairs.set(title="when, and when they were seen first", xlabel="time (s)")
    pairs.set_ylabel("seen first at (s)")
    canvas.legend_below(pairs, 2)
    apart.set(xlabel="time (s)", title="how far apart the path has both sights of a place")
    apart.set(ylabel="distance (m)", ylim=(0, None))
    if correction is not None and len(correction["utime"]):
        size = np.linalg.norm(correction["position"][:, :2], axis=1)
        held = _held((correction["utime"] - origin) * 1e-6, size, path.seconds()[-1])
        jumps.plot(*held, drawstyle="steps-post", color=canvas.COLOURS[2], lw=1.2)
    jumps.set(xlabel="time (s)", title="how far map is from odom", ylabel="correction (m)")
    jumps.set_ylim(bottom=0)
    for axis in (pairs, apart, jumps):
        axis.set_xlim(0, (path.time[-1] - origin) * 1e-6)
    figure.suptitle(title)
    return figure


def _held(clock: Floats, size: Floats, end: float) -> tuple[Floats, Floats]:
    """A correction holds until the next one: from none at the begin to the last one at `end`."""
    return (
        np.concatenate([[min(0.0, clock[0])], clock, [max(end, clock[-1])]]),
        np.concatenate([[0.0], size, size[-1:]]),
    )


def add_parser(subjects: Subparsers) -> None:
    """Adds ``plot revisits``."""
    parser = add_command(subjects, "revisits", "places that the radar knew again", DESCRIPTION, run)
    parser.operand("log", "LOG", "output of a replay or a recording")
    parser.picture_output()
    parser.common_options()


def run(args: argparse.Namespace) -> int:
    """Runs ``plot revisits``."""
    channels = read_channels(args.configs, args.overrides)
    roles = channels.of("displacement", "odometry_map", "odometry", "correction")
    log = logs.read_roles(args.log, roles)
    published = log.get("odometry_map", log.get("odometry"))
    if published is None:
        wanted = channels.odometry
        raise Error(f"{args.log}: holds no {wanted} messages; expected a log of the estimator")
    found = find_revisits(log)
    correction = log.get("correction")
    figure = revisits_figure(odometry(published), found, correction, args.log.stem)
    canvas.save(figure, args.output)
    counts = {
        "revisits": len(found.start),
        "mirrored": int(found.mirrored.sum()),
        "corrections": 0 if correction is None else len(correction["utime"]),
    }
    tell(args.json, counts, format_table(["what", "count"], list(counts.items())))
    return 0
