"""``gprodom doctor``."""

import argparse
from dataclasses import asdict

from gprodom.config import AUTO, mounting_angles, read_antennas
from gprodom.console import print_json
from gprodom.convert.sampling import add_sample_interval_option
from gprodom.lcm.antennas import counts, named
from gprodom.options import Subparsers, add_command

DESCRIPTION = """\
Reads a recording and names what is wrong with it, each with the setting or command that mends it:
units, signs and axes, left and right swapped, rates, gaps, clocks, the size of a tick, counters
that begin anew, traces triggered by the wheel, saturated, empty or repeated traces, a wrong sample
interval. What the drive does not show is not judged: bends show the gyro's sign, starts and stops
the mounting, clocks and the tick's size. Of several antennas the traces of each are counted and
judged, and those that the estimator refuses, because gpr.antennas has not their place, are told.
Exit code 0 where nothing is found, else 1.

examples:
  gprodom doctor drive.lcmlog
  gprodom doctor drive.lcmlog -c robot.yaml --json
"""


def add_parser(subparsers: Subparsers) -> None:
    """Adds ``doctor``."""
    parser = add_command(subparsers, "doctor", "what is wrong with a recording", DESCRIPTION, run)
    parser.operand("source", "LOG|SEQ")
    add_sample_interval_option(parser)
    parser.common_options()


def run(args: argparse.Namespace) -> int:
    """Reads, examines, tells."""
    from gprodom.doctor.examine import examine
    from gprodom.drive.imu_mounting import ImuMounting
    from gprodom.odometry.estimate import read_sensors
    from gprodom.odometry.settings import read_settings

    settings = read_settings(args.configs, args.overrides)
    log = read_sensors(args, args.source, "imu", "wheel", "gpr_trace")
    band = settings["gpr"]["filter"]
    imu = settings["imu"]
    mounting = ImuMounting(mounting_angles(imu["rpy_body_imu"]), tuple(imu["lever_arm"]))
    places = read_antennas(args.configs, args.overrides)
    limits = float(band["band_low"]), float(band["band_high"])
    found = examine(log, mounting, limits, places)
    if imu["rpy_body_imu"] == AUTO:  # the estimator finds its axes
        found = [each for each in found if each.code != "axes"]
    if args.json:
        print_json([asdict(each) for each in found])
    else:
        if "gpr_trace" in log and len(counts(log["gpr_trace"])) > 1:
            print(f"antennas: {named(log['gpr_trace'])}")
        for each in found:
            print(f"{each.code}: {each.what}\n    mend: {each.mend}")
        if not found:
            print("nothing found")
    return 1 if found else 0
