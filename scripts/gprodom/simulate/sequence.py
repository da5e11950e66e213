"""A whole sequence: a drive seen by IMU, wheel, radar and total station."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from gprodom.arrays import Floats, Ints
from gprodom.convert.cmu import Traces
from gprodom.ground.survey import find_survey
from gprodom.random_streams import Random, stream
from gprodom.simulate import imu, pair, radar, wheel
from gprodom.simulate.antennas import AntennaSpec, receive
from gprodom.simulate.drive import Drive, DriveSpec, Motion
from gprodom.simulate.ground import Ground, GroundSpec
from gprodom.simulate.imu import ImuData, ImuSpec
from gprodom.simulate.pair import PairData, PairSpec
from gprodom.simulate.radar import RadarSpec
from gprodom.simulate.wheel import WheelData, WheelSpec

_TRUTH_RATE = 20.0  # Hz


@dataclass(frozen=True)
class StationSpec:
    """A total station that follows a prism on the robot, in a frame of its own."""

    rate: float = 8.0  # Hz
    jitter: float = 0.005  # s, of the intervals
    noise: float = 0.0015  # m
    height: float = 1.2  # m
    prism: tuple[float, float] = (0.0, 0.0)  # m, in body


@dataclass(frozen=True)
class SurveySpec:
    """Ground of survey lines (`gprodom.ground`), by name or file, along the drive's track.

    `middle` (m): the track lies here between the first line and the others.
    """

    survey: str
    middle: float = 0.03


@dataclass(frozen=True)
class Spec:
    """What to simulate. `ground` or `station` None: no such sensor. Slips add to the wheel's."""

    drive: DriveSpec
    imu: ImuSpec = field(default_factory=ImuSpec)
    wheel: WheelSpec = field(default_factory=WheelSpec)
    pair: PairSpec | None = None  # left and right wheels: `wheel` is their mean then
    radar: RadarSpec = field(default_factory=RadarSpec)
    # Several antennas: all of them, each with its own radar; `radar` then says only their rate.
    antennas: tuple[AntennaSpec, ...] = ()
    ground: GroundSpec | SurveySpec | None = field(default_factory=GroundSpec)
    station: StationSpec | None = field(default_factory=StationSpec)
    slips: int = 0  # drawn episodes
    kind: str = ""  # of drive, for the record
    start_utime: int = 1_700_000_000_000_000  # us since 1970


@dataclass(frozen=True)
class Simulated:
    """Sensor data and truth. Times are int64 microseconds since 1970."""

    spec: Spec  # with the slips that were drawn
    seed: int
    imu_utime: Ints
    imu: ImuData
    wheel_utime: Ints
    wheel: WheelData
    pair: PairData | None  # at the wheel's times
    gpr_utime: Ints
    traces: Ints  # (g, samples); g = 0 without radar
    more_antennas: dict[int, Traces]  # by antenna_id, from 1 on
    sample_interval: float | None  # s, of the radar
    station_utime: Ints
    station: Floats  # (t, 3), m, in the station's frame
    truth_utime: Ints
    truth: Motion
    drive: Drive  # for the truth at any other time

    def motion_at(self, utime: Ints) -> Motion:
        """The true motion at `utime` (us since 1970)."""
        return self.drive.at((utime - self.spec.start_utime) * 1e-6)

    def position_from(self, origin: int, utime: Ints) -> Floats:
        """True x, y (n, 2), m, at `utime` in the frame of the true pose at `origin` (us)."""
        start, motion = self.motion_at(np.array([origin])), self.motion_at(utime)
        cos, sin = np.cos(start.yaw), np.sin(start.yaw)
        dx, dy = motion.x - start.x, motion.y - start.y
        return np.column_stack([cos * dx + sin * dy, -sin * dx + cos * dy])


def simulate(spec: Spec, seed: int) -> Simulated:
    """The same `spec` and `seed` give the same numbers."""
    drive = Drive(spec.drive, stream(seed, "drive"))
    clock = stream(seed, "clock")

    def ticks(rate: float) -> Ints:
        """Times (us from the start) at `rate`, at a phase of the sensor's own."""
        period = round(1e6 / rate)
        phase = int(clock.randint(period))
        return np.arange(phase, int(drive.duration * 1e6), period, dtype=np.int64)

    imu_time = ticks(spec.imu.rate)
    imu_t = imu_time * 1e-6
    wheel_time = ticks(spec.pair.rate if spec.pair else spec.wheel.rate)
    wheel_t = wheel_time * 1e-6
    wheel_motion = drive.at(wheel_t)
    drawn = wheel.draw_slips(spec.slips, wheel_t, wheel_motion.v, stream(seed, "slip"))
    spec = replace(spec, wheel=replace(spec.wheel, slips=spec.wheel.slips + drawn))

    sides, counted = _count(drive, wheel_t, wheel_motion, spec, seed)

    seen, sample_interval = [Traces(np.zeros(0, np.int64), np.zeros((0, 0), np.int32))], None
    if spec.ground is not None:
        due = ticks(spec.radar.rate)
        if spec.radar.spacing:  # the sides' mean is the wheel
            counted_m = counted.ticks * spec.wheel.quantum
            due = np.unique(
                np.rint(1e6 * wheel.trigger(wheel_t, counted_m, spec.radar.spacing))
            ).astype(np.int64)
        seen, sample_interval = _radar(drive, due, spec, seed)
    station_time, station = np.zeros(0, np.int64), np.zeros((0, 3))
    if spec.station is not None:
        station_time, station = _survey(drive, spec.station, stream(seed, "station"))
    truth_time = np.arange(0, int(drive.duration * 1e6), round(1e6 / _TRUTH_RATE), dtype=np.int64)
    return Simulated(
        spec=spec,
        seed=seed,
        imu_utime=spec.start_utime + imu_time,
        imu=imu.measure(drive.at(imu_t), spec.imu, stream(seed, "imu"), _turning(spec, imu_t)),
        wheel_utime=spec.start_utime + wheel_time,
        wheel=counted,
        pair=sides,
        gpr_utime=spec.start_utime + seen[0].utime,
        traces=seen[0].counts,
        more_antennas={
            i: Traces(spec.start_utime + of.utime, of.counts)
            for i, of in enumerate(seen[1:], start=1)
        },
        sample_interval=sample_interval,
        station_utime=spec.start_utime + station_time,
        station=station,
        truth_utime=spec.start_utime + truth_time,
        truth=drive.at(truth_time * 1e-6),
        drive=drive,
    )


def _turning(spec: Spec, t: Floats) -> Floats:
    """Speed of the wheel (m/s) at the times `t` (s) where the robot is stuck, else 0."""
    speeds = [stuck.wheel_speed(t) for stuck in spec.wheel.stuck]
    return np.asarray(sum(speeds, np.zeros(len(t))))


def _count(
    drive: Drive, t: Floats, motion: Motion, spec: Spec, seed: int
) -> tuple[PairData | None, WheelData]:
    """Counts at `t` (s) of the two sides, if there are any, and of the wheel."""
    if spec.pair is None:
        return None, wheel.measure(t, motion, spec.wheel, stream(seed, "wheel"))
    sides = pair.measure(t, drive, spec.pair, stream(seed, "pair"))
    ticks = np.rint(
        0.5 * (sides.left + sides.right) * (spec.pair.quantum / spec.wheel.quantum)
    ).astype(np.int64)
    return sides, WheelData(ticks, np.full(len(t), sides.scale))


def _at(motion: Motion, arm: tuple[float, float]) -> tuple[Floats, Floats]:
    """World position (n,), m, of a point of the robot."""
    cos, sin = np.cos(motion.yaw), np.sin(motion.yaw)
    return motion.x + cos * arm[0] - sin * arm[1], motion.y + sin * arm[0] + cos * arm[1]


def _radar(drive: Drive, time: Ints, spec: Spec, seed: int) -> tuple[list[Traces], float]:
    """The traces of each antenna, their times in us from the start; the sample interval, s."""
    if not spec.antennas:
        t = time * 1e-6
        (clean,), interval = _look(drive, [t], [spec.radar.lever_arm], spec, seed)
        counts = radar.measure(clean, t, interval, spec.radar, stream(seed, "radar"))
        return [Traces(time, counts)], interval
    times = [time + round(1e6 * antenna.late) for antenna in spec.antennas]
    times = [part[part < int(drive.duration * 1e6)] for part in times]
    arms = [antenna.radar.lever_arm for antenna in spec.antennas]
    cleans, interval = _look(drive, [part * 1e-6 for part in times], arms, spec, seed)
    seen = []
    for i, (part, clean, antenna) in enumerate(zip(times, cleans, spec.antennas, strict=True)):
        t, errors = part * 1e-6, stream(seed, f"antenna {i}")
        counts = receive(clean, t, drive.at(t).travelled, interval, antenna, errors)
        seen.append(Traces(part, counts))
    return seen, interval


def _look(
    drive: Drive,
    times: Sequence[Floats],
    arms: Sequence[tuple[float, float]],
    spec: Spec,
    seed: int,
) -> tuple[list[Floats], float]:
    """Noise-free traces (n, samples) of each antenna at its times, counts, and their sample
    interval, s."""
    motions = [drive.at(time) for time in times]
    places = [_at(motion, arm) for motion, arm in zip(motions, arms, strict=True)]
    if isinstance(spec.ground, SurveySpec):
        survey = find_survey(spec.ground.survey)
        view = survey.decorrelating().turned_traces if spec.antennas else survey.traces
        seen = []
        for motion, arm, (x, y) in zip(motions, arms, places, strict=True):
            along, beside = drive.beside_track(motion.s + arm[0], x, y)
            seen.append(view(along, beside + spec.ground.middle))
        return seen, survey.sample_interval
    assert spec.ground is not None
    everywhere = [np.concatenate(part) for part in zip(*places, strict=True)]
    ground = Ground(spec.ground, everywhere[0], everywhere[1], stream(seed, "ground"))
    return [ground.traces(x, y) for x, y in places], spec.ground.sample_interval


def _survey(drive: Drive, spec: StationSpec, random: Random) -> tuple[Ints, Floats]:
    """Times (us from the start) and positions (n, 3) as a total station reports them."""
    count = int(drive.duration * spec.rate)
    steps = 1.0 / spec.rate + spec.jitter * np.clip(random.standard_normal(count), -3, 3)
    time = np.cumsum(np.rint(steps * 1e6).astype(np.int64))
    time = time[time < int(drive.duration * 1e6)]
    x, y = _at(drive.at(time * 1e-6), spec.prism)
    yaw, origin = random.uniform(-np.pi, np.pi), random.uniform(-20, 20, 2)
    cos, sin = np.cos(yaw), np.sin(yaw)
    position = np.column_stack(
        [
            origin[0] + cos * x - sin * y,
            origin[1] + sin * x + cos * y,
            np.full(len(time), spec.height),
        ]
    )
    return time, position + spec.noise * random.standard_normal(position.shape)
