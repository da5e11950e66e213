"""docs/reference.md: made from the code, and as the code has it."""

import make_reference

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
