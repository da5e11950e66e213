"""Flags and kinds have the numbers of the message types, and one name each in all commands."""

from __future__ import annotations

import numpy as np

from gprodom.lcm.constants import constants, flag, flag_bits, health, kind
from gprodom.lcm.messages import message
from gprodom.plot.log import flag_shares, log_figure
from gprodom.status.heard import flags

ALL = 0xFF


def test_every_flag_of_the_type_has_a_name() -> None:
    bits = set(flag_bits().values())
    assert bits == {1 << i for i in range(8)}
    assert set(constants("odometry_t").values()) <= bits
    assert flag("SLIPPING") == message("odometry_t").SLIPPING


def test_status_and_pictures_know_the_same_flags() -> None:
    sent = message("odometry_t")()
    sent.flags = ALL
    count = 5
    log = {
        "odometry": {
            "utime": np.arange(count) * 1_000_000,
            "velocity": np.zeros((count, 3)),
            "pose_covariance": np.zeros((count, 36)),
            "flags": np.full(count, ALL),
        }
    }
    names = flags(sent)
    assert len(names) == 8
    assert flag_shares(log) == dict.fromkeys(names, 1.0)
    rows = log_figure(log, "all").axes[2]
    assert [label.get_text() for label in rows.get_yticklabels()] == names
    assert len(rows.collections) == 8  # a bar for each


def test_kinds_and_health_are_those_of_the_types() -> None:
    assert [kind(name) for name in ("SEQUENTIAL", "MOTION", "REVISIT", "EXTERNAL")] == [0, 1, 2, 3]
    assert [health(value) for value in range(3)] == ["ok", "degraded", "failed"]
