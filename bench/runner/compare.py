"""What differs between the figures of two programs, or of two runs, beyond their noise."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from figures import Figure, Report
from gprodom.console import format_table

# Standard deviations of the difference that chance makes of one in 370 figures: a page of figures
# has as many that vary.
MOST_SIGMA = 3.0
# Of figures that are the same for the same program and data: beyond the digits of a sum whose terms
# another compiler orders differently.
SAME = 1e-6


@dataclass(frozen=True)
class Change:
    """A figure of two runs; before or now is None where the other alone has it."""

    name: str
    before: Figure | None
    now: Figure | None

    @property
    def unit(self) -> str:
        """Of the figure."""
        there = self.now or self.before
        return there.unit if there else ""

    @property
    def verdict(self) -> str:
        """better, worse, or what else has happened to it."""
        if self.before is None or self.now is None:
            return "new" if self.before is None else "gone"
        a, b = self.before.value, self.now.value
        if a is None or b is None:
            return "changed"
        if self.now.better == "near 2":
            a, b = abs(math.log(max(a, 1e-9) / 2)), abs(math.log(max(b, 1e-9) / 2))
        elif not self.now.better:
            return "changed"
        elif self.now.better == "higher":
            a, b = -a, -b
        return "better" if b < a else "worse"


def is_change(before: Figure, now: Figure) -> bool:
    """Whether it is more than noise."""
    if before.value is None or now.value is None:
        return before.value is not now.value
    difference = abs(now.value - before.value)
    spread = math.hypot(before.spread or 0.0, now.spread or 0.0)
    return difference > max(MOST_SIGMA * spread, SAME * max(abs(before.value), abs(now.value)))


def changes(before: Sequence[Report], now: Sequence[Report]) -> list[Change]:
    """Of all figures, in the order of now's; of benches that both have."""
    found: list[Change] = []
    old = {report.name: report.figures() for report in before}
    for report in now:
        found += _changes(report.name, old.get(report.name, {}), report.figures())
    return found


def _changes(bench: str, old: Mapping[str, Figure], new: Mapping[str, Figure]) -> list[Change]:
    found = []
    for name in [*new, *(name for name in old if name not in new)]:
        before, now = old.get(name), new.get(name)
        if before is None or now is None or is_change(before, now):
            found.append(Change(f"{bench}/{name}", before, now))
    return found


def table(found: Sequence[Change], compared: int) -> str:
    """For people."""
    if not found:
        return f"no difference in {compared} figures"
    lines = []
    for each in found:
        values = [figure.value if figure else None for figure in (each.before, each.now)]
        ratio = ""
        if values[0] and values[1] is not None:
            ratio = f"{values[1] / values[0]:.3f}"
        lines.append([each.name, *values, each.unit, ratio, each.verdict])
    verdicts = [each.verdict for each in found]
    counts = ", ".join(f"{verdicts.count(v)} {v}" for v in dict.fromkeys(verdicts))
    text = format_table(["figure", "before", "now", "", "ratio", ""], lines)
    return f"{text}\n{len(found)} of {compared} figures differ: {counts}"
