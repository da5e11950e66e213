"""Settings of version 0.1 that are constants now: their fixed values are those of the code."""

import re
from pathlib import Path

import pytest

from conftest import CHECKOUT

SOURCES = CHECKOUT / "src"
ROWS = [
    line.split("\t")
    for line in Path(__file__).with_name("former_settings.tsv").read_text().splitlines()
    if not line.startswith("#")
]


def test_each_former_setting_has_its_constant() -> None:
    """What errors call the fixed value (src/config/former_keys.cpp), against the table."""
    code = (SOURCES / "config" / "former_keys.cpp").read_text().partition("MovedKey>")[0]
    fixed = dict(re.findall(r'\{"([\w.]+)",\s*"([^"]*)"', code))
    assert fixed == {key: value for key, value, *_ in ROWS}
    assert len(fixed) == 59


@pytest.mark.parametrize(("value", "constant", "path"), [row[1:] for row in ROWS], ids=str)
def test_the_constant_has_the_fixed_value(value: str, constant: str, path: str) -> None:
    code = (SOURCES / path).read_text()
    if constant == "-":  # the code has no such choice any more
        return
    name = re.findall(r"\w+", constant)[-1]
    found = re.search(rf"(\w+ )?\b{name} = ([\w.':+-]+)", code)
    assert found
    number = found[2].replace("'", "")
    if value[0].isdigit():
        unit = 1e-9 if found[1] == "TimeNs " else 1.0
        assert float(number) * unit == pytest.approx(float(value))
    else:
        assert number.lower().endswith(f"::k{value}")
