"""Files of several channels: each an antenna of its own."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from dzt_file import dzt_file
from gprodom.cli import main
from gprodom.convert.survey_files import read_channels, read_line
from gprodom.errors import Error
from gprodom.ground.survey import read_survey


def three_channels(path: Path) -> np.ndarray:
    """A file of three; the last header is empty. Their traces (3, 6, 32), without the marks."""
    traces = np.random.default_rng(1).integers(-3000, 3000, (3, 6, 32))
    path.write_bytes(dzt_file(traces, (64.0, 32.0, 0.0)))
    traces[:, :, :2] = traces[:, :, 2:3]
    return traces


def test_channels_of_a_dzt(tmp_path: Path) -> None:
    traces = three_channels(tmp_path / "a.dzt")
    lines = read_channels(tmp_path / "a.dzt")
    np.testing.assert_array_equal([line.traces for line in lines], traces)
    assert [line.sample_interval for line in lines] == pytest.approx([2e-9, 1e-9, 1e-9])
    np.testing.assert_array_equal(read_line(tmp_path / "a.dzt").traces, traces[0])


def test_headers_of_channels_that_cannot_lie_in_turn(tmp_path: Path) -> None:
    (tmp_path / "a.dzt").write_bytes(dzt_file(np.zeros((2, 5, 32)), (50.0, 50.0), (32, 64)))
    with pytest.raises(Error, match="channel 1 has 64 samples of 16 bits a trace, channel 0 32"):
        read_channels(tmp_path / "a.dzt")


def test_survey_of_chosen_channels(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Each a line, in the order given; without the option the first, as before, which is told."""
    traces, ground = three_channels(tmp_path / "a.dzt"), tmp_path / "g.npz"
    command = ["convert", "survey", str(tmp_path / "a.dzt"), "-o", str(ground), "--json"]
    assert main([*command, "--channels", "2,1", "--aside", "0.08"]) == 0
    assert json.loads(capsys.readouterr().out)["lines"] == 2
    survey = read_survey(ground)
    np.testing.assert_array_equal(survey.lines, traces[[2, 1]])
    np.testing.assert_allclose(survey.aside, [0, 0.08])
    assert main(command) == 0
    assert "holds 3 channels; 0 is taken" in capsys.readouterr().err
    np.testing.assert_array_equal(read_survey(ground).lines, traces[:1])
    assert main([*command, "--channels", "0,1"]) == 1
    assert "lines of different sampling" in capsys.readouterr().err
    assert main([*command, "--channels", "3"]) == 1
    assert "holds 3 channels, 0 to 2; --channels asks for 3" in capsys.readouterr().err
    for wrong in ("0,0", "-1", "a"):
        with pytest.raises(SystemExit):
            main([*command, f"--channels={wrong}"])
