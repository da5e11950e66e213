"""``gprodom simulate``: a sequence in the format of CMU-GPR, from a seed."""

import argparse
from dataclasses import replace
from pathlib import Path

from gprodom.console import Progress, add_json_flag, tell
from gprodom.errors import UsageError
from gprodom.files import Output
from gprodom.ground.pipes import read_pipes
from gprodom.ground.survey import find_survey, shipped
from gprodom.options import Subparsers, add_command, numbers, point
from gprodom.random_streams import stream
from gprodom.simulate import lasting
from gprodom.simulate.antennas import draw_antennas
from gprodom.simulate.drive import DriveSpec
from gprodom.simulate.files import write_sequence
from gprodom.simulate.ground import GroundSpec
from gprodom.simulate.radar import RadarSpec
from gprodom.simulate.robot import KINDS, of_kind, robot
from gprodom.simulate.routes import ROUTES, make_route
from gprodom.simulate.sequence import Spec, SurveySpec, simulate
from gprodom.simulate.surface import SURFACES
from gprodom.simulate.wheel import WheelSpec

RAYS, NONE = "rays", "none"
SPEED = 0.6  # m/s
FARTHEST = 100.0  # m, as imu.lever_arm

_place = numbers(
    f"X,Y,Z in metres, -{FARTHEST:g} to {FARTHEST:g} m each",
    lambda values: len(values) == 3 and all(abs(value) <= FARTHEST for value in values),
)

DESCRIPTION = """\
Simulates a drive and writes it in the format of the CMU-GPR dataset, for `gprodom convert cmu`: as
a zip if OUT ends in .zip, otherwise as a directory; or as a log if OUT ends in .lcmlog. The truth
is written beside it as OUT.truth.npz and OUT.json. The same arguments give the same bytes.

The ground is either that of survey lines by FDTD, which `gprodom ground` writes (garage, basement
and floor come with the package), or one of scatterers and layers by travel time (`rays`), which is
fast and covers the whole plane, but has no wave physics. FDTD ground repeats after its length
(10 m): laps have that length, and lines are shorter.

The robot has the faults of a real one: IMU noise of an MTi-30, vibration that grows with speed, an
encoder of 0.182 mm, radar gain and time zero that drift, ringing, spikes, and a lateral offset of
some centimetres from pass to pass. With --plain the errors are exactly those of the estimator's
default configuration.

--robot chooses another robot, with left and right wheels, which only an LCM log can hold: a cart or
a rover with differential drive, a skid steer (20 Hz; wheel values held at 4 Hz and late), or a car
(with a running engine). --surface sets how it slips, rumbles and tilts. --slips are then moments in
which one side spins.

Several --antenna are several radars, sampled 4 ms after each other and written as gpr_meas.csv,
gpr_meas_1.csv, ... Each has faults of its own: gain, time zero (up to 1 ns apart), pulse, ringing,
noise, bounce, spikes; and is some millimetres from where it is told to be. OUT.json has the places
as told (`antennas`) and as they are (`antennas_true`). On survey lines the ground then differs
beside the track as real ground does.

--lasting adds slip of both sides, or of the one wheel, that lasts: ramps (sets in and ends over 2
to 8 s, 5 to 35 %, on half of the way), steps (another level every 10 to 60 s), turns (grows with
curvature and acceleration), or as recorded on gravel or ice.

examples:
  gprodom simulate --seed 7 -o 1700000000-0-yard-cmu-gpr.zip
  gprodom simulate --robot skid_steer --surface gravel --ground none --route loop -o field.lcmlog
  gprodom simulate --ground basement --route eight --slips 4 -o 1700000000-0-cellar-cmu-gpr
"""


def add_parser(subparsers: Subparsers) -> None:
    """Adds ``simulate``."""
    parser = add_command(subparsers, "simulate", "make a sequence from a seed", DESCRIPTION, run)
    parser.add_argument("-o", "--output", metavar="OUT", type=Output, required=True)
    parser.option("--seed SEED", 0, "seed of all random errors, 0 or more (default: %(default)s)")
    parser.choice(
        "--route",
        ROUTES,
        "line",
        "default: %(default)s, with reversals; eight: figure of eight; stops: at many places",
    )
    parser.option("--distance M", 30.0, "default: %(default)s")
    parser.option("--speed M/S", float, "top speed (default: 0.6, or the robot's own)")
    parser.choice("--robot", sorted(KINDS), None, "see above")
    parser.choice(
        "--surface", sorted(SURFACES), None, "surface that the robot drives on (default: floor)"
    )
    parser.option("--standstill S", 6.0, "standstill at the start (default: %(default)s)")
    parser.option("--slips N", 0, "slip or skid episodes (default: 0)")
    parser.option(
        "--lasting KIND",
        "",
        f"slip that lasts for seconds to minutes: {', '.join(lasting.KINDS)} (default: none)",
        choices=lasting.KINDS,
    )
    parser.option(
        "--ground NAME|FILE",
        RAYS,
        f"{', '.join(shipped())}, a file of `gprodom ground`, {RAYS} or {NONE} (no radar; "
        "default: %(default)s)",
    )
    parser.option(
        "--antenna X,Y",
        point,
        "the radar's middle in body, m (default: 0,0); again for each further antenna",
        action="append",
    )
    parser.option(
        "--trigger-distance M",
        0.0,
        "the wheel makes a trace each M metres that it counts, slip included, and none at "
        "rest (default: a clock, 20 traces/s)",
    )
    for name, what in (
        ("contact", "the wheel's point of contact"),
        ("prism", "the total station's prism"),
    ):
        parser.option(
            f"--{name} X,Y", point, f"{what} in body, m (default: 0,0)", default=(0.0, 0.0)
        )
    parser.option(
        "--imu X,Y,Z",
        _place,
        "the IMU's place in body, m: turning adds accelerations there (default: 0,0,0)",
        default=(0.0, 0.0, 0.0),
    )
    parser.option(
        "--pipes FILE",
        Path,
        f"pipes across the x axis in ground {RAYS}, as gprodom run --pipes reads them (those "
        "of other ground are in its scene)",
    )
    parser.flag("--plain", "see above")
    add_json_flag(parser)


def make_spec(args: argparse.Namespace) -> Spec:
    """The specification given by the arguments."""
    speed = args.speed or (KINDS[args.robot].speed if args.robot else SPEED)
    ground: GroundSpec | SurveySpec | None = None
    if args.ground == RAYS:
        pipes = read_pipes(args.pipes) if args.pipes else None
        ground = GroundSpec(
            pipes=() if pipes is None else tuple(zip(pipes.x, pipes.depth, strict=True))
        )
    length = None
    if args.ground not in (RAYS, NONE):
        ground, length = SurveySpec(args.ground), find_survey(args.ground).length
    drive: DriveSpec = make_route(
        args.route, args.distance, speed, args.standstill, stream(args.seed, "route"), length
    )
    if args.plain:
        if args.antenna or args.contact != (0, 0) or args.prism != (0, 0) or any(args.imu):
            raise UsageError("--plain: takes no --antenna, --contact, --prism or --imu")
        wheel = WheelSpec(lasting=args.lasting)
        radar = RadarSpec(spacing=args.trigger_distance)
        return Spec(
            drive, ground=ground, wheel=wheel, radar=radar, slips=args.slips, kind=args.route
        )
    antennas = args.antenna or [(0.0, 0.0)]
    plain = robot(
        drive,
        ground,
        kind=args.route,
        slips=args.slips,
        lasting=args.lasting,
        antenna=antennas[0],
        contact=args.contact,
        prism=args.prism,
    )
    spec = replace(plain, radar=replace(plain.radar, spacing=args.trigger_distance))
    if len(antennas) > 1:
        drawn = draw_antennas(antennas, spec.radar, stream(args.seed, "antennas"))
        spec = replace(spec, antennas=drawn)
    if args.robot:
        spec = of_kind(args.robot, args.surface or "floor", spec)
    return replace(spec, imu=replace(spec.imu, lever_arm=args.imu))


def check(args: argparse.Namespace) -> None:
    """Raises `UsageError` if the arguments contradict each other."""
    for name, low, high in (
        ("seed", 0, 2**63),
        ("distance", 1, 5000),
        ("speed", 0.05, 20),
        ("standstill", 0, 3600),
        ("slips", 0, 1000),
    ):
        value = getattr(args, name)
        if value is not None and not low <= value <= high:
            raise UsageError(f"--{name} {value}: expected {low} to {high}")
    if args.surface and not args.robot:
        raise UsageError("--surface: wants a --robot")
    if args.trigger_distance != 0 and not 0.002 <= args.trigger_distance <= 1:
        raise UsageError(f"--trigger-distance {args.trigger_distance}: expected 0.002 to 1, or 0")
    if args.pipes and args.ground != RAYS:
        raise UsageError(f"--pipes: wants --ground {RAYS}")
    if args.robot and (args.plain or args.contact != (0, 0)):
        raise UsageError("--robot: takes no --plain or --contact")


def run(args: argparse.Namespace) -> int:
    """Simulates and writes."""
    check(args)
    spec = make_spec(args)
    with Progress("simulating", 2) as progress:
        simulated = simulate(spec, args.seed)
        progress.advance()
        paths = write_sequence(simulated, args.output)
        progress.advance()
    facts = {
        "files": [str(path) for path in paths],
        "duration_s": simulated.drive.duration,
        "distance_m": float(simulated.truth.travelled[-1]),
        "wheel_scale": float(simulated.wheel.scale[0]),
        "slips": len(simulated.spec.wheel.slips),
        "traces": len(simulated.gpr_utime),
    }
    text = (
        f"{paths[0]}: {facts['distance_m']:.1f} m in {facts['duration_s']:.1f} s, "
        f"{facts['traces']} traces, wheel scale {facts['wheel_scale']:.4f}, {facts['slips']} slips"
    )
    tell(args.json, facts, text)
    return 0
