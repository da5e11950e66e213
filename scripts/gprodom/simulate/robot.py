"""The robots that `gprodom simulate` drives: sensors like those of recordings, faults included."""

import math
from dataclasses import dataclass, field, replace
from typing import Any

from gprodom.simulate.drive import DriveSpec
from gprodom.simulate.ground import GroundSpec
from gprodom.simulate.imu import MTI30, ImuSpec
from gprodom.simulate.pair import PairSpec
from gprodom.simulate.radar import RadarSpec
from gprodom.simulate.sequence import Spec, StationSpec, SurveySpec
from gprodom.simulate.surface import SURFACES
from gprodom.simulate.wheel import WheelSpec

Point = tuple[float, float]
WANDER = 0.015  # m

# The encoder of CMU-GPR's C.0 steps by 0.182 mm and is read 29.4 times a second. Vibration: as a
# skid-steered outdoor robot's, a tenth of it on its axis of turn.
IMU = replace(MTI30, accel_vibration=0.25, gyro_vibration=0.012)
WHEEL = WheelSpec(rate=29.4, quantum=1.82e-4)
RADAR = RadarSpec(noise=12.0, gain_drift=0.03, time_zero_drift=5e-11, ringing=1500.0, spikes=0.002)


def robot(
    drive: DriveSpec,
    ground: GroundSpec | SurveySpec | None,
    kind: str = "",
    slips: int = 0,
    lasting: str = "",
    antenna: Point = (0.0, 0.0),
    contact: Point = (0.0, 0.0),
    prism: Point = (0.0, 0.0),
) -> Spec:
    """What to simulate. `antenna`, `contact` (of the wheel) and `prism`: m, in body."""
    return Spec(
        replace(drive, wander=WANDER),
        imu=IMU,
        wheel=replace(WHEEL, lever_arm=contact, lasting=lasting),
        radar=replace(RADAR, lever_arm=antenna),
        ground=ground,
        station=StationSpec(prism=prism),
        slips=slips,
        kind=kind,
    )


@dataclass(frozen=True)
class Kind:
    """A kind of robot with two sides of wheels, on gravel: rougher and smoother ground scale its
    rumble and tilt."""

    drive: str  # wheel.drive of the configuration
    speed: float  # m/s
    imu: ImuSpec
    pair: PairSpec
    motion: dict[str, Any] = field(default_factory=dict)  # of its DriveSpec

    @property
    def settings(self) -> list[str]:
        """The settings of the estimator for it."""
        return [f"wheel.drive={self.drive}", f"wheel.track={self.pair.track}"]


def _imu(rate: float, accel: float, gyro: float, tilt_deg: float) -> ImuSpec:
    return replace(
        MTI30, rate=rate, accel_rumble=accel, gyro_rumble=gyro, tilt=math.radians(tilt_deg)
    )


# Rumble and tilt of cart and rover: as driven in the field at 1 m/s; a Husky on snow shows up to
# 0.25 m/s^2/sqrt(Hz). The skid steer is a Warthog: 20 Hz rows that hold values of 4 Hz, told 0.17 s
# late. The car's engine shakes 0.4 m/s^2 and 1.5 degrees/s at a standstill.
KINDS: dict[str, Kind] = {
    "cart": Kind("differential", 0.6, _imu(100, 0.03, 6e-4, 0.3), PairSpec(0.5, rate=29.4)),
    "rover": Kind(
        "differential",
        0.8,
        _imu(100, 0.12, 3e-3, 1.1),
        PairSpec(0.7, rate=29.4),
        {"centre_wander": 0.02},
    ),
    "skid_steer": Kind(
        "skid_steer",
        1.2,
        _imu(20, 0.12, 3e-3, 1.1),
        PairSpec(1.08, rate=20, skids=True, held=0.25, late=0.17, quantum=1e-4),
        {"centre_offset": -0.1, "centre_wander": 0.08},
    ),
    "car": Kind(
        "ackermann",
        8.0,
        replace(_imu(120, 0.012, 3e-4, 1.0), accel_idle=0.4, gyro_idle=0.026),
        PairSpec(1.5, rate=83, quantum=2e-3),
        {"acceleration": 1.5, "cornering_stiffness": 15.0},
    ),
}


def of_kind(name: str, surface: str, spec: Spec) -> Spec:
    """`spec` driven by a robot of `KINDS` on a surface of `SURFACES`."""
    kind, rough = KINDS[name], SURFACES[surface].roughness
    roughened = ("accel_rumble", "gyro_rumble", "tilt")
    shaken = {name: rough * getattr(kind.imu, name) for name in roughened}
    return replace(
        spec,
        drive=replace(spec.drive, **kind.motion),
        imu=replace(kind.imu, **shaken),
        pair=replace(kind.pair, surface=surface, side_slips=spec.slips, lasting=spec.wheel.lasting),
        slips=0,
    )
