#!/usr/bin/env python3
"""Holds the rooms of src/ apart: which folder may include which, and how many sources each holds.

Data run one way (docs/architecture.md). Each public header belongs to one room as well, so that
an include of it counts like one of that room. Prints each include that runs against the order and
each folder with too many sources; exit code 1 where there is one. scripts/check_rooms.py holds the
length of sources and the Python package.
"""

import re
import sys
from collections import Counter
from pathlib import Path

from check_rooms import tracked_sources

CHECKOUT = Path(__file__).resolve().parent.parent
SOURCES = CHECKOUT / "src"
ARCHITECTURE = CHECKOUT / "docs" / "architecture.md"
MOST_SOURCES = 20  # .cpp files in a folder


LOW = ["base", "config"]
GPR = ["gpr/kernels", "gpr/filter", "gpr/peaks"]
GPR += ["gpr/sequential", "gpr/motion", "gpr/revisit", "gpr/pair"]
LOW_ESTIMATION = ["estimation/kernels", "estimation/increments"]
BEFORE_MOTION = [*LOW, "gpr", *GPR, *LOW_ESTIMATION, "estimation", "estimation/graph"]
MOTION = ["motion/slip", "motion/history", "motion/rest"]
MAP = ["map/path", "map/fixes", "map", "map/merge"]
# A folder of src/, in the order of the page: whose headers its files may include, besides its own;
# and what it knows nothing of.
ROOMS = {
    "base": [],  # settings, algorithms
    "config": ["base"],  # what a setting does
    "gpr/kernels": LOW,  # traces
    "gpr/filter": [*LOW, *GPR[:1]],  # peaks, windows, distances
    "gpr/peaks": [*LOW, *GPR[:2]],  # other traces
    "gpr/sequential": [*LOW, *GPR[:3]],  # the wheel, ground seen before
    "gpr/motion": [*LOW, *GPR[:3]],  # the wheel, metres
    "gpr/revisit": [*LOW, *GPR[:3]],  # poses, the map
    "gpr/pair": [*LOW, *GPR[:3]],  # the wheel, states
    "gpr": [*LOW, *GPR],  # states, factors
    "estimation/kernels": ["base"],  # states
    "estimation/increments": [*LOW, "estimation/kernels"],  # states, factors
    "estimation": [*LOW, *LOW_ESTIMATION],  # traces, messages, channels
    "estimation/graph": [*LOW, *LOW_ESTIMATION, "estimation"],  # the smoother and its factors
    "input": BEFORE_MOTION,  # motion, map
    "motion/slip": BEFORE_MOTION,  # sudden slip, standstill, noise
    "motion/history": BEFORE_MOTION,  # what samples and paths show
    "motion/rest": [*BEFORE_MOTION, "motion/history"],  # slip, the wheel's errors while it rolls
    "motion": [*BEFORE_MOTION, *MOTION],  # input, map
    "map/path": BEFORE_MOTION,  # ground, fixes
    "map/fixes": [*BEFORE_MOTION, *MAP[:1]],  # ground, the graph's solution
    "map": [*BEFORE_MOTION, *MAP[:2]],  # input, motion
    "map/merge": [*BEFORE_MOTION, *MAP[:3]],  # the track driven now
    "persist": [*BEFORE_MOTION, *MOTION, "motion", *MAP],  # when it is saved or taken up
    # Threads of its own, clocks, LCM, ROS.
    "pipeline": [*BEFORE_MOTION, "input", "motion/history", "motion", *MAP, "persist"],
    "live": [*LOW, "pipeline"],  # how anything is estimated, LCM, ROS
    "io": [*LOW, "input"],  # the estimator
    "apps": [*LOW, "pipeline", "live", "io"],  # how anything is estimated
    "python": [*LOW, "gpr", *GPR, "estimation", *MAP, "pipeline"],  # LCM, ROS
}

# include/gprodom/NAME.h: the room that it is the public face of.
PUBLIC = {
    "base": "choices duration_histogram error execution export front_end input outputs "
    "position_fix types version",
    "config": "config",
    "estimation": "user_factor",
    "pipeline": "odometry",
    "live": "live",
    "io": "lcm_io",
}
ROOM_OF_PUBLIC = {name: room for room, names in PUBLIC.items() for name in names.split()}

# Libraries that only some rooms may know, and what only a room with threads may include.
ONLY_IN = {
    r"ceres/": ["estimation", "estimation/graph"],
    r"(lcm|lcmtypes|bot_core)/": ["io"],
    r"yaml-cpp/": ["config"],
    r"spdlog/": ["apps"],
    r"(ros|tf2_ros|sensor_msgs|nav_msgs|diagnostic_msgs|gprodom_ros)/": [],
    r"(thread|mutex|condition_variable|future)$": ["base", "live", "apps"],
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
                faults.append(f"{place}: only in {', '.join(rooms) or 'ros/'}")
    return faults


def rooms_of_page() -> list[str]:
    """The rooms in their order, as docs/architecture.md lists them."""
    section = ARCHITECTURE.read_text().partition("\n## Rooms\n")[2].partition("\n## ")[0]
    return re.findall(r"^- `([\w/]+)`: ", section, re.MULTILINE)


def main() -> int:
    """Every source under src/ and include/, as git knows them."""
    below = ("src", "include")
    sources = [each for each in tracked_sources() if each.relative_to(CHECKOUT).parts[0] in below]
    faults = [fault for source in sources for fault in faults_of(source)]
    counts = Counter(source.parent for source in sources if source.suffix == ".cpp")
    faults += [
        f"{folder.relative_to(CHECKOUT)}: {count} sources, at most {MOST_SOURCES}"
        for folder, count in counts.items()
        if count > MOST_SOURCES
    ]
    faults += [f"src/{name}: no such folder" for name in ROOMS if not (SOURCES / name).is_dir()]
    if rooms_of_page() != list(ROOMS):
        faults.append(f"docs/{ARCHITECTURE.name}: its rooms are not those of {sys.argv[0]}")
    print("\n".join(faults) or f"{len(sources)} sources in {len(counts)} folders: in order")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
