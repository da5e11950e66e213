"""The robot that `gprodom simulate` drives: sensors like those of CMU-GPR, faults included."""

from __future__ import annotations

from dataclasses import replace

from gprodom.simulate.drive import DriveSpec
from gprodom.simulate.ground import GroundSpec
from gprodom.simulate.imu import MTI30
from gprodom.simulate.radar import RadarSpec
from gprodom.simulate.sequence import Spec, StationSpec, SurveySpec
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
    antenna: Point = (0.0, 0.0),
    contact: Point = (0.0, 0.0),
    prism: Point = (0.0, 0.0),
) -> Spec:
    """What to simulate. `antenna`, `contact` (of the wheel) and `prism`: m, in body."""
    return Spec(
        replace(drive, wander=WANDER),
        imu=IMU,
        wheel=replace(WHEEL, lever_arm=contact),
        radar=replace(RADAR, lever_arm=antenna),
        ground=ground,
        station=StationSpec(prism=prism),
        slips=slips,
        kind=kind,
    )
