"""Sequences with more than one antenna."""

from __future__ import annotations

from pathlib import Path

import pytest

from gprodom.convert.cmu import read_recording
from gprodom.lcm.logs import read
from test_convert import convert, pack, stamp, tables, write


@pytest.mark.parametrize("packed", [False, True])
def test_traces_of_further_antennas(packed: bool, tmp_path: Path) -> None:
    files = tables()
    header, *rows = files["gpr_meas.csv"]
    files["gpr_meas_1.csv"] = [
        header,
        *(f"{stamp(50_000 * i + 4000)}{',7' * 12}" for i in range(3)),
    ]
    sequence = write(tmp_path / "two", files)
    if packed:
        sequence = pack(tmp_path / "two.zip", sequence, "two/")
    gpr = read(convert(sequence))["GPR_TRACE"]
    assert gpr["antenna_id"].tolist() == [0, 1, 0, 1, 0, 1, 0]
    assert gpr["seq"].tolist() == [0, 0, 1, 1, 2, 2, 3]
    assert gpr["samples"][1].tolist() == [7] * 12
    assert len(rows) == 4
    assert read_recording(sequence).out_of_order["gpr 1"] == 0
