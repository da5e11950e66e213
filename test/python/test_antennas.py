"""Traces of several antennas in what reads a log: each antenna by itself, at its own place."""

from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest
import yaml

import gprodom
from conftest import Cli, Silent, rows_of
from gprodom import describe_config, rotation
from gprodom.config import STANDARD
from gprodom.convert.cmu import Traces
from gprodom.convert.streams import gpr_stream
from gprodom.convert.streams import streams as streams_of
from gprodom.errors import Error
from gprodom.lcm.answers import answers_to
from gprodom.lcm.antennas import apart, choose, counts
from gprodom.lcm.log_writer import write_log
from gprodom.lcm.logs import read
from gprodom.simulate import make_route, simulate, stream
from gprodom.simulate.ground import GroundSpec
from gprodom.simulate.recording import as_recording
from gprodom.simulate.robot import robot
from test_calibrate import drive_of_two
from test_export import INTERVAL, START, export, orientation, position
from test_export import log as log

PLACES = ("--set", "gpr.antennas={0: [0.2, 0.1, 0], 1: [-0.3, 0, 0.05]}")
LATER = 25_000  # us, of antenna 1


@pytest.fixture
def radar(tmp_path: Path) -> Path:
    """Traces of antenna 1 of 16 samples, of antenna 0 25 ms earlier, and a few of antenna 7, of
    another length."""
    time = START + 50_000 * np.arange(40)
    first, second = np.random.default_rng(2).integers(-30000, 30000, (2, 40, 16))
    of_antennas = (
        (0, time, first, INTERVAL),
        (1, time + LATER, second, INTERVAL),
        (7, time[:3] + 1, np.ones((3, 9)), 2 * INTERVAL),
    )
    streams = [gpr_stream("GPR_TRACE", *sent, 0.0, antenna_id=id_) for id_, *sent in of_antennas]
    write_log(tmp_path / "radar.lcmlog", streams)
    return tmp_path / "radar.lcmlog"


def test_traces_apart(radar: Path) -> None:
    traces = read(radar)["GPR_TRACE"]
    assert counts(traces) == {0: 40, 7: 3, 1: 40}
    found = apart(traces)
    assert list(found) == [0, 7, 1]
    assert found[7]["samples"].shape == (3, 9)
    assert found[1]["samples"].shape == (40, 16)
    np.testing.assert_array_equal(found[1]["utime"] - found[0]["utime"], LATER)
    assert set(choose(traces, None)["antenna_id"]) == {0}
    assert set(choose(traces, None, {1: (0, 0, 0), 7: (0, 0, 0)})["antenna_id"]) == {7}
    assert set(choose(traces, 1)["antenna_id"]) == {1}
    assert choose(found[7], None) is found[7]
    with pytest.raises(Error, match=r"no traces of antenna 5; there are those of 0 \(40 traces\)"):
        choose(traces, 5)


def places_of(rows: list[dict[str, str]]) -> np.ndarray:
    return np.array([[float(row[axis]) for axis in "xyz"] for row in rows])


def test_each_trace_at_its_antenna(log: Path, radar: Path, cli: Cli) -> None:
    """The path is straight and the robot turns on it, so that an antenna's way is a screw."""
    made = log.with_name("traces")
    said = cli("export", log, "--traces", made, "--radar", radar, *PLACES).out
    assert "80 traces, 0 traces without pose, 3 traces of other antennas" in said
    rows = rows_of(made)
    for antenna, place in ((0, [0.2, 0.1, 0]), (1, [-0.3, 0, 0.05])):
        mine = [row for row in rows if int(row["antenna_id"]) == antenna]
        seconds = 0.05 * np.arange(40) + antenna * LATER * 1e-6
        turned = rotation.to_matrix(orientation(seconds)) @ place
        np.testing.assert_allclose(places_of(mine), position(seconds) + turned, atol=2e-5)


def test_without_places_the_first_one_heard(log: Path, radar: Path) -> None:
    """At gpr.lever_arm, as the estimator has it."""
    arm = ("--set", "gpr.lever_arm=[0.5, 0, 0]")
    rows = rows_of(export(log, "traces", "--radar", radar, *arm))
    assert [row["antenna_id"] for row in rows] == ["0"] * 40
    seconds = 0.05 * np.arange(40)
    expected = position(seconds) + rotation.to_matrix(orientation(seconds)) @ [0.5, 0, 0]
    np.testing.assert_allclose(places_of(rows), expected, atol=2e-5)
    bare = rows_of(export(log, "traces", "--radar", radar))
    np.testing.assert_allclose(places_of(bare), position(seconds), atol=1e-9)


def test_one_antenna_of_several(log: Path, radar: Path, cli: Cli) -> None:
    chosen = ("--radar", radar, *PLACES, "--antenna")
    assert {row["antenna_id"] for row in rows_of(export(log, "traces", *chosen, "1"))} == {"1"}
    out = log.parent / "t"
    for antenna, said in (("7", "place of none of the antennas heard"), ("5", "no traces of")):
        assert said in cli.error("export", log, "--traces", out, *chosen, antenna)


def test_antennas_in_segy(log: Path, radar: Path, cli: Cli) -> None:
    segyio = pytest.importorskip("segyio")
    made = export(log, "segy", "--radar", radar, *PLACES)
    with segyio.open(str(made), ignore_geometry=True) as file:
        assert file.attributes(segyio.TraceField.TraceNumber)[:].tolist() == [0, 1] * 40
        traces = read(radar)["GPR_TRACE"]
        np.testing.assert_array_equal(file.trace.raw[:][1::2], apart(traces)[1]["samples"])
    other = ("--set", "gpr.antennas={0: [0, 0, 0], 7: [0, 0, 0]}")
    command = ["export", log, "--radar", radar, "--segy", log.parent / "s", *other]
    assert "choose with --antenna" in cli.error(*command)
    cli(*command, "--antenna", "7")


def test_a_picture_of_each_antenna(log: Path, radar: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    highlevel = pytest.importorskip("rosbags.highlevel")
    monkeypatch.setattr("gprodom.export.messages.SCAN_TRACES", 20)
    with highlevel.AnyReader([export(log, "mcap", "--radar", radar)]) as reader:
        pictures = [c.topic for c, _, _ in reader.messages() if "bscan" in c.topic]
    assert pictures == ["/gprodom/bscan", "/gprodom/bscan_1"]


def distances(found: list[gprodom.Outputs]) -> list[tuple[int, int, float]]:
    """What the pair of antennas measured: from, to (ns), m."""
    return [
        (each["from"], each["to"], each["distance"])
        for outputs in found
        for each in outputs.displacements
        if each["source"] == "pair"
    ]


def test_two_antennas_in_process() -> None:
    """At once and one by one the same distances, which one antenna alone does not have."""
    recording = as_recording(drive_of_two(3.0))
    told = recording.messages()
    assert set(told["gpr_antenna"]) == {0, 1}
    assert np.all(np.diff(told["gpr_time"]) >= 0)
    settings = ["graph.enabled=false", "gpr.antennas={0: [0.15, 0, 0], 1: [-0.15, 0, 0]}"]
    settings.append("wheel.enabled=false")
    at_once = distances([gprodom.Odometry(set=settings).run(**told)])
    assert len(at_once) > 3
    one = gprodom.Odometry(set=settings)
    messages = [
        (time, 0, partial(one.add_imu, time, force, rate))
        for time, force, rate in zip(
            told["imu_time"].tolist(), told["acceleration"], told["angular_velocity"], strict=True
        )
    ]
    messages += [
        (time, 1, partial(one.add_gpr, time, trace, told["sample_interval"], antenna_id=antenna))
        for time, trace, antenna in zip(
            told["gpr_time"].tolist(), told["traces"], told["gpr_antenna"].tolist(), strict=True
        )
    ]
    found = []
    for _, _, add in sorted(messages, key=lambda message: message[:2]):
        add()
        found.append(one.step())
    assert distances([*found, one.finish()]) == at_once
    alone = replace(recording, more_antennas={}).messages()
    assert "gpr_antenna" not in alone
    assert not distances([gprodom.Odometry(set=settings).run(**alone)])
    with pytest.raises(ValueError, match="gpr_antenna"):
        gprodom.Odometry().run(**told | {"gpr_antenna": told["gpr_antenna"][1:]})


@pytest.fixture(scope="module")
def pair(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A drive with stops; antenna 1 has the same traces, with stamps 60 ms late."""
    route = make_route("stops", 30.0, 0.6, 4.0, stream(5, "route"))
    alone = as_recording(simulate(robot(route, GroundSpec(), slips=2), 5))
    late = Traces(alone.gpr_utime + 60_000, alone.traces)
    path = tmp_path_factory.mktemp("pair") / "pair.lcmlog"
    both = replace(alone, more_antennas={1: late}, out_of_order={**alone.out_of_order, "gpr 1": 0})
    write_log(path, streams_of(both, 2e-10))
    return path


@pytest.mark.parametrize(
    ("options", "antenna"),
    [
        (("--antenna", "0"), 0),
        (("--antenna", "1"), 1),
        (("--set", "gpr.antennas={1: [0, 0, 0]}"), 1),
    ],
    ids=["asked for", "the other", "placed"],
)
def test_time_offset_of_an_antenna(
    options: tuple[str, ...], antenna: int, pair: Path, cli: Cli
) -> None:
    found = cli.json("calibrate", "time", pair, *options)["gpr"]
    assert found["offset_s"] == pytest.approx(-0.06 * antenna, abs=0.02)
    said = cli("calibrate", "time", pair, *options).out
    assert f"by antenna {antenna}" in said
    yaml.safe_load(said)


def test_time_offset_of_each_antenna(pair: Path, tmp_path: Path, cli: Cli) -> None:
    out = tmp_path / "time.yaml"
    found = cli.json("calibrate", "time", pair, "-o", out)
    assert set(found["antennas"]) == {"0", "1"}
    assert found["gpr"] == found["antennas"]["0"], "the first one heard"
    for antenna in (0, 1):
        offset = found["antennas"][str(antenna)]["offset_s"]
        assert offset == pytest.approx(-0.06 * antenna, abs=0.02)
    gpr = yaml.safe_load(out.read_text())["gpr"]
    assert "time_offset" not in gpr
    written = yaml.safe_load(describe_config([f"gpr.time_offsets={gpr['time_offsets']}"]))
    late = found["antennas"]["1"]["offset_s"]
    assert written["gpr"]["time_offsets"][1] == pytest.approx(late, abs=1e-4)


def test_a_teller_hears_one_antenna(radar: Path) -> None:
    """The first: motion is told by neighbouring traces of one."""
    first = apart(read(radar)["GPR_TRACE"])[0]["utime"]
    heard = Silent()
    assert answers_to(radar, heard, STANDARD, None) == []
    assert heard.traces == [(utime, 16) for utime in first.tolist()]
