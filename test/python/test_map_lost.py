"""A located track that drives too far without a revisit: STATUS says that it is lost."""

from pathlib import Path

import numpy as np
import pytest

import gprodom
from gprodom.simulate.drives import drive_on_known_ground
from gprodom.simulate.recording import as_recording
from known_drives import drive

pytestmark = pytest.mark.usefixtures("compiled")


def test_lost_without_known_ground_and_found_again(tmp_path: Path) -> None:
    run = drive_on_known_ground(0)
    path = str(tmp_path / "ground.map")
    first = gprodom.Odometry()
    drive(first, run)
    first.save_map(path)

    # Sensors that are said to be poor, and no radar in the middle of the drive.
    estimator = gprodom.Odometry(set=["wheel.noise=0.8", "imu.accel_noise_density=0.1"])
    estimator.load_map(path)
    told = as_recording(run).messages()
    time = told["gpr_time"]
    begin, end = (int(np.quantile(time, share)) for share in (0.5, 0.75))
    kept = (time < begin) | (time > end)
    told["gpr_time"], told["traces"] = time[kept], told["traces"][kept]
    outputs = estimator.run(**told)

    status = [
        (one["time"] / 1e9, one["values"].get("map.located"), "; ".join(one["reasons"]))
        for one in outputs.status
    ]
    before = [one for one in status if one[0] < begin / 1e9]
    between = [one for one in status if begin / 1e9 <= one[0] < end / 1e9]
    assert before[-1][1] == 1.0
    assert not any("lost: no known" in said for *_, said in before)
    # Not at once, and from then on until there is ground again.
    assert between[0][1] == 1.0 and between[-1][1] == 0.0
    for _, located, said in between:
        assert ("lost: no known ground" in said) == (located == 0.0)
    assert status[-1][1] == 1.0 and "lost" not in status[-1][2]
