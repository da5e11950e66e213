"""What processes cost: processor time and memory."""

from __future__ import annotations

import os
import resource
from pathlib import Path

from gprodom.errors import Error


def processor_seconds(pid: int) -> float:
    """User and system time of a process so far."""
    fields = Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def children_seconds() -> float:
    """User and system time of the children that have ended so far."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def memory_mb(pid: int, what: str) -> float:
    """Of a process, MB (10^6 bytes). what: VmRSS, resident; VmHWM, its peak."""
    for line in Path(f"/proc/{pid}/status").read_text().splitlines():
        if line.startswith(f"{what}:"):
            return int(line.split()[1]) * 1024e-6
    raise Error(f"process {pid} has ended")
