"""Recordings of real robots: starts, and covariances that lose nothing without a measurement."""

from pathlib import Path

import numpy as np
import pytest
from recordings import RECORDINGS, convert

from conftest import run_cli
from gprodom.lcm import logs

STANDING = 1


@pytest.mark.parametrize(
    ("name", "mounting"), [("husky", "[1.5708, 0, -1.5708]"), ("warthog_a", "[0, 0, 0]")]
)
def test_knowledge_comes_from_measurements_alone(
    name: str, mounting: str, shared: Path, tmp_path: Path
) -> None:
    """The heading's deviation once fell by a factor of thirty in one message of a driving Husky."""
    log, out = tmp_path / "in.lcmlog", tmp_path / "out.lcmlog"
    convert(RECORDINGS[name], shared / "robots", log)
    setting = f"imu.rpy_body_imu={mounting}"
    run_cli("run", log, "--method", "imu_wheel", "--set", setting, "-o", out)
    found = logs.read(out, ["ODOMETRY", "STATUS"])
    odometry = found["ODOMETRY"]
    begun = min(int(channel["utime"][0]) for channel in logs.read(log, ["IMU", "WHEEL"]).values())
    assert odometry["utime"][0] - begun < 10_000_000  # starts within 10 s
    counted = {name for status in found["STATUS"]["messages"] for name in status.names}
    assert not [name for name in counted if "no measurement" in name]
    reasons = {reason for status in found["STATUS"]["messages"] for reason in status.reasons}
    assert not [reason for reason in reasons if reason.startswith("IMU mounting")]

    yaw_sigma = np.sqrt(odometry["pose_covariance"].reshape(-1, 6, 6)[:, 5, 5])
    driving = (odometry["flags"][1:] & STANDING) == 0
    assert np.all((yaw_sigma[1:] / yaw_sigma[:-1])[driving] > 0.8)

    # Accelerations of these show too little of the wheel's scale: it stays as it was given.
    assert odometry["wheel_scale"][-1] == pytest.approx(1.0, abs=1e-4)
    assert odometry["wheel_scale_sigma"][-1] == pytest.approx(0.02, rel=0.01)


@pytest.mark.parametrize("every", [1, 2, 6])  # 120, 60 and 20 Hz
def test_a_car_stands_with_its_engine_running(every: int, shared: Path, tmp_path: Path) -> None:
    """The engine's vibration, aliased, once passed for driving: no standstill showed the bias."""
    data, log, out = shared / "robots" / "wid02", tmp_path / "in.lcmlog", tmp_path / "out.lcmlog"
    files = [f"--wheel-speed={data / 'wheel.csv'}"]
    for sensor in ("accelerometer", "gyroscope"):
        header, *rows = (data / f"{sensor}.csv").read_text().splitlines()
        thinned = tmp_path / f"{sensor}.csv"
        thinned.write_text("\n".join([header, *rows[::every], ""]))
        files.append(f"--{sensor}={thinned}")
    run_cli("convert", "tables", *files, "-o", log)
    mounting = "imu.rpy_body_imu=[-0.1, 0.01, -1.47]"
    run_cli("run", log, "--method", "imu_wheel", "--set", mounting, "-o", out)
    odometry = logs.read(out, ["ODOMETRY"])["ODOMETRY"]
    begun = int(logs.read(log, ["IMU"])["IMU"]["utime"][0])
    seconds = (odometry["utime"] - begun) * 1e-6
    assert seconds[0] < 3
    at_first = (seconds > 3) & (seconds < 12)  # it sets off at 13 s
    assert np.mean((odometry["flags"][at_first] & STANDING) != 0) > 0.95
    driving = (seconds > 20) & (seconds < 120)
    assert not np.any(odometry["flags"][driving] & STANDING)
