"""The table of benches: what `bench/run` measures, in the order in which it does.

A new bench is an entry here. Its program prints JSON with --json; `read` says which values of that
are figures (readers.py, figures.py), with unit and direction. jobs.py makes the jobs. A job is what
is run, kept and run again at once: some minutes at most, on one core, with arguments that tell it
so (-j1). What decides most comes first.
"""

from __future__ import annotations

from pathlib import Path

from anchoring import of_anchors
from job import Bench, Job
from jobs import (
    FAULTS,
    SLIP_KINDS,
    drives,
    of_salient,
    of_scenes,
    recordings,
    sample,
    sequence,
    simulated,
    with_sequences,
)
from looking import looking
from maps import of_maps
from new_robots import commissioning, mountings, triggering
from readers import (
    DRIVE,
    FDTD,
    METHOD,
    ROBOT,
    SOLVERS,
    START,
    doctor,
    faults,
    hostile_packets,
    immobilised,
    live,
    motion,
    process_faults,
    radar_time_offset,
    realism,
    salient,
    short_name,
    smoothers,
)
from two_antennas import of_pairs

from figures import TIME_SPREAD, Unit, by_row, one_row, rows


def benches(data: Path) -> tuple[Bench, ...]:
    """All of them. data: the folder of recorded data."""
    return (
        *of_drives(data),
        *of_pairs(data),
        *of_sensors(data),
        *of_maps(data),
        *of_anchors(),
        *of_simulation(data),
        *of_speed(data),
    )


def of_drives(data: Path) -> tuple[Bench, ...]:
    """Errors of the estimate."""
    twelve = drives(data, "cmu_like", (9,))
    return (
        Bench("twelve", "Gentle drives", "rough.py", DRIVE, twelve),
        Bench("rough", "Rough drives", "rough.py", DRIVE, drives(data, "rough", (7,))),
        Bench(
            "robots",
            "Recordings of real robots",
            "robots.py",
            rows((), ROBOT),
            recordings((), ("phil1", "phil8", "f1tenth1", "warthog_a", "wid09")),
        ),
        Bench("sample", "The sample drive", "rough.py", DRIVE, sample()),
        Bench(
            "variations",
            "Variations of these recordings",
            "robot_variations.py",
            by_row(lambda row: f"{row['recording']}/{row['variation']}", ROBOT),
            recordings(("-j1",), ()),
        ),
        Bench(
            "slip_kinds",
            "Simulated drives with five kinds of lasting slip",
            "methods.py",
            METHOD,
            (Job("all", ("--", *SLIP_KINDS)),),
            settable=False,
        ),
    )


def of_sensors(data: Path) -> tuple[Bench, ...]:
    """Starts, standstill, slip and faults."""
    twelve = drives(data, "cmu_like", ())
    return (
        Bench(
            "mid_drive",
            "Starts in mid-drive",
            "mid_drive.py",
            by_row(lambda row: f"{short_name(row['sequence'])}/{row['cut_s']:.0f} s", START),
            tuple(with_sequences(twelve, "--share=0.3", "--share=0.5", short=(9,))),
        ),
        Bench(
            "wheel_fails",
            "The wheel fails for 10 s",
            "motion.py",
            motion,
            tuple(with_sequences(twelve, "--cut=10")),
        ),
        Bench(
            "motion",
            "Standstill, slip and coherence",
            "motion.py",
            motion,
            tuple(with_sequences(twelve, short=(9,))),
        ),
        Bench(
            "immobilised",
            "Immobilised robots",
            "immobilised.py",
            immobilised,
            simulated("--cases=40", "--km=4", "-j1", short=("--cases=4", "-j1")),
            settable=False,
        ),
        Bench(
            "methods", "The paper's methods", "methods.py", METHOD, of_scenes(data), settable=False
        ),
        Bench(
            "doctor",
            "What `gprodom doctor` names, of 26 kinds of damage, and in good recordings",
            "doctor.py",
            doctor,
            simulated("--recordings=200", short=("--recordings=9", "--damaged=1")),
            settable=False,
        ),
        commissioning(),
        mountings(data),
        triggering(),
        Bench(
            "salient",
            "Apexes of pipes, and what windows and a map of pipes tell",
            "salient.py",
            salient,
            of_salient(twelve),
            settable=False,
        ),
        Bench(
            "faults",
            "Faults of sensors and clocks",
            "faults",
            faults,
            tuple(
                Job(number, (name, *FAULTS), (name,), prefix=number)
                for name in (sequence(data, 3), sequence(data, 9))
                for number in (short_name(Path(name).name),)
            ),
            settable=False,
        ),
    )


def of_simulation(data: Path) -> tuple[Bench, ...]:
    """What is simulated, and calibrated on it."""
    return (
        Bench(
            "radar_time_offset",
            "Calibration of the radar's time offset",
            "radar_time_offset.py",
            radar_time_offset,
            simulated("--seeds=4", "--jobs=1"),
            settable=False,
        ),
        Bench(
            "fdtd",
            "The simulated ground against physics",
            "fdtd_physics.py",
            one_row(FDTD),
            simulated(),
            settable=False,
        ),
        Bench(
            "realism",
            "Simulated data beside real ones",
            "realism.py",
            realism,
            (
                Job(
                    "all",
                    ("{data}",),
                    ("{data}/real_ground", "{data}/cmu_real", "{data}/robots/husky.bag"),
                ),
            ),
            settable=False,
        ),
    )


def of_speed(data: Path) -> tuple[Bench, ...]:
    """Times: nothing runs beside them."""
    garage, basement = sequence(data, 0), sequence(data, 3)
    both = (garage, basement)
    return (
        Bench(
            "hostile_packets",
            "Packets that no daemon should believe",
            "hostile_packets.py",
            hostile_packets,
            (Job("all", (basement, "--packets=20000", "--speed=4"), (basement,)),),
            alone=True,
            settable=False,
        ),
        Bench(
            "process_faults",
            "A daemon whose process, disk or listener fails",
            "process_faults.py",
            process_faults,
            (Job("all", (basement, "--seconds=20"), (basement,)),),
            alone=True,
            settable=False,
        ),
        Bench(
            "kernels",
            "Processor time of the parts",
            "kernels.py",
            by_row(lambda row: str(row["name"]), {"us": Unit("us", "lower", "spread_us")}),
            simulated(),
            alone=True,
            settable=False,
            compiled=True,
        ),
        Bench(
            "replay_speed",
            "Speed of a replay",
            "replay_speed.py",
            by_row(
                lambda row: f"{short_name(row['log'])}/{row['case']}",
                {
                    "times_real_time_cpu": Unit("", "higher", TIME_SPREAD),
                    "solve_ms": Unit("ms", "lower", TIME_SPREAD),
                },
            ),
            (Job("all", both, both),),
            alone=True,
        ),
        *looking(basement),
        Bench(
            "window_solvers",
            "The window by Ceres and by the chain",
            "window_solvers.py",
            by_row(
                lambda row: short_name(row["log"]),
                SOLVERS,
            ),
            (Job("all", both, both),),
            alone=True,
        ),
        Bench(
            "smoothers",
            "Beside GTSAM",
            "smoothers.py",
            smoothers,
            (Job("all", ("--repeats=1", "--rate=5", basement), (basement,)),),
            alone=True,
            settable=False,
            compiled=True,
        ),
        Bench(
            "live",
            "Cost and latency of the daemon, live",
            "live_load.py",
            live,
            (
                Job("idle", (basement,), (basement,), prefix="idle"),
                Job("busy", (basement, "--busy=2"), (basement,), prefix="busy"),
            ),
            alone=True,
        ),
        Bench(
            "ros2_live",
            "Latency and losses of the ROS 2 node (built by scripts/check-ros2), live",
            "ros2_live.py",
            live,
            tuple(
                Job(name, (drive, "--seconds=60", *more), (drive,), short, name)
                for drive in sample()[0].data
                for name, more, short in (
                    ("reliable", (), (drive, "--seconds=5")),
                    ("best_effort", ("--best-effort",), False),
                )
            ),
            alone=True,
            settable=False,
        ),
    )
