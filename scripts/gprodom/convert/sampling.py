"""The time between a sequence's radar samples, which its CSV files do not contain.

A simulated sequence has it in a small file (`RADAR_FACTS`). Older ones have it in the JSON file
beside them, which also has the truth; nothing else is read from that file.
"""

import argparse
import json
import math
import re
from pathlib import Path
from typing import Any

from gprodom.console import warn
from gprodom.convert.source import File
from gprodom.errors import Error
from gprodom.files import also_read
from gprodom.options import Parser

SAMPLE_INTERVAL = 2e-10  # s; 5 GHz, the dataset's Noggin 500
# s; antennas of 25 MHz are sampled every 5 ns, of 3 GHz every 20 ps
SHORTEST, LONGEST = 1e-12, 1e-8
_KEY = "sample_interval_s"
_KEY_BESIDE = "gpr_sample_interval"
_TOLD_BESIDE = re.compile(rb'"gpr_sample_interval"\s*:(?!\s*null)')


def radar_facts(sample_interval: float) -> bytes:
    """What `RADAR_FACTS` holds."""
    return (json.dumps({_KEY: sample_interval}) + "\n").encode()


def find_sample_interval(sequence: Path, facts: File | None) -> float:
    """Seconds: from `facts`, otherwise from the file beside the sequence (with a notice), otherwise
    0.2 ns."""
    if facts is not None:
        return _interval(facts.data, _KEY, facts.label)
    beside = sequence.with_name(sequence.name.removesuffix(".zip") + ".json")
    also_read(beside)
    data = beside.read_bytes() if beside.is_file() else b""
    if _TOLD_BESIDE.search(data) is None:
        return SAMPLE_INTERVAL
    interval = _interval(data, _KEY_BESIDE, str(beside))
    if interval != SAMPLE_INTERVAL:
        warn(f"{sequence}: radar sample interval {interval:g} s taken from {beside.name}")
    return interval


def _interval(data: bytes, key: str, label: str) -> float:
    try:
        content: Any = json.loads(data)
        interval = float(content[key])
    except (ValueError, TypeError, KeyError, RecursionError):
        interval = math.nan
    wrong = fault_of_interval(interval)
    if wrong:
        raise Error(f"{label}: {key}: {wrong}")
    return interval


def fault_of_interval(seconds: float) -> str:
    """What is wrong with a time between radar samples (s); empty where nothing is."""
    if SHORTEST <= seconds <= LONGEST:
        return ""
    hint = ""
    for unit, factor in (("nanoseconds", 1e-9), ("picoseconds", 1e-12)):
        if SHORTEST * 10 <= seconds * factor <= LONGEST:
            hint = f"; is it in {unit}? Then write {seconds * factor:.6g}"
            break
    return (
        f"expected seconds between radar samples, {SHORTEST:g} to {LONGEST:g}, such as 2e-10, got "
        f"{seconds:g}{hint}"
    )


def sample_interval(text: str) -> float:
    """Seconds, as the `type` of an option."""
    try:
        seconds = float(text)
    except ValueError:
        seconds = math.nan
    wrong = fault_of_interval(seconds)
    if wrong:
        raise argparse.ArgumentTypeError(wrong)
    return seconds


def add_sample_interval_option(
    parser: Parser,
    what: str = "seconds between radar samples of a sequence (default: as it says, else 2e-10)",
) -> None:
    """``--sample-interval``."""
    parser.option("--sample-interval S", sample_interval, what)
