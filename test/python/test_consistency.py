"""The estimator's covariance over 40 simulated drives; bench/consistency.py runs more.

The wheels of these drives never slip for long, and the configuration says so: otherwise the
variance for slip would be far larger than their error.
"""

from concurrent.futures import ProcessPoolExecutor
from functools import partial

import pytest

from gprodom.benchmark.monte_carlo import end_of_drive, judge


@pytest.mark.usefixtures("compiled")
def test_covariance_is_true() -> None:
    with ProcessPoolExecutor(2) as pool:
        ends = list(pool.map(partial(end_of_drive, overrides=["wheel.slip_share=0"]), range(40)))
    for nees, freedom in (([end.nees_xy for end in ends], 2), ([end.nees_yaw for end in ends], 1)):
        judged = judge(nees, freedom)
        assert judged["inside"], {**judged, "errors": [end.error for end in ends]}
