"""Scores of logs whose published path is in two frames: located in an earlier map, or reset."""

import json
from pathlib import Path

import numpy as np
import pytest

from conftest import Cli
from packets import correction, packet, pose, status, write_events

START = 1_700_000_000_000_000
LOCATED_AT, RESET_AT = 8.0, 8.0  # s
JUMP_AT, JUMP_M = 14.0, 0.2


def place(seconds: float) -> tuple[float, float]:
    """Where the robot is: once round a circle of 8 m, at 0.5 m/s."""
    angle = 0.5 * seconds / 8
    return 8 * np.sin(angle), 8 * (1 - np.cos(angle))


def write(path: Path, located: bool, reset: bool = False) -> Path:
    """A drive that begins 20 m from the origin of an earlier map, in which it is located after 8 s,
    and which a later correction moves by 0.2 m; or that is reset after 8 s."""
    events = []
    for i in range(2001):
        seconds, utime = 0.02 * i, START + 20_000 * i
        x, y = place(seconds)
        since = RESET_AT if reset and seconds >= RESET_AT else 0.0
        shift = (0.0, 0.0)
        if located and seconds >= LOCATED_AT:
            shift = (20.0, -7.0 + (JUMP_M if seconds >= JUMP_AT else 0.0))
        if located and i in (round(50 * LOCATED_AT), round(50 * JUMP_AT)):
            events.append((utime, "CORRECTION", correction(utime, *shift)))
        begin = place(since)
        odom = (x - begin[0], y - begin[1])
        distance = 0.5 * (seconds - since)
        in_map = (odom[0] + shift[0], odom[1] + shift[1])
        events.append((utime, "ODOMETRY", pose(utime, *odom, 1e-4, distance=distance)))
        events.append((utime, "ODOMETRY_MAP", pose(utime, *in_map, 1e-4, distance=distance)))
        if i % 50 == 0 and located:
            known = seconds > LOCATED_AT
            said = {"map.located": float(known)} | ({"map.sigma_m": 0.1} if known else {})
            events.append((utime, "STATUS", status(utime, said)))
        if i % 5 == 0:
            # The truth is right with the map as it is from the first moment to the later jump.
            truth = packet("position_truth_t", utime=utime, position=[3.0 - y, 2.0 + x, 1.0])
            events.append((utime, "TOTAL_STATION", truth))
    return write_events(path, events)


def score(log: Path, cli: Cli, *options: str) -> tuple[dict[str, float], str]:
    said = cli("score", log, log, "--json", *options)
    figures: dict[str, float] = json.loads(said.out)
    return figures, said.err


def test_a_drive_located_in_an_earlier_map_is_scored_from_there_on(
    tmp_path: Path, cli: Cli
) -> None:
    figures, said = score(write(tmp_path / "out.lcmlog", located=True), cli)
    assert figures["ate_rmse_m"] < JUMP_M  # of two frames that lie 21 m apart
    assert figures["before_m"] == pytest.approx(0.5 * LOCATED_AT, abs=0.02)
    assert (figures["map_jumps"], figures["map_jump_max_m"]) == (1, pytest.approx(JUMP_M))
    assert figures["excluded_m"] == pytest.approx(0.5 * LOCATED_AT, abs=0.2)
    assert "located in an earlier map 8.0 s after the first pose, 4.0 m driven" in said


def test_without_the_map_all_of_it_is_scored(tmp_path: Path, cli: Cli) -> None:
    log = write(tmp_path / "out.lcmlog", located=True)
    figures, said = score(log, cli, "--frame", "odom")
    assert figures["ate_rmse_m"] == pytest.approx(0, abs=1e-6)
    assert (figures["before_m"], figures["excluded"], said) == (None, 0, "")


@pytest.mark.parametrize("frame", ["map", "odom"])
def test_a_drive_that_was_reset_is_scored_from_there_on(
    frame: str, tmp_path: Path, cli: Cli
) -> None:
    log = write(tmp_path / "out.lcmlog", located=False, reset=True)
    figures, said = score(log, cli, "--frame", frame)
    assert figures["ate_rmse_m"] == pytest.approx(0, abs=1e-6)
    assert figures["before_m"] == pytest.approx(0.5 * RESET_AT, abs=0.02)
    assert "reset 8.0 s after the first pose" in said


def test_a_drive_in_one_frame_is_scored_whole(tmp_path: Path, cli: Cli) -> None:
    figures, said = score(write(tmp_path / "out.lcmlog", located=False), cli)
    assert (figures["before_m"], figures["excluded"], said) == (None, 0, "")
