"""The table of benches: what `bench/run` measures, in the order in which it does.

A new bench is an entry here. Its program prints JSON with --json; `read` says which values of that
are figures (readers.py, figures.py), with unit and direction. jobs.py makes the jobs. A job is what
is run, kept and run again at once: some minutes at most, on one core, with arguments that tell it
so (-j1). What decides most comes first.
"""

from __future__ import annotations

from pathlib import Path

import readers
from anchoring import anchors
from job import Bench, Job
from jobs import (
    FAULTS,
    PAGES,
    SLIP_KINDS,
    drives,
    of_anchors,
    of_commission,
    of_grounds,
    of_pair_faults,
    of_ros2,
    of_salient,
    of_scenes,
    of_triggers,
    recordings,
    sample,
    sequence,
    simulated,
    with_points,
    with_sequences,
)

from figures import by_name, by_row, one_row

short_name = readers.short_name


def benches(data: Path) -> tuple[Bench, ...]:
    """All of them. data: the folder of recorded data."""
    return (
        *of_drives(data),
        *of_pairs(data),
        *of_sensors(data),
        *of_maps(data),
        Bench(
            "anchors",
            "Positions from outside: what they give, and faults of their receivers",
            anchors,
            of_anchors(),
            "anchors",
        ),
        *of_simulation(),
        *of_speed(data),
    )


def of_drives(data: Path) -> tuple[Bench, ...]:
    """Errors of the estimate."""
    twelve, rough = drives(data, "cmu_like", (9,)), drives(data, "rough", (7,))
    robots = recordings((), ("phil1", "phil8", "f1tenth1", "warthog_a", "wid09"))
    variations = by_row(lambda row: f"{row['recording']}/{row['variation']}", readers.ROBOT)
    return (
        Bench("twelve", "Gentle drives", readers.DRIVE, twelve, "rough.py"),
        Bench("rough", "Rough drives", readers.DRIVE, rough),
        Bench("robots", "Recordings of real robots", by_name(readers.ROBOT), robots),
        Bench("sample", "The sample drive", readers.DRIVE, sample(), "rough.py"),
        Bench(
            "variations",
            "Variations of these recordings",
            variations,
            recordings(("-j1",), ()),
            "robot_variations.py",
        ),
        Bench(
            "slip_kinds",
            "Simulated drives with five kinds of lasting slip",
            readers.METHOD,
            (Job("all", ("--", *SLIP_KINDS)),),
            "methods.py",
            settable=False,
        ),
    )


def of_pairs(data: Path) -> tuple[Bench, ...]:
    """Two antennas in a row, and the ground that differs beside a track."""
    distance = by_row(lambda row: f"{row['ground']}/{row['case']}", readers.PAIR)
    fault = by_row(
        lambda row: f"{row['ground']}/{row['fault']}/{row['method']}", readers.PAIR_FAULT
    )
    return (
        Bench("pairs", "Drives with two antennas", readers.DRIVE, drives(data, "pairs", ())),
        Bench(
            "pair_distance",
            "Distance by two antennas alone, over 50 m, beside its limit",
            distance,
            of_grounds(),
            settable=False,
        ),
        Bench(
            "pair_faults",
            "Two antennas over rebar, swapped, silent, and drifting apart",
            fault,
            of_pair_faults(),
            settable=False,
        ),
        Bench(
            "lateral",
            "Correlation of real ground beside a track",
            readers.lateral,
            (Job("all", ("{data}/real_ground",), short=True),),
            settable=False,
        ),
    )


def of_sensors(data: Path) -> tuple[Bench, ...]:
    """Starts, standstill, slip, faults, and robots that nobody has measured."""
    twelve = drives(data, "cmu_like", ())
    start = by_row(lambda row: f"{short_name(row['sequence'])}/{row['cut_s']:.0f} s", readers.START)
    mounting = by_row(lambda row: row["recording"], readers.MOUNTING)
    trigger = by_row(lambda row: f"{row['ground']}/{row['slip']}/{row['trigger']}", readers.TRIGGER)
    cuts = with_sequences(twelve, "--share=0.3", "--share=0.5", short=(9,))
    digging = simulated("--cases=40", "--km=4", "-j1", short=("--cases=4", "-j1"))
    damaged = simulated("--recordings=200", short=("--recordings=9", "--damaged=1"))
    faulty = (
        Job(number, (name, *FAULTS), prefix=number)
        for name in (sequence(data, 3), sequence(data, 9))
        for number in (short_name(Path(name).name),)
    )
    return (
        Bench("mid_drive", "Starts in mid-drive", start, cuts),
        Bench(
            "wheel_fails",
            "The wheel fails for 10 s",
            readers.motion,
            with_sequences(twelve, "--cut=10"),
            "motion.py",
        ),
        Bench(
            "motion",
            "Standstill, slip and coherence",
            readers.motion,
            with_sequences(twelve, short=(9,)),
        ),
        Bench("immobilised", "Immobilised robots", readers.immobilised, digging, settable=False),
        Bench("methods", "The paper's methods", readers.METHOD, of_scenes(data), settable=False),
        Bench(
            "doctor",
            "What `gprodom doctor` names, of 26 kinds of damage, and in good recordings",
            readers.doctor,
            damaged,
            settable=False,
        ),
        Bench(
            "commission",
            "What `gprodom commission` finds of 50 robots, and of recordings of real ones",
            readers.commission,
            of_commission(),
            settable=False,
        ),
        Bench(
            "mounting",
            "Mountings of the IMU at random, found while driving",
            mounting,
            (*drives(data, "cmu_like", (9,)), *with_points(recordings(("-j1",), ("f1tenth3",)))),
            "mounting_found.py",
        ),
        Bench(
            "triggers",
            "Traces that the wheel triggers, against those of a clock",
            trigger,
            of_triggers(),
            settable=False,
        ),
        Bench(
            "salient",
            "Apexes of pipes, and what windows and a map of pipes tell",
            readers.salient,
            of_salient(twelve),
            settable=False,
        ),
        Bench(
            "faults",
            "Faults of sensors and clocks",
            readers.faults,
            tuple(faulty),
            "faults",
            settable=False,
        ),
    )


def of_maps(data: Path) -> tuple[Bench, ...]:
    """Ground seen before."""
    revisit = by_row(
        lambda row: f"{short_name(row['sequence'])}/{row['scale']}/{row['method']}", readers.FOUND
    )
    another_day = Job(
        "all", ("{data}", "--lines=8", "--strangers=8", "--change", "0"), ("{data}/real_ground",)
    )
    along = Job("all", ("{data}",), ("{data}/real_ground", "{data}/revisit_eval.py"))
    same = ("{data}/cmu_like", "-j1")
    changed = simulated("--runs=6", "--no-beside", "--change", "0", "10", "-20", "--jobs=1")
    return (
        Bench(
            "revisits",
            "Revisits of the gentle drives, with unknown and true scale",
            revisit,
            with_sequences(drives(data, "cmu_like", ()), "-j1"),
        ),
        Bench(
            "coverage",
            "The pose in map: coverage, and wrong revisits",
            one_row(readers.MAP),
            simulated("--runs=20", "--wrong", "--jobs=1", short=("--runs=2", "--jobs=1")),
            "map_coverage.py",
        ),
        Bench(
            "yard",
            "The same 400 m again and again",
            readers.yard,
            (
                Job("days", ("48",), short=("0.1", "--rest=5"), prefix="one"),
                Job(
                    "pieces",
                    ("168", "--pieces=7"),
                    short=("0.1", "--rest=5", "--pieces=2"),
                    prefix="pieces",
                ),
            ),
            compiled=True,
        ),
        Bench(
            "consistency",
            "Consistency over simulated robots",
            readers.consistency,
            simulated("--runs=12", "--robot=all", "--jobs=1"),
        ),
        Bench(
            "relocation",
            "Located after a reset",
            one_row(readers.VISIT),
            simulated("--runs=20", "--jobs=1"),
        ),
        Bench(
            "changed_ground", "Located on ground that has changed", readers.changed_ground, changed
        ),
        Bench(
            "another_day",
            "Located on real ground of another line or day",
            by_row(lambda row: str(row["drives"]), readers.VISIT),
            (another_day,),
            "real_another_day.py",
        ),
        Bench(
            "days",
            "Drives that begin with the map of another",
            readers.days,
            (
                Job("same ground", same, prefix="same"),
                Job("strangers", (same[0], "--strangers", "-j1"), prefix="strangers"),
            ),
        ),
        Bench(
            "merge", "Maps of two days become one", readers.merge, simulated("--runs=4", "--jobs=1")
        ),
        Bench(
            "revisit_along",
            "Revisits along real lines",
            by_row(lambda row: str(row["variant"]), readers.REVISIT),
            (along,),
            settable=False,
        ),
    )


def of_simulation() -> tuple[Bench, ...]:
    """What is simulated, and calibrated on it."""
    real = ("{data}/real_ground", "{data}/cmu_real", "{data}/robots/husky.bag")
    return (
        Bench(
            "radar_time_offset",
            "Calibration of the radar's time offset",
            readers.radar_time_offset,
            simulated("--seeds=4", "--jobs=1"),
            settable=False,
        ),
        Bench(
            "fdtd",
            "The simulated ground against physics",
            one_row(readers.FDTD),
            simulated(),
            "fdtd_physics.py",
            settable=False,
        ),
        Bench(
            "realism",
            "Simulated data beside real ones",
            readers.realism,
            (Job("all", ("{data}",), real),),
            settable=False,
        ),
    )


def of_speed(data: Path) -> tuple[Bench, ...]:
    """Times: nothing runs beside them, but for the pages of `gprodom report`."""
    garage, basement = sequence(data, 0), sequence(data, 3)
    both = (Job("all", (garage, basement)),)
    replays = by_row(lambda row: f"{short_name(row['log'])}/{row['case']}", readers.REPLAY)

    def on_basement(*words: str) -> tuple[Job, ...]:
        return (Job("all", (basement, *words)),)

    return (
        Bench(
            "hostile_packets",
            "Packets that no daemon should believe",
            readers.hostile_packets,
            on_basement("--packets=20000", "--speed=4"),
            alone=True,
            settable=False,
        ),
        Bench(
            "process_faults",
            "A daemon whose process, disk or listener fails",
            readers.process_faults,
            on_basement("--seconds=20"),
            alone=True,
            settable=False,
        ),
        Bench(
            "kernels",
            "Processor time of the parts",
            by_row(lambda row: str(row["name"]), readers.KERNEL),
            simulated(),
            alone=True,
            settable=False,
            compiled=True,
        ),
        Bench("replay_speed", "Speed of a replay", replays, both, alone=True),
        Bench(
            "view_load",
            "Looking at a drive of an hour, and at a running robot",
            one_row(readers.VIEW),
            on_basement(),
            alone=True,
            settable=False,
        ),
        Bench(
            "report_pages",
            "Pages of `gprodom report`, as Chromium shows and prints them",
            by_name(readers.PAGE),
            (Job("all", ("{data}",), PAGES, ("{data}", "--only=robot")),),
            settable=False,
        ),
        Bench(
            "window_solvers",
            "The window by Ceres and by the chain",
            by_row(lambda row: short_name(row["log"]), readers.SOLVERS),
            both,
            alone=True,
        ),
        Bench(
            "smoothers",
            "Beside GTSAM",
            readers.smoothers,
            (Job("all", ("--repeats=1", "--rate=5", basement)),),
            alone=True,
            settable=False,
            compiled=True,
        ),
        Bench(
            "live",
            "Cost and latency of the daemon, live",
            readers.live,
            (
                Job("idle", (basement,), prefix="idle"),
                Job("busy", (basement, "--busy=2"), prefix="busy"),
            ),
            "live_load.py",
            alone=True,
        ),
        Bench(
            "ros2_live",
            "Latency and losses of the ROS 2 node (built by scripts/check-ros2), live",
            readers.live,
            of_ros2(),
            alone=True,
            settable=False,
        ),
    )
