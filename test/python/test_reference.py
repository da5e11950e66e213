"""docs/reference.md: made from the code, and as the code has it."""

import re
from pathlib import Path

import make_reference
import pytest

from conftest import CHECKOUT

CODE = r"""
constexpr char kGap[] = "gap: messages "
                        "lost";
void add(const std::string& name, const WorkTime& time, Status& status) {
  add(name + ".mean_ms", time.mean(), status);
}
void f() {
  health_.value("map.located", 1.0);
  health_.add("states", 1);
  add("solver", timing.solver, status);
  add("queue.longest", static_cast<double>(n), status);
  health_.count(channel.name, kGap);
  if (bad) health_.count("radar", "tick not "
                                  "answered");
  health_.set(topic, HealthLevel::kFailed, silent ? "no data" : "");
}
"""


def test_values_events_and_reasons_are_found_in_the_code() -> None:
    known = make_reference.constants(CODE)
    assert known == {"kGap": "gap: messages lost"}
    values = {"map.located", "states", "solver.*", "queue.longest"}
    assert make_reference.values_in(CODE, known) == values
    assert make_reference.suffixes(CODE) == {"WorkTime": [".mean_ms"]}
    assert make_reference.events_in(CODE, known) == {"gap: messages lost", "tick not answered"}
    assert make_reference.reasons_in(CODE, known) == [("failed", "no data")]


def test_a_value_without_a_meaning_and_a_meaning_without_a_value_are_faults() -> None:
    faults: list[str] = []
    make_reference.values_table(CODE, {}, {"states": "made", "gone": "no longer told"}, faults)
    assert "gone: the code has no such value" in faults
    assert "map.located: no meaning in reference_meanings.toml" in faults
    assert not any(fault.startswith("states") for fault in faults)


# Settings of version 0.1 that are constants now: their fixed values are those of the code.


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
