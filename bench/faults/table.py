"""The bench's results as a table, with a list of the violations."""

from __future__ import annotations

import math
from typing import Any

import kinds
import numpy as np
import outcome

Results = dict[tuple[str, str], dict[str, Any]]
DRAW = " #"  # between a fault's name and the number of a further draw


def _faults(results: Results) -> list[str]:
    names = [name for _, name in results if name != "clean"]
    return list(dict.fromkeys(name.split(DRAW)[0] for name in names))


def _told(fault: str) -> bool:
    """Whether STATUS can know of the fault; of a combination, whether of any part."""
    parts = fault.split(" + ")
    return any(known.told for known in kinds.all_faults() if known.name in parts)


def _of(fault: str, results: Results) -> list[tuple[str, dict[str, Any]]]:
    """Log and result of each draw of a fault."""
    return [(log, r) for (log, name), r in results.items() if name.split(DRAW)[0] == fault]


def of_replays(results: Results) -> tuple[str, list[str]]:
    """The table in Markdown, and a line for each thing that is wrong."""
    wrong: list[str] = []
    lines = [
        "| fault | error / clean | longest silence (s) | well again after (s) | STATUS said |",
        "|---|---|---|---|---|",
    ]
    for fault in _faults(results):
        lines.append(_row(fault, _of(fault, results), results, wrong))
    return "\n".join(lines) + "\n", wrong


def figures(results: Results) -> list[dict[str, Any]]:
    """A row for each fault: error over that of the clean run, mean over the logs and the worst;
    the longest silence, and what of it is wrong."""
    rows = []
    for fault in _faults(results):
        of_fault = _of(fault, results)
        wrong: list[str] = []
        _row(fault, of_fault, results, wrong)
        held = [(log, r) for log, r in of_fault if "ended" not in r]
        ratios = [r["error_m"] / results[log, "clean"]["error_m"] for log, r in held]
        known = [ratio for ratio in ratios if math.isfinite(ratio)]
        row = {"fault": fault, "wrong": len(wrong)}
        row |= {"silent_s": max((r["silent_s"] for _, r in held), default=0.0)}
        if known:
            row |= {"error_ratio": float(np.mean(known)), "worst_ratio": max(known)}
        rows.append(row)
    return rows


def _row(
    fault: str, of_fault: list[tuple[str, dict[str, Any]]], results: Results, wrong: list[str]
) -> str:
    ratios: dict[str, list[float]] = {}  # by log
    silent, recovered = 0.0, 0.0
    said: dict[str, None] = {}
    for log, result in of_fault:
        if "ended" in result:
            wrong.append(f"{log}: {fault}: {result['ended']}")
            continue
        clean = results[log, "clean"]
        for trait in ("finite", "monotone"):
            if not result[trait]:
                wrong.append(f"{log}: {fault}: not {trait}")
        news = outcome.news(result["said"], clean["said"])
        if not news and _told(fault):
            wrong.append(f"{log}: {fault}: STATUS is silent")
        said.update(dict.fromkeys(news))
        ratio = result["error_m"] / clean["error_m"]
        if math.isfinite(ratio):
            ratios.setdefault(log, []).append(ratio)
        silent, recovered = max(silent, result["silent_s"]), max(recovered, result["recovered_s"])
    known = [float(np.mean(each)) for each in ratios.values()]
    error = f"{np.mean(known):.2f}, worst {max(known):.2f}" if known else "no pose to compare"
    words = "; ".join(list(said)[:3]) + (f"; and {len(said) - 3} more" if len(said) > 3 else "")
    return f"| {fault} | {error} | {silent:.1f} | {recovered:.1f} | {words} |"
