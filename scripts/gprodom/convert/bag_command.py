"""``gprodom convert bag``: ROS bags to LCM logs."""

import argparse
from pathlib import Path

from gprodom.config import read_channels
from gprodom.console import format_table, tell
from gprodom.convert.bag import Topics, read_streams
from gprodom.convert.bag_reader import NONE
from gprodom.convert.plausible import check_streams
from gprodom.convert.sampling import add_sample_interval_option
from gprodom.convert.summary import TIME_FACTS, describe_times
from gprodom.convert.wheels import WheelSpec
from gprodom.errors import UsageError
from gprodom.fixes.record import Quality
from gprodom.lcm.log_writer import Stream, write_log
from gprodom.options import Subparsers, add_command

DESCRIPTION = """\
Converts a ROS 1 or ROS 2 bag to an LCM log; no ROS is needed. If a topic is not named, the only one
of a fitting type is used:

  --imu    sensor_msgs/Imu
  --wheel  nav_msgs/Odometry (its pose), geometry_msgs/TwistStamped (its speed, forwards) or
           sensor_msgs/JointState (with --wheel-radius): one wheel, or with --left and --right two
           sides. With --track, the yaw rate of an odometry's or stamped twist makes two sides, too
  --truth  sensor_msgs/NavSatFix (to local metres), or a PointStamped, PoseStamped or
           PoseWithCovarianceStamped of geometry_msgs
  --gpr    any message with an array `samples` or `data`: a trace. Given several times, each topic
           is an antenna; its id is that in the messages' antenna_id, where every topic has its own,
           else 0, 1, ... in the order given
  --fix    sensor_msgs/NavSatFix, or PoseWithCovarianceStamped of geometry_msgs (its frame is taken
           for site): positions from outside, which tie the estimate to site. Only what is named;
           several make antennas 0, 1, ... of anchor.antennas

If the bag has several, the error lists them, and you must name one. `--gpr none` and `--truth none`
leave them out. A ROS 2 bag is given by its folder, or by its one .mcap or .db3 file.

Stamps are those of the headers, or the time of recording if they have none. If the IMU is not
mounted along the robot's axes, set imu.rpy_body_imu in the configuration.

The status of a NavSatFix gives the quality of a fix: single, of a GBAS one `fixed` where its
standard deviation is 5 cm or less, else `float`; so is a pose's by its covariance. --fix-quality
says otherwise. A covariance that is not told is replaced by a conservative one, with a warning.

examples:
  gprodom convert bag husky.bag -o husky.lcmlog --imu /imu/data \\
    --wheel /husky_velocity_controller/odom --truth /fix
  gprodom convert bag run.bag -o run.lcmlog --wheel /odom --truth none --fix /gnss/front
  gprodom convert bag run.bag --wheel /joint_states --wheel-radius 0.165 -o run.lcmlog \\
    --left front_left,rear_left --right front_right,rear_right
  gprodom convert bag run.bag --wheel /odom --track 0.55 -o run.lcmlog
"""


def add_parser(formats: Subparsers) -> None:
    """Adds ``convert bag``."""
    parser = add_command(formats, "bag", "a ROS bag", DESCRIPTION, run)
    parser.operand("bag", "BAG", "file, or folder of a ROS 2 bag")
    parser.output("LOG", "LCM log")
    for what in ("imu", "wheel", "truth"):
        parser.option(f"--{what} TOPIC", str, "see above")
    parser.option("--gpr TOPIC", str, "see above", action="append", default=[], dest="radars")
    parser.option("--fix TOPIC", str, "see above", action="append", default=[], dest="fixes")
    parser.choice(
        "--fix-quality",
        [quality.name.lower() for quality in Quality if quality],
        None,
        "quality of all fixes with a position (default: what the messages say)",
    )
    parser.option("--wheel-radius M", 0.0, "radius of the wheel of a joint")
    parser.option("--joint NAME", str, "name of the wheel's joint (default: the first)")
    for side in ("left", "right"):
        parser.option(f"--{side} NAMES", "", f"joints of the {side} side, by commas")
    parser.option("--track M", 0.0, "distance between left and right, as in the robot's driver")
    add_sample_interval_option(
        parser, "seconds between radar samples (default: what the messages say)"
    )
    parser.common_options()


def run(args: argparse.Namespace) -> int:
    """Converts and prints what there is."""
    left, right = (tuple(filter(None, side.split(","))) for side in (args.left, args.right))
    if bool(left) != bool(right):
        raise UsageError("--left and --right: expected both, or neither")
    if NONE in args.radars and len(args.radars) > 1:
        raise UsageError(f"--gpr {NONE}: leaves the radar out, and another --gpr names one")
    topics = Topics(
        imu=args.imu,
        wheel=args.wheel,
        radars=tuple(dict.fromkeys(args.radars)),
        truth=args.truth,
        wheels=WheelSpec(args.wheel_radius, args.joint, left, right, args.track),
        fixes=tuple(dict.fromkeys(args.fixes)),
        fix_quality=Quality[args.fix_quality.upper()] if args.fix_quality else None,
        sample_interval=args.sample_interval,
        channels=read_channels(args.configs, args.overrides),
    )
    write_and_tell(read_streams(args.bag, topics), args.output, args.json)
    return 0


def write_and_tell(streams: list[Stream], output: Path, as_json: bool) -> None:
    """Checks, writes the log and prints counts, rates and gaps of its channels."""
    check_streams(streams)
    write_log(output, streams)
    facts = {each.name: describe_times(each.utime, each.out_of_order) for each in streams}
    rows = [[channel, *(fact[name] for name in TIME_FACTS)] for channel, fact in facts.items()]
    text = format_table(["channel", *TIME_FACTS.values()], rows)
    tell(as_json, {"log": str(output), "channels": facts}, text)
