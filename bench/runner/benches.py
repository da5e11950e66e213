"""The table of benches: what `bench/run` measures, in the order in which it does.

A new bench is an entry here. Its program prints JSON with --json; `read` says which values of that
are figures (readers.py, figures.py), with unit and direction. jobs.py makes the jobs. A job is what
is run, kept and run again at once: some minutes at most, on one core, with arguments that tell it
so (-j1). What decides most comes first.
"""

from __future__ import annotations

from functools import partial
from pathlib import Path

import jobs
import readers
from anchoring import anchors
from job import Bench, Job

from figures import by_name, by_row, one_row

short_name = readers.short_name
# Without --set; of times, so that nothing runs beside it; both.
as_it_is, timed = partial(Bench, settable=False), partial(Bench, alone=True)
timed_as_it_is = partial(timed, settable=False)


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
            jobs.of_anchors(),
            "anchors",
        ),
        *of_simulation(),
        *of_speed(data),
    )


def of_drives(data: Path) -> tuple[Bench, ...]:
    """Errors of the estimate."""
    twelve, rough = jobs.drives(data, "cmu_like", (9,)), jobs.drives(data, "rough", (7,))
    robots = jobs.recordings((), ("phil1", "phil8", "f1tenth1", "warthog_a", "wid09"))
    variations = by_row(lambda row: f"{row['recording']}/{row['variation']}", readers.ROBOT)
    return (
        Bench("twelve", "Gentle drives", readers.DRIVE, twelve, "rough.py"),
        Bench("rough", "Rough drives", readers.DRIVE, rough),
        Bench("robots", "Recordings of real robots", by_name(readers.ROBOT), robots),
        Bench("sample", "The sample drive", readers.DRIVE, jobs.sample(), "rough.py"),
        Bench(
            "variations",
            "Variations of these recordings",
            variations,
            jobs.recordings(("-j1",), ()),
            "robot_variations.py",
        ),
        as_it_is(
            "slip_kinds",
            "Simulated drives with five kinds of lasting slip",
            readers.METHOD,
            (Job("all", ("--", *jobs.SLIP_KINDS)),),
            "methods.py",
        ),
    )


def of_pairs(data: Path) -> tuple[Bench, ...]:
    """Two antennas in a row, and the ground that differs beside a track."""
    distance = by_row(lambda row: f"{row['ground']}/{row['case']}", readers.PAIR)
    fault = by_row(
        lambda row: f"{row['ground']}/{row['fault']}/{row['method']}", readers.PAIR_FAULT
    )
    return (
        Bench("pairs", "Drives with two antennas", readers.DRIVE, jobs.drives(data, "pairs", ())),
        as_it_is(
            "pair_distance",
            "Distance by two antennas alone, over 50 m, beside its limit",
            distance,
            jobs.of_grounds(),
        ),
        as_it_is(
            "pair_faults",
            "Two antennas over rebar, swapped, silent, and drifting apart",
            fault,
            jobs.of_pair_faults(),
        ),
        as_it_is(
            "lateral",
            "Correlation of real ground beside a track",
            readers.lateral,
            (Job("all", ("{data}/real_ground",), short=True),),
        ),
    )


def of_sensors(data: Path) -> tuple[Bench, ...]:
    """Starts, standstill, slip, faults, and robots that nobody has measured."""
    twelve = jobs.drives(data, "cmu_like", ())
    start = by_row(lambda row: f"{short_name(row['sequence'])}/{row['cut_s']:.0f} s", readers.START)
    mounting = by_row(lambda row: row["recording"], readers.MOUNTING)
    trigger = by_row(lambda row: f"{row['ground']}/{row['slip']}/{row['trigger']}", readers.TRIGGER)
    cuts = jobs.with_sequences(twelve, "--share=0.3", "--share=0.5", short=(9,))
    digging = jobs.simulated("--cases=40", "--km=4", "-j1", short=("--cases=4", "-j1"))
    damaged = jobs.simulated("--recordings=200", short=("--recordings=9", "--damaged=1"))
    faulty = (
        Job(number, (name, *jobs.FAULTS), prefix=number)
        for name in (jobs.sequence(data, 3), jobs.sequence(data, 9))
        for number in (short_name(Path(name).name),)
    )
    return (
        Bench("mid_drive", "Starts in mid-drive", start, cuts),
        Bench(
            "wheel_fails",
            "The wheel fails for 10 s",
            readers.motion,
            jobs.with_sequences(twelve, "--cut=10"),
            "motion.py",
        ),
        Bench(
            "motion",
            "Standstill, slip and coherence",
            readers.motion,
            jobs.with_sequences(twelve, short=(9,)),
        ),
        as_it_is("immobilised", "Immobilised robots", readers.immobilised, digging),
        as_it_is("methods", "The paper's methods", readers.METHOD, jobs.of_scenes(data)),
        as_it_is(
            "doctor",
            "What `gprodom doctor` names, of 26 kinds of damage, and in good recordings",
            readers.doctor,
            damaged,
        ),
        as_it_is(
            "commission",
            "What `gprodom commission` finds of 50 robots, and of recordings of real ones",
            readers.commission,
            jobs.of_commission(),
        ),
        Bench(
            "mounting",
            "Mountings of the IMU at random, found while driving",
            mounting,
            (
                *jobs.drives(data, "cmu_like", (9,)),
                *jobs.with_points(jobs.recordings(("-j1",), ("f1tenth3",))),
            ),
            "mounting_found.py",
        ),
        as_it_is(
            "triggers",
            "Traces that the wheel triggers, against those of a clock",
            trigger,
            jobs.of_triggers(),
        ),
        as_it_is(
            "salient",
            "Apexes of pipes, and what windows and a map of pipes tell",
            readers.salient,
            jobs.of_salient(twelve),
        ),
        as_it_is(
            "faults",
            "Faults of sensors and clocks",
            readers.faults,
            tuple(faulty),
            "faults",
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
    changed = jobs.simulated("--runs=6", "--no-beside", "--change", "0", "10", "-20", "--jobs=1")
    return (
        Bench(
            "revisits",
            "Revisits of the gentle drives, with unknown and true scale",
            revisit,
            jobs.with_sequences(jobs.drives(data, "cmu_like", ()), "-j1"),
        ),
        Bench(
            "coverage",
            "The pose in map: coverage, and wrong revisits",
            one_row(readers.MAP),
            jobs.simulated("--runs=20", "--wrong", "--jobs=1", short=("--runs=2", "--jobs=1")),
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
            jobs.simulated("--runs=12", "--robot=all", "--jobs=1"),
        ),
        Bench(
            "relocation",
            "Located after a reset",
            one_row(readers.VISIT),
            jobs.simulated("--runs=20", "--jobs=1"),
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
            "merge",
            "Maps of two days become one",
            readers.merge,
            jobs.simulated("--runs=4", "--jobs=1"),
        ),
        as_it_is(
            "revisit_along",
            "Revisits along real lines",
            by_row(lambda row: str(row["variant"]), readers.REVISIT),
            (along,),
        ),
    )


def of_simulation() -> tuple[Bench, ...]:
    """What is simulated, and calibrated on it."""
    real = ("{data}/real_ground", "{data}/cmu_real", "{data}/robots/husky.bag")
    return (
        as_it_is(
            "radar_time_offset",
            "Calibration of the radar's time offset",
            readers.radar_time_offset,
            jobs.simulated("--seeds=4", "--jobs=1"),
        ),
        as_it_is(
            "fdtd",
            "The simulated ground against physics",
            one_row(readers.FDTD),
            jobs.simulated(),
            "fdtd_physics.py",
        ),
        as_it_is(
            "realism",
            "Simulated data beside real ones",
            readers.realism,
            (Job("all", ("{data}",), real),),
        ),
    )


def of_speed(data: Path) -> tuple[Bench, ...]:
    """Times: nothing runs beside them, but for the pages of `gprodom report`."""
    garage, basement = jobs.sequence(data, 0), jobs.sequence(data, 3)
    both = (Job("all", (garage, basement)),)
    replays = by_row(lambda row: f"{short_name(row['log'])}/{row['case']}", readers.REPLAY)

    def on_basement(*words: str) -> tuple[Job, ...]:
        return (Job("all", (basement, *words)),)

    return (
        timed_as_it_is(
            "hostile_packets",
            "Packets that no daemon should believe",
            readers.hostile_packets,
            on_basement("--packets=20000", "--speed=4"),
        ),
        timed_as_it_is(
            "process_faults",
            "A daemon whose process, disk or listener fails",
            readers.process_faults,
            on_basement("--seconds=20"),
        ),
        timed_as_it_is(
            "kernels",
            "Processor time of the parts",
            by_row(lambda row: str(row["name"]), readers.KERNEL),
            jobs.simulated(),
            compiled=True,
        ),
        timed("replay_speed", "Speed of a replay", replays, both),
        timed_as_it_is(
            "view_load",
            "Looking at a drive of an hour, and at a running robot",
            one_row(readers.VIEW),
            on_basement(),
        ),
        as_it_is(
            "report_pages",
            "Pages of `gprodom report`, as Chromium shows and prints them",
            by_name(readers.PAGE),
            (Job("all", ("{data}",), jobs.PAGES, ("{data}", "--only=robot")),),
        ),
        timed(
            "window_solvers",
            "The window by Ceres and by the chain",
            by_row(lambda row: short_name(row["log"]), readers.SOLVERS),
            both,
        ),
        timed_as_it_is(
            "smoothers",
            "Beside GTSAM",
            readers.smoothers,
            (Job("all", ("--repeats=1", "--rate=5", basement)),),
            compiled=True,
        ),
        timed(
            "live",
            "Cost and latency of the daemon, live",
            readers.live,
            (
                Job("idle", (basement,), prefix="idle"),
                Job("busy", (basement, "--busy=2"), prefix="busy"),
            ),
            "live_load.py",
        ),
        timed_as_it_is(
            "ros2_live",
            "Latency and losses of the ROS 2 node (built by scripts/check-ros2), live",
            readers.live,
            jobs.of_ros2(),
        ),
    )
