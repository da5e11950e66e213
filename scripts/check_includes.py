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
from typing import NamedTuple

CHECKOUT = Path(__file__).resolve().parent.parent
SOURCES = CHECKOUT / "src"
ARCHITECTURE = CHECKOUT / "docs" / "architecture.md"
MOST_SOURCES = 20  # .cpp files in a folder


class Room(NamedTuple):
    """A folder of src/."""

    holds: str
    knows_nothing_of: str
    includes: list[str]  # folders whose headers its files may include, besides its own


GPR = [
    "gpr/kernels",
    "gpr/filter",
    "gpr/peaks",
    "gpr/sequential",
    "gpr/motion",
    "gpr/revisit",
    "gpr/pair",
]
LOW_ESTIMATION = ["estimation/kernels", "estimation/increments"]
BEFORE_MOTION = ["base", "config", "gpr", *GPR, *LOW_ESTIMATION, "estimation", "estimation/graph"]
MAP = ["map/path", "map/fixes", "map", "map/merge"]
ROOMS = {
    "base": Room(
        "plain values, errors, sealed bytes, whole files, work that takes effect at a data time",
        "settings, algorithms",
        [],
    ),
    "config": Room("every setting: key, unit, default, check", "what a setting does", ["base"]),
    "gpr/kernels": Room("sums and products that fill vector units", "traces", ["base", "config"]),
    "gpr/filter": Room(
        "what is done to one trace before anything is read from it",
        "peaks, windows, distances",
        ["base", "config", "gpr/kernels"],
    ),
    "gpr/peaks": Room(
        "reflections in one trace, as damped sinusoids",
        "other traces",
        ["base", "config", *GPR[:2]],
    ),
    "gpr/sequential": Room(
        "displacement from one window of traces to the next",
        "the wheel, ground seen before",
        ["base", "config", *GPR[:3]],
    ),
    "gpr/motion": Room(
        "standstill and path length from the similarity of traces",
        "the wheel, metres",
        ["base", "config", *GPR[:3]],
    ),
    "gpr/revisit": Room(
        "the memory of ground by distance, and the search in it",
        "poses, the map",
        ["base", "config", *GPR[:3]],
    ),
    "gpr/pair": Room(
        "displacement from one antenna to the one behind it",
        "the wheel, states",
        ["base", "config", *GPR[:3]],
    ),
    "gpr": Room("the front end that a setting names", "states, factors", ["base", "config", *GPR]),
    "estimation/kernels": Room(
        "rotations; products and elimination of small blocks that fill vector units",
        "states",
        ["base"],
    ),
    "estimation/increments": Room(
        "IMU and wheel integrated from one state to the next",
        "states, factors",
        ["base", "config", "estimation/kernels"],
    ),
    "estimation": Room(
        "the first state, factors, fixed-lag smoother",
        "traces, messages, channels",
        ["base", "config", *LOW_ESTIMATION],
    ),
    "estimation/graph": Room(
        "the pose graph of a track in the plane",
        "the smoother and its factors",
        ["base", "config", *LOW_ESTIMATION, "estimation"],
    ),
    "input": Room(
        "which messages can be used: time guard, plausibility, sensor and clock watch, health",
        "motion, map",
        BEFORE_MOTION,
    ),
    "motion/slip": Room(
        "online slip estimation: slip that sets in over seconds, and what measures it",
        "sudden slip, standstill, noise",
        BEFORE_MOTION,
    ),
    "motion/history": Room(
        "samples of IMU and wheel by time, and what of them is plausible; a path by its distance",
        "what they show",
        BEFORE_MOTION,
    ),
    "motion/rest": Room(
        "does the robot stand: noise and vibration at rest, ticks of a coarse wheel",
        "slip, the wheel's errors while it rolls",
        [*BEFORE_MOTION, "motion/history"],
    ),
    "motion": Room(
        "detectors: does the robot stand, does the wheel slip, which noise holds",
        "input, map",
        [*BEFORE_MOTION, "motion/slip", "motion/history", "motion/rest"],
    ),
    "map/path": Room(
        "the path driven, from settled states to steps of the pose graph",
        "ground, fixes",
        BEFORE_MOTION,
    ),
    "map/fixes": Room(
        "positions from outside: brought to site, judged by the path between them",
        "ground, the graph's solution",
        [*BEFORE_MOTION, "map/path"],
    ),
    "map": Room(
        "ground driven over: passes, search, the map frame, the map's file",
        "input, motion",
        [*BEFORE_MOTION, "map/path", "map/fixes"],
    ),
    "map/merge": Room(
        "two maps joined to one",
        "the track driven now",
        [*BEFORE_MOTION, "map/path", "map/fixes", "map"],
    ),
    "persist": Room(
        "what one run leaves to the next: pose, wheel scale, share of slip, ground",
        "when it is saved or taken up",
        [*BEFORE_MOTION, "motion/slip", "motion/history", "motion/rest", "motion", *MAP],
    ),
    "pipeline": Room(
        "the facade: step() on one screen, prediction, radar task, going on from a saved pose",
        "threads of its own, clocks, LCM, ROS",
        [*BEFORE_MOTION, "input", "motion/history", "motion", *MAP, "persist"],
    ),
    "live": Room(
        "threads, queues, commands, latencies",
        "how anything is estimated, LCM, ROS",
        ["base", "config", "pipeline"],
    ),
    "io": Room(
        "LCM packets and logs to values and back, and nothing else",
        "the estimator",
        ["base", "config", "input"],
    ),
    "apps": Room(
        "gprodomd and gprodom-replay, a page each",
        "how anything is estimated",
        ["base", "config", "pipeline", "live", "io"],
    ),
    "python": Room(
        "the Python module of the same classes and functions",
        "LCM, ROS",
        ["base", "config", "gpr", *GPR, "estimation", *MAP, "pipeline"],
    ),
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
        if other is not None and other != room and other not in ROOMS[room].includes:
            faults.append(f"{place}: {room} must not include {other}")
        # The factors know the geometry of the plane, and the graph knows no more of them.
        if room == "estimation/graph" and other == "estimation" and "planar_geometry" not in header:
            faults.append(f"{place}: of estimation the graph may include planar_geometry.h alone")
        for pattern, rooms in ONLY_IN.items():
            if re.match(pattern, header) and room not in rooms:
                faults.append(f"{place}: only in {', '.join(rooms) or 'ros/'}")
    return faults


def table() -> str:
    """The rooms as docs/architecture.md shows them."""
    return "".join(f"- `{name}`: {room.holds}\n" for name, room in ROOMS.items())


def main() -> int:
    """Every source under src/ and include/, as git knows them."""
    if sys.argv[1:] == ["--table"]:
        print(table(), end="")
        return 0
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
    faults += [f"src/{name}: no such folder" for name in ROOMS if not (SOURCES / name).is_dir()]
    if table() not in ARCHITECTURE.read_text():
        faults.append(f"docs/{ARCHITECTURE.name}: its rooms are not those of {sys.argv[0]} --table")
    print("\n".join(faults) or f"{len(sources)} sources in {len(counts)} folders: in order")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
