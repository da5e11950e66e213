"""``gprodom calibrate antennas`` on a simulated drive with two antennas in a row."""

from dataclasses import replace
from pathlib import Path

import pytest

from conftest import Cli
from gprodom.calibrate.antennas import Drive, distance_of, find_distance
from gprodom.config import read_antennas
from gprodom.errors import Error
from gprodom.lcm.log_writer import write_log
from gprodom.random_streams import stream
from gprodom.simulate.antennas import draw_antennas
from gprodom.simulate.drive import Bend, DriveSpec, Move, Stop, Track
from gprodom.simulate.recording import log_streams
from gprodom.simulate.robot import RADAR
from gprodom.simulate.sequence import Simulated, Spec, simulate

TRUE_M, WAY_M = 0.3, 12.0


def drive_of_two(way_m: float = WAY_M) -> Simulated:
    """12 m straight on, with antennas that are truly 0.3 m apart."""
    drawn = draw_antennas(
        [(TRUE_M / 2, 0.0), (-TRUE_M / 2, 0.0)], RADAR, stream(1, "antennas in a test")
    )
    antennas = tuple(replace(a, radar=replace(a.radar, lever_arm=a.told)) for a in drawn)
    track = DriveSpec(Track((Bend(1000.0),)), (Stop(4.0), Move(way_m, 0.4), Stop(2.0)))
    return simulate(Spec(track, radar=antennas[0].radar, antennas=antennas), 1)


def test_a_wrong_distance_is_found(tmp_path: Path, cli: Cli) -> None:
    """Told 2 cm too much, the distance is found within what the command says of itself."""
    log, output = tmp_path / "in.lcmlog", tmp_path / "antennas.yaml"
    write_log(log, log_streams(drive_of_two()))
    told = "gpr.antennas={0: [0.16, 0, 0], 1: [-0.16, 0.01, 0]}"
    words = ["calibrate", "antennas", log, "--distance", WAY_M, "--set", told]
    found = cli.json(*words, "-o", output)
    assert found["configured_m"] == pytest.approx(0.32)
    assert found["sigma_m"] < 0.003
    assert abs(found["distance_m"] - TRUE_M) < 3 * found["sigma_m"]
    places = read_antennas([output])
    assert distance_of(places) == pytest.approx(found["distance_m"], abs=2e-5)
    assert places[1][1] == 0.01
    assert places[0][0] == pytest.approx(-places[1][0]), "about their middle"


def test_the_known_distance_is_no_surer_with_more_drives() -> None:
    """But the passages' part is, and a spread beyond it counts."""
    drive = Drive(estimated_m=10.0, passages=25, sigma_m=0.02)
    one = find_distance([drive], 0.3, 10.1, 0.0)
    assert one.distance_m == pytest.approx(0.303)
    assert one.sigma_m == pytest.approx(0.3 * 0.002)
    assert find_distance([drive] * 4, 0.3, 10.1, 0.0).sigma_m == pytest.approx(0.3 * 0.001)
    assert find_distance([drive] * 400, 0.3, 10.0, 0.1).sigma_m > 0.3 * 0.01
    apart = [Drive(9.0, 25, 0.02), Drive(11.0, 25, 0.02)]
    assert find_distance(apart, 0.3, 10.0, 0.0).sigma_m > 0.3 * 0.05


def test_antennas_that_are_not_in_a_row_are_refused() -> None:
    """One, or two side by side."""
    for places in ({}, {0: (0.1, 0.0, 0.0)}, {0: (0.1, 0.2, 0.0), 1: (0.1, -0.2, 0.0)}):
        with pytest.raises(Error, match="in a row"):
            distance_of(places)
