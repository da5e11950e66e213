"""``gprodom calibrate antennas``: the distance of two antennas in a row, by a known distance."""

import argparse
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from gprodom.calibrate.fragment import Found, add_output_option, tell_found
from gprodom.config import read_antennas, read_channels
from gprodom.errors import Error, UsageError
from gprodom.files import temporary_folder
from gprodom.lcm import logs
from gprodom.odometry.estimate import as_log, estimate
from gprodom.odometry.methods import find_method
from gprodom.options import Subparsers, add_command
from gprodom.score.sources import read_estimate

Place = tuple[float, float, float]

TAPE_M = 0.01  # standard deviation of the known distance, if none is told
LEAST_SHARE = 0.5  # of the way that must lie within passages
# Revisits would bind the path to itself: the distance is to come from the pair alone.
SETTINGS = ("graph.enabled=false",)

DESCRIPTION = """\
Finds the distance along the track of the antennas in gpr.antennas, which is what two antennas in a
row measure the way by. Let the robot stand, drive to a place that is a known distance away in a
straight line, and let it stand again. The estimate by radar and IMU (no wheel message is used) is
as wrong as the antennas' distance. The uncertainty is from the passages' standard deviations, by
how much the known distance is sure, and with several recordings at least from their spread.

examples:
  gprodom calibrate antennas straight.lcmlog --distance 50 -o antennas.yaml
  gprodom calibrate antennas there.lcmlog back.lcmlog --distance 50 --sigma 0.005
"""


@dataclass(frozen=True)
class Drive:
    """Of one recording: the distance from the first to the last place as estimated, m; passages,
    and the distance's standard deviation by them, m."""

    estimated_m: float
    passages: int
    sigma_m: float


@dataclass(frozen=True)
class DistanceFit:
    """configured_m: distance of the antennas as told; distance_m: as found."""

    configured_m: float
    distance_m: float
    sigma_m: float
    passages: int


def distance_of(antennas: Mapping[int, Place]) -> float:
    """m along the track, from the rear antenna to the front one."""
    along = [place[0] for place in antennas.values()]
    if len(along) < 2 or max(along) <= min(along):
        raise Error("gpr.antennas does not have two antennas in a row: tell them with --set or -c")
    return max(along) - min(along)


def find_distance(
    drives: Sequence[Drive], configured_m: float, known_m: float, known_sigma_m: float
) -> DistanceFit:
    """The drives' mean, weighted by their variances."""
    ratios = np.array([known_m / drive.estimated_m for drive in drives])
    own = np.array([drive.sigma_m / drive.estimated_m for drive in drives])
    weights = 1 / own**2
    ratio = float(np.sum(weights * ratios) / np.sum(weights))
    by_passages = float(1 / np.sqrt(np.sum(weights)))
    spread = float(np.std(ratios, ddof=1) / np.sqrt(len(ratios))) if len(ratios) > 1 else 0.0
    # The known distance is the same in all drives.
    sigma = np.hypot(max(by_passages, spread), known_sigma_m / known_m)
    return DistanceFit(
        configured_m,
        ratio * configured_m,
        float(sigma) * configured_m,
        sum(drive.passages for drive in drives),
    )


def replayed(args: argparse.Namespace, source: Path) -> Drive:
    """Replays a recording."""
    channels = read_channels(args.configs, args.overrides)
    with temporary_folder() as folder:
        output = folder / "output.lcmlog"
        log = as_log(source, folder, None, channels)
        estimate(log, find_method("radar_imu"), args.configs, [*args.overrides, *SETTINGS], output)
        odom = read_estimate(output, "odom", channels=channels).trajectory
        found = logs.read_roles(output, channels.of("displacement")).get("displacement")
    way = float(np.linalg.norm(odom.position[-1] - odom.position[0]))
    if found is None:
        raise Error(f"{source}: the pair found nothing")
    mine = np.array([by == "pair" for by in found["source"]]) & found["valid"]
    told, sigma = np.abs(found["distance"][mine]), found["sigma"][mine]
    covered = float(told.sum())
    if not way > 0 or covered < LEAST_SHARE * way:
        raise Error(
            f"{source}: passages of the antennas cover {covered:.1f} m of {way:.1f} m: too few"
        )
    # Each tells the share of the way around it; their errors are independent.
    return Drive(way, len(told), way * float(np.sqrt(np.sum(sigma**2))) / covered)


def add_parser(subjects: Subparsers) -> None:
    """Adds ``calibrate antennas``."""
    parser = add_command(
        subjects, "antennas", "distance of two antennas in a row", DESCRIPTION, run
    )
    parser.operand("sources", "SEQ|LOG", "drive", nargs="+")
    parser.option(
        "--distance M",
        float,
        "from the first place to the last, in a straight line (m)",
        required=True,
    )
    parser.option(
        "--sigma M", TAPE_M, "standard deviation of that distance (m, default: %(default)s)"
    )
    add_output_option(parser)
    parser.common_options()


def run(args: argparse.Namespace) -> int:
    """Runs ``calibrate antennas``."""
    if args.distance <= 0 or args.sigma < 0:
        raise UsageError("--distance must be above 0, and --sigma at least 0")
    antennas = read_antennas(args.configs, args.overrides)
    configured = distance_of(antennas)
    drives = [replayed(args, source) for source in args.sources]
    found = find_distance(drives, configured, args.distance, args.sigma)
    figures = {**asdict(found), "drives": [asdict(drive) for drive in drives]}
    return tell_found(args, [_as_found(found, antennas)], figures)


def _as_found(found: DistanceFit, antennas: Mapping[int, Place]) -> Found:
    """All antennas, moved along the track away from their middle or towards it."""
    along = [place[0] for place in antennas.values()]
    middle, scale = (max(along) + min(along)) / 2, found.distance_m / found.configured_m
    places = ", ".join(
        f"{id_}: [{middle + scale * (x - middle):.5f}, {y:g}, {z:g}]"
        for id_, (x, y, z) in antennas.items()
    )
    sure = f"{found.distance_m:.5f} +- {found.sigma_m:.5f} m apart (one sigma), "
    far = abs(found.distance_m - found.configured_m) > 2 * found.sigma_m
    return Found("gpr.antennas", f"{{{places}}}", f"{sure}{found.passages} passages", far)
