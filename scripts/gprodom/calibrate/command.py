"""``gprodom calibrate`` and its subjects."""

from gprodom.calibrate import antennas, imu, k, mount, timing, wheel
from gprodom.options import Subparsers, add_command

DESCRIPTION = """\
Finds constants of a robot and a scene in recordings, and says how sure they are.

examples:
  gprodom calibrate wheel drive.lcmlog -o wheel.yaml
  gprodom calibrate imu standstill.lcmlog -o imu.yaml
  gprodom calibrate mount drive.lcmlog -o mount.yaml
  gprodom calibrate time drive.lcmlog
  gprodom calibrate antennas straight.lcmlog --distance 50
  gprodom calibrate k 1700001000-0-gates_g-cmu-gpr.zip 1700002000-0-gates_g-cmu-gpr.zip
"""


def add_parser(subparsers: Subparsers) -> None:
    """Adds ``calibrate`` and its subjects."""
    parser = add_command(
        subparsers, "calibrate", "find constants of a robot from recordings", DESCRIPTION
    )
    subjects = parser.add_subparsers(metavar="WHAT", required=True)
    for subject in (wheel, imu, mount, timing, antennas, k):
        subject.add_parser(subjects)
