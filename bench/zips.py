"""Sequences in CMU-GPR format as benches take them: any zips, with what is told beside them."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

from gprodom.convert.sampling import SAMPLE_INTERVAL
from gprodom.errors import Error
from gprodom.odometry.estimate import as_log


def sequences_of(paths: Sequence[Path]) -> list[Path]:
    """The paths themselves, and in place of a folder that holds zips, those."""
    found: list[Path] = []
    for path in paths:
        found += sorted(path.glob("*.zip")) or [path]
    return found


def sample_interval(sequence: Path) -> float:
    """Of the radar, s: of the .json beside it, or of the beach's."""
    facts = sequence.with_suffix(".json")
    known = json.loads(facts.read_text(encoding="utf-8")) if facts.exists() else {}
    if "gpr_sample_interval" in known:
        return float(known["gpr_sample_interval"])
    return 3.125e-10 if "beach" in sequence.name else SAMPLE_INTERVAL


def log_of(source: Path, folder: Path) -> Path:
    """A log itself; of a sequence the log made in `folder`, of the sequence's name."""
    if not source.exists():
        raise Error(f"{source}: no such log or sequence")
    if source.suffix == ".lcmlog":
        return source
    made = folder / source.stem
    made.mkdir(exist_ok=True)
    return as_log(source, made, sample_interval(source)).rename(folder / f"{source.stem}.lcmlog")
