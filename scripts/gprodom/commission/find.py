"""All constants of a robot, each found with those before it put right."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import yaml

from gprodom import rotation
from gprodom.calibrate.imu import at_rest, measure_noise
from gprodom.calibrate.mount import find_mount
from gprodom.calibrate.offset import REACH_S, Offset
from gprodom.calibrate.radar_timing import find_radar_offset
from gprodom.calibrate.timing import find_offset
from gprodom.commission import imu_arm, radar, wheel
from gprodom.commission.parameter import CIRCLES, STAND, STARTS, STRAIGHT, Parameter, listed
from gprodom.commission.sensors import copied, rescale, shift
from gprodom.config import mounting_angles
from gprodom.doctor.examine import examine
from gprodom.doctor.finding import Finding, Log
from gprodom.doctor.motion import TURNED
from gprodom.doctor.stamps import LATE_S
from gprodom.drive.imu_mounting import ImuMounting, matrix_of
from gprodom.errors import Error
from gprodom.lcm.antennas import choose
from gprodom.trajectory import Trajectory

JITTER_S = 0.1  # of stamps and of their way to the estimator: half a state's interval
LONGEST_WINDOW_S = 1.0  # of time.reorder_window
CLEARLY = 2.0  # standard deviations off what is configured
ARM_ROUNDS = 3  # each some ten times nearer than the one before


@dataclass(frozen=True)
class Commission:
    """parameters: of the robot. findings: of the doctor, with these put right: what a configuration
    does not mend. sensors: the log with clocks and scale put right."""

    parameters: tuple[Parameter, ...]
    findings: tuple[Finding, ...]
    sensors: Log

    @property
    def settings(self) -> list[str]:
        """KEY=VALUE, a later one overriding earlier ones."""
        return [setting for each in self.parameters for setting in each.settings]


def commission(
    log: Log,
    configured: dict[str, Any],
    stretch_m: float | None = None,
    truth: Trajectory | None = None,
) -> Commission:
    """Of a log read by roles. configured: the whole configuration. stretch_m: a straight way that
    was measured. truth: positions for the wheel's scale."""
    log = copied(log)
    if "gpr_trace" in log:
        log["gpr_trace"] = choose(log["gpr_trace"], None, configured["gpr"]["antennas"])
    for role in log:
        section = "imu" if role == "imu" else "wheel"
        before = float(configured[section]["time_offset"])
        shift(log, role, _trace_offset(log, configured) if role == "gpr_trace" else before)
    found = [_imu_offset(log, float(configured["imu"]["time_offset"]))]
    found += _scale(log, float(configured["wheel"]["scale"]), stretch_m, truth)
    mount, arm = _place(log, configured)
    found += [mount, arm]
    found.append(wheel.track(log, str(configured["wheel"]["drive"])))
    found += _noise(log)
    found += _radar(log, configured)
    found += _reorder_window(found, configured)
    rpy = mount.value or mounting_angles(configured["imu"]["rpy_body_imu"])
    edges = configured["gpr"]["filter"]
    limits = (float(edges["band_low"]), float(edges["band_high"]))
    findings = examine(log, ImuMounting(rpy), limits)
    written = {setting.partition("=")[0] for each in found for setting in each.settings}
    if "gpr.filter.band_low" in written:
        findings = [each for each in findings if each.code != "sample interval"]
    return Commission(tuple(found), tuple(findings), log)


def _offset(name: str, key: str, offset: Offset, before: float) -> Parameter:
    value, sigma = before + offset.offset_s, offset.sigma_s
    remark = f"against the wheel; {100 * offset.explained:.0f} % explained"
    if abs(offset.offset_s) > REACH_S - LATE_S:
        return Parameter(
            name, remark=f"more than {REACH_S - LATE_S:g} s, or not shown", manoeuvre=STARTS
        )
    if not offset.significant and sigma > LATE_S:
        remark += "; too uncertain to be used"
        return Parameter(name, "s", (value,), (sigma,), (), remark, STARTS)
    if not offset.significant:
        remark += "; not different from what is configured"
        return Parameter(name, "s", (value,), (sigma,), (), remark)
    return Parameter(name, "s", (value,), (sigma,), (f"{key}={value:.4f}",), remark)


def _imu_offset(log: Log, before: float) -> Parameter:
    name = "time offset of the IMU"
    try:
        offset = find_offset(log)
    except Error as error:
        return Parameter(name, remark=str(error), manoeuvre=STARTS)
    found = _offset(name, "imu.time_offset", offset, before)
    if found.settings:
        shift(log, "imu", offset.offset_s)
    return found


def _own_offsets(configured: dict[str, Any]) -> dict[int, float]:
    """By antenna_id, s, of antennas that do not have that of all."""
    return {int(key): float(value) for key, value in configured["gpr"]["time_offsets"].items()}


def _trace_offset(log: Log, configured: dict[str, Any]) -> float:
    """As configured, s, of the antenna whose traces the log has."""
    antenna = int(log["gpr_trace"]["antenna_id"][0])
    return _own_offsets(configured).get(antenna, float(configured["gpr"]["time_offset"]))


def _reorder_window(found: Sequence[Parameter], configured: dict[str, Any]) -> list[Parameter]:
    """A message whose corrected stamp is older than others' by more than the window is dropped."""
    offsets = {key: float(configured[key]["time_offset"]) for key in ("imu", "wheel", "gpr")}
    offsets |= {f"gpr {key}": float(own) for key, own in _own_offsets(configured).items()}
    for each in found:
        for setting in each.settings:
            key, _, value = setting.partition("=")
            section, _, leaf = key.partition(".")
            if leaf == "time_offset":
                offsets[section] = float(value)
            if leaf == "time_offsets":
                offsets |= {f"gpr {each}": own for each, own in yaml.safe_load(value).items()}
    needed = max(offsets.values()) - min(offsets.values()) + JITTER_S
    if needed <= float(configured["time"]["reorder_window"]):
        return []
    window = min(needed, LONGEST_WINDOW_S)
    remark = "the estimator waits so long for the sensor whose stamps are oldest"
    if needed > LONGEST_WINDOW_S:
        remark += f", and no longer than {LONGEST_WINDOW_S:g} s: improve the drivers' stamps"
    setting = f"time.reorder_window={window:.2f}"
    return [Parameter("time to wait for late stamps", "s", (window,), (), (setting,), remark)]


def _scale(
    log: Log, configured: float, stretch_m: float | None, truth: Trajectory | None
) -> list[Parameter]:
    """Divides the log's distances by the last scale that is found. configured: wheel.scale."""
    rescale(log, configured)
    coarse = wheel.scale_by_accelerations(log)
    if coarse.value:
        coarse = replace(coarse, value=(coarse.value[0] * configured,))
    found, before = [coarse], configured
    if coarse.settings:
        before = coarse.value[0]
        sigma = f"wheel.scale_sigma={coarse.sigma[0] * configured:.2g}"
        found = [replace(coarse, settings=(f"wheel.scale={before:.4g}", sigma))]
        rescale(log, before / configured)
    fine = None
    if stretch_m is not None:
        fine = wheel.scale_by_stretch(log, stretch_m, before)
    elif truth is not None:
        fine = wheel.scale_by_truth(log, truth, before)
    if fine is None:
        remark = "accelerations show it to some per cent only, and a loop closes at any scale"
        return [*found, Parameter("wheel scale", remark=remark, manoeuvre=f"{STRAIGHT}: --stretch")]
    if fine.value:
        rescale(log, fine.value[0] / before)
    return [*found, fine]


def _place(log: Log, configured: dict[str, Any]) -> tuple[Parameter, Parameter]:
    """How and where the IMU is mounted. The log's accelerations are put to the origin. What turns
    add to them looks like another yaw, and a wrong yaw turns the arm: both are found in turns."""
    rpy = mounting_angles(configured["imu"]["rpy_body_imu"])
    arm = tuple(map(float, configured["imu"]["lever_arm"]))
    wheel_arm = tuple(map(float, configured["wheel"]["lever_arm"]))
    at_imu, mount = log["imu"], _mount(log, rpy)
    if not mount.value:
        log["imu"] = ImuMounting(rpy, arm).at_origin(log["imu"])
        remark = "the mounting is not known"
        return mount, Parameter(imu_arm.NAME, remark=remark, manoeuvre=mount.manoeuvre)
    for _ in range(ARM_ROUNDS):
        log["imu"] = at_imu
        found = imu_arm.lever_arm(log, mount.value, arm, wheel_arm)
        place = (*found.value, arm[2]) if found.settings else arm
        log["imu"] = ImuMounting(mount.value, place).at_origin(at_imu)
        mount = _mount(log, rpy)
        if not mount.value:
            break
    return mount, found


def _mount(log: Log, configured: Sequence[float]) -> Parameter:
    """configured: imu.rpy_body_imu."""
    name = "mounting of the IMU"
    try:
        mount = find_mount(log)
    except Error as error:
        return Parameter(name, remark=str(error), manoeuvre=f"{STARTS}; {CIRCLES}")
    sigma = mount.sigma
    remark = (
        f"roll, pitch, yaw; {100 * mount.explained:.0f} % of the accelerations explained. The mean "
        "slope of the ground goes into roll and pitch"
    )
    turned_by = matrix_of(mount.rpy) @ matrix_of(tuple(configured)).T
    off = rotation.to_vector(rotation.from_matrix(turned_by))
    near = np.linalg.norm(off) < TURNED and abs(off[2]) < CLEARLY * sigma[2]
    if near and np.linalg.norm(off[:2]) < CLEARLY * max(sigma[:2]):
        remark += "; not different from what is configured"
        return Parameter(name, "rad", mount.rpy, sigma, (), remark)
    setting = f"imu.rpy_body_imu={listed(mount.rpy)}"
    return Parameter(name, "rad", mount.rpy, sigma, (setting,), remark)


def _noise(log: Log) -> list[Parameter]:
    try:
        acceleration, gyro, rate = at_rest(log)
        noise = {"gyro": measure_noise(gyro, rate), "accel": measure_noise(acceleration, rate)}
    except Error as error:
        return [Parameter("noise of the IMU", remark=str(error), manoeuvre=STAND)]
    units = {"gyro": "rad/s/√Hz", "accel": "m/s²/√Hz"}
    found = []
    for name, each in noise.items():
        settings = [f"imu.{name}_noise_density={each.density:.4g}"]
        remark = "walk of the bias: too short to tell, hours are needed"
        if each.walk_is_known:
            settings.append(f"imu.{name}_bias_walk={each.walk:.4g}")
            remark = f"walk of the bias {each.walk:.2g} ± {100 * each.walk_sigma:.0f} %"
        found.append(
            Parameter(
                f"noise of the {'gyro' if name == 'gyro' else 'accelerometer'}",
                units[name],
                (each.density,),
                (each.density * each.density_sigma,),
                tuple(settings),
                remark,
            )
        )
    return found


def _for_its_antenna(found: Parameter, log: Log, configured: dict[str, Any]) -> Parameter:
    """The offset found, written where the configuration has that antenna's."""
    antenna, own = int(log["gpr_trace"]["antenna_id"][0]), _own_offsets(configured)
    if antenna not in own:
        return found
    own[antenna] = round(found.value[0], 4)
    return replace(found, settings=(f"gpr.time_offsets={own}",))


def _radar(log: Log, configured: dict[str, Any]) -> list[Parameter]:
    if "gpr_trace" not in log or len(log["gpr_trace"]["utime"]) < 100:
        return [radar.no_radar()]
    name = "time offset of the radar"
    try:
        offset = find_radar_offset(log)
        time = _offset(name, "gpr.time_offset", offset, _trace_offset(log, configured))
        if time.settings:
            shift(log, "gpr_trace", offset.offset_s)
            time = _for_its_antenna(time, log, configured)
    except Error as error:
        time = Parameter(name, remark=str(error), manoeuvre=STARTS)
    try:
        traces = radar.usable_traces(log)
    except Error as error:
        return [time, Parameter("band of the radar", remark=str(error))]
    interval = float(np.median(log["gpr_trace"]["sample_interval"]))
    edges = configured["gpr"]["filter"]
    band = radar.band(traces, interval, (float(edges["band_low"]), float(edges["band_high"])))
    wave_speed = float(configured["gpr"]["wave_speed"])
    arm = tuple(float(each) for each in configured["gpr"]["lever_arm"])
    rate = radar.trace_rate(log, band.value[0], wave_speed)
    return [time, band, radar.gain(traces), rate, radar.lever_arm(log, arm, rate.value[0])]
