#!/usr/bin/env python3
"""Holds the rooms of src/ apart: which folder may include which, and how many sources each holds.

Data run one way (docs/architecture.md). Each public header belongs to one room as well, so that
an include of it counts like one of that room. Prints each include that runs against the order and
each folder with too many sources; exit code 1 where there is one. scripts/check_rooms.py holds the
length of sources and the Python package.
"""

import re
import subprocess
import sys
from collections import Counter
from pathlib import Path

CHECKOUT = Path(__file__).resolve().parent.parent
MOST_SOURCES = 20  # .cpp files in a folder

# Folder of src/: the folders whose headers its files may include, besides its own.
GPR = ["gpr/kernels", "gpr/filter", "gpr/peaks", "gpr/sequential", "gpr/motion", "gpr/revisit"]
BEFORE_MOTION = ["base", "config", "gpr", *GPR, "estimation", "estimation/graph"]
ROOMS = {
    "base": [],
    "config": ["base"],
    "gpr/kernels": ["base", "config"],
    "gpr/filter": ["base", "config", "gpr/kernels"],
    "gpr/peaks": ["base", "config", *GPR[:2]],
    "gpr/sequential": ["base", "config", *GPR[:3]],
    "gpr/motion": ["base", "config", *GPR[:3]],
    "gpr/revisit": ["base", "config", *GPR[:3]],
    "gpr": ["base", "config", *GPR],
    "estimation": ["base", "config"],
    "estimation/graph": ["base", "config", "estimation"],
    "input": BEFORE_MOTION,
    "motion": BEFORE_MOTION,
    "map": BEFORE_MOTION,
    "persist": [*BEFORE_MOTION, "motion", "map"],
    "pipeline": [*BEFORE_MOTION, "input", "motion", "map", "persist"],
    "live": ["base", "config", "pipeline"],
    "io": ["base", "config", "input"],
    "io/ros1": ["base", "config", "input", "io"],
    "apps": ["base", "config", "pipeline", "live", "io"],
    "apps/ros1": ["base", "config", "pipeline", "live", "io", "io/ros1", "apps"],
    "python": ["base", "config", "gpr", *GPR, "estimation", "pipeline"],
}

# include/gprodom/NAME.h: the room that it is the public face of.
PUBLIC = {
    "base": "duration_histogram error execution front_end input outputs types version",
    "config": "config",
    "pipeline": "odometry",
    "io": "lcm_io",
}
ROOM_OF_PUBLIC = {name: room for room, names in PUBLIC.items() for name in names.split()}

# Libraries that only some rooms may know, and what only a room with threads may include.
ONLY_IN = {
    r"ceres/": ["estimation", "estimation/graph"],
    r"(lcm|lcmtypes|bot_core)/": ["io"],
    r"yaml-cpp/": ["config"],
    r"spdlog/": ["apps"],
    r"(ros|tf2_ros|sensor_msgs|nav_msgs|diagnostic_msgs|gprodom_ros)/": ["io/ros1", "apps/ros1"],
    r"(thread|mutex|condition_variable|future)$": ["base", "live", "apps", "apps/ros1"],
}


def room_of(header: str) -> str | None:
    """The room of an included file; None for one of a library."""
    if header.startswith("gprodom/"):
        name = header.removeprefix("gprodom/").removesuffix(".h")
        return ROOM_OF_PUBLIC.get(name, f"unknown public header {header}")
    folder = header.rpartition("/")[0]
    return folder if folder in ROOMS else None


def faults_of(path: Path) -> list[str]:
    """What one source includes that its room may not."""
    relative = path.relative_to(CHECKOUT)
    if relative.parts[0] == "include":
        room = ROOM_OF_PUBLIC.get(path.stem, "")
        if not room:
            return [f"{relative}: a public header that no room of scripts/check_includes.py owns"]
    else:
        room = "/".join(relative.parts[1:-1])
        if room not in ROOMS:
            return [f"{relative}: the folder has no entry in scripts/check_includes.py"]
    faults = []
    for number, line in enumerate(path.read_text().splitlines(), 1):
        include = re.match(r'#include [<"]([^>"]+)[>"]', line)
        if not include:
            continue
        header = include[1]
        place = f"{relative}:{number}: {header}"
        other = room_of(header)
        if other is not None and other != room and other not in ROOMS[room]:
            faults.append(f"{place}: {room} must not include {other}")
        # The factors know the geometry of the plane, and the graph knows no more of them.
        if room == "estimation/graph" and other == "estimation" and "planar_geometry" not in header:
            faults.append(f"{place}: of estimation the graph may include planar_geometry.h alone")
        for pattern, rooms in ONLY_IN.items():
            if re.match(pattern, header) and room not in rooms:
                faults.append(f"{place}: only in {', '.join(rooms)}")
    return faults


def main() -> int:
    """Every source under src/ and include/, as git knows them."""
    listed = ["git", "ls-files", "--cached", "--others", "--exclude-standard", "src", "include"]
    names = subprocess.run(listed, cwd=CHECKOUT, check=True, capture_output=True, text=True).stdout
    sources = [CHECKOUT / name for name in names.split() if name.endswith((".cpp", ".h"))]
    sources = [source for source in sources if source.exists()]
    faults = [fault for source in sources for fault in faults_of(source)]
    counts = Counter(source.parent for source in sources if source.suffix == ".cpp")
    faults += [
        f"{folder.relative_to(CHECKOUT)}: {count} sources, at most {MOST_SOURCES}"
        for folder, count in counts.items()
        if count > MOST_SOURCES
    ]
    print("\n".join(faults) or f"{len(sources)} sources in {len(counts)} folders: in order")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
