"""Files of several channels, and tables of several antennas."""

from pathlib import Path

import numpy as np
import pytest

from conftest import Cli
from dzt_file import dzt_file
from gprodom.convert.survey_files import read_line, read_lines
from gprodom.errors import Error
from gprodom.ground.survey import read_survey
from gprodom.lcm.antennas import apart
from test_convert_tables import convert, drive, refused, table, three


def three_channels(path: Path) -> np.ndarray:
    """A file of three; the last header is empty. Their traces (3, 6, 32), without the marks."""
    traces = np.random.default_rng(1).integers(-3000, 3000, (3, 6, 32))
    path.write_bytes(dzt_file(traces, (64.0, 32.0, 0.0)))
    traces[:, :, :2] = traces[:, :, 2:3]
    return traces


def test_channels_of_a_dzt(tmp_path: Path) -> None:
    traces = three_channels(tmp_path / "a.dzt")
    lines = read_lines(tmp_path / "a.dzt")
    np.testing.assert_array_equal([line.traces for line in lines], traces)
    assert [line.sample_interval for line in lines] == pytest.approx([2e-9, 1e-9, 1e-9])
    np.testing.assert_array_equal(read_line(tmp_path / "a.dzt").traces, traces[0])


def test_headers_of_channels_that_cannot_lie_in_turn(tmp_path: Path) -> None:
    (tmp_path / "a.dzt").write_bytes(dzt_file(np.zeros((2, 5, 32)), (50.0, 50.0), (32, 64)))
    with pytest.raises(Error, match="channel 1 has 64 samples of 16 bits a trace, channel 0 32"):
        read_lines(tmp_path / "a.dzt")


def test_survey_of_chosen_channels(tmp_path: Path, cli: Cli) -> None:
    """Each a line, in the order given; without the option the first, as before, which is told."""
    traces, ground = three_channels(tmp_path / "a.dzt"), tmp_path / "g.npz"
    command = ["convert", "survey", tmp_path / "a.dzt", "-o", ground]
    assert cli.json(*command, "--channels", "2,1", "--aside", "0.08")["lines"] == 2
    survey = read_survey(ground)
    np.testing.assert_array_equal(survey.lines, traces[[2, 1]])
    np.testing.assert_allclose(survey.aside, [0, 0.08])
    assert "holds 3 channels; 0 is taken" in cli(*command).err
    np.testing.assert_array_equal(read_survey(ground).lines, traces[:1])
    assert "lines of different sampling" in cli.error(*command, "--channels", "0,1")
    said = cli.error(*command, "--channels", "3")
    assert "holds 3 channels, 0 to 2; --channels asks for 3" in said
    for wrong in ("0,0", "-1", "a"):
        cli(*command, f"--channels={wrong}", code=2)


def test_channels_become_antennas(tmp_path: Path, cli: Cli) -> None:
    """All, or those asked for, with the numbers they have in the file; those of the next file are
    counted on."""
    traces = three_channels(tmp_path / "a.dzt")
    times = table(tmp_path / "t.csv", "t", drive()["time"][:60:10])
    base = [*three(tmp_path), "--gpr-times", str(times), "--gpr", str(tmp_path / "a.dzt")]
    radar = convert(tmp_path, *base)["GPR_TRACE"]
    assert radar["antenna_id"].tolist() == [0, 1, 2] * 6
    assert radar["seq"].tolist() == [i // 3 for i in range(18)]
    for antenna, interval in enumerate((2e-9, 1e-9, 1e-9)):
        mine = apart(radar)[antenna]
        np.testing.assert_array_equal(mine["samples"], traces[antenna])
        assert mine["sample_interval"] == pytest.approx(interval)
    assert set(convert(tmp_path, *base, "--channels", "2")["GPR_TRACE"]["antenna_id"]) == {2}
    twice = apart(convert(tmp_path, *base, "--gpr", tmp_path / "a.dzt")["GPR_TRACE"])
    assert sorted(twice) == [0, 1, 2, 3, 4, 5]
    np.testing.assert_array_equal(twice[4]["samples"], traces[1])
    said = refused(tmp_path, cli, *three(tmp_path), "--gpr", times, "--channels", "0", code=2)
    assert "this is a table" in said


INTERVAL = ("--sample-interval", "2e-10")


def radar_tables(folder: Path) -> tuple[np.ndarray, list[str]]:
    """Traces (2, n, 12) of two antennas in a table each, and the options that name them."""
    made = drive()
    traces = np.stack([made["traces"], -made["traces"]])
    files = [
        table(folder / f"r{i}.csv", "", made["time"][::5], each) for i, each in enumerate(traces)
    ]
    return traces, [text for file in files for text in ("--gpr", str(file))]


def test_a_table_of_each_antenna(tmp_path: Path, cli: Cli) -> None:
    traces, options = radar_tables(tmp_path)
    command = ["convert", "tables", *three(tmp_path), *options, *INTERVAL]
    counted = cli.json(*command, "-o", tmp_path / "out.lcmlog")["channels"]
    assert counted["GPR_TRACE"]["count"] == counted["GPR_TRACE 1"]["count"] == len(traces[0])
    layout = tmp_path / "robot.yaml"
    layout.write_text("gpr: {file: [r0.csv, r1.csv]}\nsample_interval: 2.0e-10\n")
    for radar in (
        convert(tmp_path, *three(tmp_path), *options, *INTERVAL)["GPR_TRACE"],
        convert(tmp_path, *three(tmp_path), "--layout", str(layout))["GPR_TRACE"],
    ):
        found = apart(radar)
        np.testing.assert_array_equal([found[i]["samples"] for i in (0, 1)], traces)
    (tmp_path / "r1.csv").write_text((tmp_path / "r1.csv").read_text().replace("17000", "19000"))
    said = refused(tmp_path, cli, *three(tmp_path), *options, *INTERVAL)
    assert "IMU and radar 1 have 0.0 s in common" in said


@pytest.mark.parametrize("scale", [None, 0.01, 1000.0])
def test_a_column_of_antennas(scale: float | None, tmp_path: Path, cli: Cli) -> None:
    """Ids are not scaled as samples are."""
    traces, _ = radar_tables(tmp_path)
    time = drive()["time"][::5]
    told = np.repeat([3, 1], len(time))
    samples = np.concatenate(traces) / (scale or 1.0)
    header = "t,id," + ",".join(f"s{i}" for i in range(12))
    table(tmp_path / "r.csv", header, np.tile(time, 2), told, samples)
    options = ["--gpr", str(tmp_path / "r.csv"), "--gpr-antenna", "id", *INTERVAL]
    options += [] if scale is None else ["--gpr-scale", str(scale)]
    assert "Give --gpr-columns" in refused(tmp_path, cli, *three(tmp_path), *options, code=2)
    options += ["--gpr-columns", "t,3-14"]
    radar = convert(tmp_path, *three(tmp_path), *options)["GPR_TRACE"]
    for antenna, expected in zip((3, 1), traces, strict=True):
        mine = apart(radar)[antenna]
        np.testing.assert_array_equal(mine["samples"], expected)
        assert mine["seq"].tolist() == list(range(len(time)))
    said = refused(tmp_path, cli, *three(tmp_path), *options, "--gpr", tmp_path / "r.csv", code=2)
    assert "not of several" in said
    table(tmp_path / "r.csv", header, np.tile(time, 2), told + 0.5, samples)
    said = refused(tmp_path, cli, *three(tmp_path), *options, "--strict")
    assert "a whole number of 32 bits in column 2" in said
