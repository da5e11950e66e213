"""An IMU at the track point or beside it: exact kinematics, biases that walk, and white noise.

Defaults equal those of ``imu`` in the estimator's configuration.
"""

from dataclasses import dataclass

import numpy as np

from gprodom.arrays import Floats
from gprodom.random_streams import Random, gauss_markov
from gprodom.rotation import added_by_turning
from gprodom.rotation import from_rpy as rotation_from_rpy
from gprodom.simulate.drive import Motion

_INSTABILITY_TIME = 100.0  # s
_RESONANCE, _RESONANCE_WIDTH = 23.0, 6.0  # Hz, of a frame on wheels
_RUMBLE_TIME = 0.5  # s, of the slow part of rumble
_ENGINE, _ENGINE_WANDER = 27.0, 0.6  # Hz: twice a turn at 810/min; in a second


@dataclass(frozen=True)
class ImuSpec:
    """Biases at the start are drawn from their sigmas; densities are per axis."""

    rate: float = 200.0  # Hz
    rpy_body_imu: tuple[float, float, float] = (0.0, 0.0, 0.0)  # rad: roll, pitch, yaw
    lever_arm: tuple[float, float, float] = (0.0, 0.0, 0.0)  # m; its place in body
    gyro_noise_density: float = 2.3e-4  # rad/s/sqrt(Hz)
    accel_noise_density: float = 8.3e-4  # m/s^2/sqrt(Hz)
    gyro_bias_walk: float = 1.0e-5  # rad/s^2/sqrt(Hz)
    accel_bias_walk: float = 1.0e-4  # m/s^3/sqrt(Hz)
    gyro_bias_sigma: float = 2.0e-3  # rad/s
    accel_bias_sigma: float = 0.03  # m/s^2
    gravity: float = 9.80665  # m/s^2
    # Bias instability: besides walking, the biases come and go by this much in `_INSTABILITY_TIME`.
    gyro_instability: float = 0.0  # rad/s
    accel_instability: float = 0.0  # m/s^2
    # Vibration of the moving robot, standard deviation per m/s of speed.
    accel_vibration: float = 0.0  # m/s^2 / (m/s)
    gyro_vibration: float = 0.0  # rad/s / (m/s)
    # Vibration that the sampling folds into every band, densities per m/s of speed, with a slow
    # part of the same power: as recordings of outdoor robots show it.
    accel_rumble: float = 0.0  # m/s^2/sqrt(Hz) / (m/s)
    gyro_rumble: float = 0.0  # rad/s/sqrt(Hz) / (m/s)
    # An engine's, standard deviations, also at a standstill.
    accel_idle: float = 0.0  # m/s^2
    gyro_idle: float = 0.0  # rad/s
    tilt: float = 0.0  # rad, RMS, of the ground: roll and pitch


# MTi-30. The published calibration's 2.28e-3 rad/s and 8.27e-3 m/s^2 are of single samples at 200
# Hz; its "random walks" are bias instabilities.
MTI30 = ImuSpec(
    gyro_noise_density=1.61e-4,
    accel_noise_density=5.85e-4,
    gyro_bias_walk=0.0,
    accel_bias_walk=0.0,
    gyro_instability=5.0e-5,
    accel_instability=1.33e-4,
)


@dataclass(frozen=True)
class ImuData:
    """The IMU's samples in its own frame, and the biases in them: each (n, 3)."""

    acceleration: Floats  # m/s^2, specific force
    angular_velocity: Floats  # rad/s
    accel_bias: Floats
    gyro_bias: Floats
    orientation: Floats  # (n, 4) w x y z: the yaw that the gyro integrates to, drift included


def measure(
    motion: Motion, spec: ImuSpec, random: Random, wheel_speed: Floats | None = None
) -> ImuData:
    """IMU samples of `motion`, whose times are 1 / `spec.rate` apart.

    `wheel_speed` (n,), m/s: of wheels that turn although the robot stands; they shake it as well.
    """
    shaking = np.abs(motion.v)
    if wheel_speed is not None:
        shaking = np.maximum(shaking, np.abs(wheel_speed))
    n, step = len(motion.s), 1.0 / spec.rate
    body_imu = rotation_from_rpy(spec.rpy_body_imu)
    force, rate = _body_motion(motion, spec, random)
    if any(spec.lever_arm):
        force = force + added_by_turning(rate, step, np.array(spec.lever_arm))
    force, rate = force @ body_imu, rate @ body_imu

    def bias(sigma: float, walk: float) -> Floats:
        steps = random.standard_normal((n, 3)) * (walk * np.sqrt(step))
        steps[0] = random.standard_normal(3) * sigma
        return np.asarray(np.cumsum(steps, axis=0))

    def white(density: float) -> Floats:
        return np.asarray(random.standard_normal((n, 3)) * (density / np.sqrt(step)))

    gyro_bias = bias(spec.gyro_bias_sigma, spec.gyro_bias_walk)
    accel_bias = bias(spec.accel_bias_sigma, spec.accel_bias_walk)
    measured_rate = rate + white(spec.gyro_noise_density)
    measured_force = force + white(spec.accel_noise_density)
    if spec.gyro_instability or spec.accel_instability:
        gyro_bias = gyro_bias + spec.gyro_instability * _wandering(n, step, random)
        accel_bias = accel_bias + spec.accel_instability * _wandering(n, step, random)
    speed = shaking[:, None]
    for gyro, accel, strength, draw in (
        (spec.gyro_vibration, spec.accel_vibration, speed, _rattle),
        (spec.gyro_rumble, spec.accel_rumble, speed / np.sqrt(step), _rumble),
        (spec.gyro_idle, spec.accel_idle, 1.0, _engine),
    ):
        if gyro or accel:
            measured_rate = measured_rate + gyro * strength * draw(n, step, random)
            measured_force = measured_force + accel * strength * draw(n, step, random)
    measured_rate, measured_force = measured_rate + gyro_bias, measured_force + accel_bias
    turn = np.concatenate([[0.0], np.cumsum((measured_rate @ body_imu.T)[:-1, 2])]) * step
    return ImuData(
        acceleration=measured_force,
        angular_velocity=measured_rate,
        accel_bias=accel_bias,
        gyro_bias=gyro_bias,
        orientation=_orientation(float(motion.yaw[0]) + turn, spec.rpy_body_imu),
    )


def _body_motion(motion: Motion, spec: ImuSpec, random: Random) -> tuple[Floats, Floats]:
    """Specific force (m/s^2) and angular rate (rad/s) in body (n, 3), as the ground tilts."""
    n = len(motion.s)
    if not spec.tilt:
        force = np.column_stack([motion.acceleration, np.full(n, spec.gravity)])
        return force, np.column_stack([np.zeros((n, 2)), motion.yaw_rate])
    terrain, speed = draw_terrain(spec.tilt, random), np.abs(motion.v)
    roll, pitch = terrain.tilt(motion.travelled).T
    roll_rate, pitch_rate = (terrain.rate(motion.travelled) * speed[:, None]).T
    # Along its pitched x axis the robot climbs with -v sin(pitch).
    climb = np.gradient(-motion.v * np.sin(pitch)) * spec.rate
    cr, sr, cp, sp = np.cos(roll), np.sin(roll), np.cos(pitch), np.sin(pitch)
    x, y = motion.acceleration.T
    z = spec.gravity + climb
    force = np.column_stack(
        [cp * x - sp * z, sr * sp * x + cr * y + sr * cp * z, cr * sp * x - sr * y + cr * cp * z]
    )
    yaw_rate = motion.yaw_rate
    rate = np.column_stack(
        [
            roll_rate - yaw_rate * sp,
            pitch_rate * cr + yaw_rate * cp * sr,
            yaw_rate * cp * cr - pitch_rate * sr,
        ]
    )
    return force, rate


def _rumble(n: int, step: float, random: Random) -> Floats:
    """(n, 3), unit variance: half of the power white, half of slow changes."""
    from scipy.signal import lfilter

    kept = float(np.exp(-step / _RUMBLE_TIME))
    shocks = random.standard_normal((n, 3)) * np.sqrt(1 - kept**2)
    slow = lfilter([1.0], [1.0, -kept], shocks, axis=0) * np.sqrt(step / _RUMBLE_TIME)
    return np.asarray(np.sqrt(0.5) * (random.standard_normal((n, 3)) + slow))


def _engine(n: int, step: float, random: Random) -> Floats:
    """(n, 3), unit variance: an engine's shaking, whose frequency wanders, as sampled."""
    wander = np.cumsum(random.standard_normal((n, 3)) * (_ENGINE_WANDER * np.sqrt(step)), axis=0)
    angle = 2 * np.pi * np.cumsum((_ENGINE + wander) * step, axis=0)
    start = random.uniform(0, 2 * np.pi, 3)
    return np.asarray(np.sqrt(2.0) * np.sin(angle + start))


def _wandering(n: int, step: float, random: Random) -> Floats:
    """(n, 3), unit variance, forgets over `_INSTABILITY_TIME`."""
    return gauss_markov((n, 3), float(np.exp(-step / _INSTABILITY_TIME)), random)


def _rattle(n: int, step: float, random: Random) -> Floats:
    """(n, 3), unit variance: half of the power white, half at a frame's resonance."""
    from scipy.signal import iirpeak, lfilter

    numerator, denominator = iirpeak(_RESONANCE, _RESONANCE / _RESONANCE_WIDTH, 1 / step)
    ringing = lfilter(numerator, denominator, random.standard_normal((n, 3)), axis=0)
    white = random.standard_normal((n, 3))
    # The peak filter passes this share of the white noise's power.
    share = np.pi * _RESONANCE_WIDTH * step / (1 + np.pi * _RESONANCE_WIDTH * step)
    return np.asarray(np.sqrt(0.5) * (white + ringing / np.sqrt(share)))


def _orientation(yaw: Floats, rpy: tuple[float, float, float]) -> Floats:
    """Quaternions (n, 4) of Rz(yaw) R_body_imu."""
    (cr, cp, cy), (sr, sp, sy) = np.cos(np.divide(rpy, 2)), np.sin(np.divide(rpy, 2))
    w, x = cr * cp * cy + sr * sp * sy, sr * cp * cy - cr * sp * sy
    y, z = cr * sp * cy + sr * cp * sy, cr * cp * sy - sr * sp * cy
    cos, sin = np.cos(yaw / 2), np.sin(yaw / 2)
    return np.stack(
        [cos * w - sin * z, cos * x - sin * y, cos * y + sin * x, cos * z + sin * w], axis=1
    )


# rad/m, by the lengths (m) of the ground's waves; shorter ones the wheelbase evens out.
_WAVES = 2 * np.pi / np.array([0.9, 1.7, 3.1, 5.9])


@dataclass(frozen=True)
class Terrain:
    """Ground that tilts the robot as it drives over it: waves of equal share and random phase over
    the distance travelled, which give `rms` (rad) of roll and of pitch."""

    rms: float
    phases: Floats  # (2, waves)

    def tilt(self, travelled: Floats) -> Floats:
        """Roll and pitch (n, 2), rad."""
        return np.asarray(self._share * np.sin(self._angles(travelled)).sum(axis=2))

    def rate(self, travelled: Floats) -> Floats:
        """Derivative of `tilt` (n, 2), rad/m."""
        return np.asarray(self._share * (_WAVES * np.cos(self._angles(travelled))).sum(axis=2))

    @property
    def _share(self) -> float:
        return float(self.rms * np.sqrt(2 / len(_WAVES)))

    def _angles(self, travelled: Floats) -> Floats:
        return np.asarray(travelled[:, None, None] * _WAVES + self.phases)


def draw_terrain(rms: float, random: Random) -> Terrain:
    """Ground of that tilt."""
    return Terrain(rms, random.uniform(0, 2 * np.pi, (2, len(_WAVES))))
