"""How the jobs of a bench are made: one for each sequence, recording or scene."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from job import BENCH, CHECKOUT, Job

sys.path.append(str(BENCH))

from recordings import RECORDINGS

PAPER = (
    "wheel,gpr_sfm,imu_wheel,bscan,bscan_signed,dec,dec_signed,sfm,sfm_signed,trace_count,"
    "trace_count_signed,gprodom"
)
SLIP_KINDS = (
    "--simulate=20",
    "--distance=100",
    "--lasting=ramps,steps,turns,gravel,ice",
    "--methods=wheel,imu_wheel,gprodom,gprodom_full",
    "-j1",
)
# The drives of report_pages.py.
PAGES = (
    "{data}/robots/phil1",
    "{data}/rough/1720005000-0-nsh_b-cmu-gpr.zip",
    "{data}/cmu_like/1700005000-0-nsh_b-cmu-gpr.zip",
    "{data}/cmu_like/1700006000-0-nsh_b-cmu-gpr.zip",
)
FAULTS = ("-c", "{checkout}/config/cmu_gpr.yaml", "--combinations=0", "-j1")


def drives(data: Path, folder: str, short: Sequence[int]) -> tuple[Job, ...]:
    """A job for each zip of a folder; those of --short by their number."""
    names = [path.name for path in sorted((data / folder).glob("*.zip"))]
    return tuple(
        Job(
            "-".join(name.split("-")[0:3:2]),
            (f"{{data}}/{folder}/{name}", "-j1"),
            short=i in short,
        )
        for i, name in enumerate(names)
    )


def sample() -> tuple[Job, ...]:
    """The drive that lies in every checkout."""
    (path,) = (CHECKOUT / "sample").glob("*-cmu-gpr.zip")
    name = f"{{checkout}}/sample/{path.name}"
    return (Job("sample", (name, "--only", "gprodom_full", "-j1"), short=True),)


def recordings(more: tuple[str, ...], short: Sequence[str]) -> tuple[Job, ...]:
    """A job for each recording of a real robot."""
    return tuple(
        Job(name, ("{data}/robots", "--only", name, *more), files_of(name), name in short)
        for name in RECORDINGS
    )


def files_of(recording: str) -> tuple[str, ...]:
    """Those of a recording of a real robot."""
    return tuple(f"{{data}}/robots/{file}" for file in RECORDINGS[recording].files)


def simulated(*arguments: str, short: tuple[str, ...] | bool = False) -> tuple[Job, ...]:
    """A single job on drives that are simulated."""
    return (Job("all", arguments, short=short),)


def of_scenes(data: Path) -> tuple[Job, ...]:
    """All methods on the sequences of a scene, on the others of which K is fitted."""
    jobs = []
    # `salient` answers too seldom in some scenes for K to be fitted in each by itself.
    for job, scene, methods in (
        *((scene, scene, PAPER) for scene in ("gates_g", "nsh_b", "nsh_h", "beach")),
        ("salient", "*", "salient,salient_signed"),
    ):
        names = sorted(path.name for path in (data / "cmu_like").glob(f"*-{scene}-*.zip"))
        files = tuple(f"{{data}}/cmu_like/{name}" for name in names)
        words = ("--", *files, "--methods", methods, "-j1", "--sample-interval", "beach=3.125e-10")
        jobs.append(Job(job, words))
    return tuple(jobs)


def of_salient(twelve: tuple[Job, ...]) -> tuple[Job, ...]:
    """The parts of salient.py; its windows are those of the gentle drives together."""
    lines = "{checkout}/test/python/pipe_lines.npz"
    names = tuple(job.data[0] for job in twelve)
    return (
        Job("apexes", ("apexes",), (lines,), True, "apexes"),
        Job("drives", ("drives",), prefix="drives"),
        Job("windows", ("windows", *names), prefix="windows"),
    )


def of_grounds() -> tuple[Job, ...]:
    """pair_distance.py on each ground."""
    jobs = []
    for ground in ("fdtd", "beach", "field"):
        words = ("{data}/real_ground", f"--ground={ground}", "-j1", "--drives=20")
        short = ground == "fdtd" and (*words[:-1], "--drives=1", "--case=centre")
        jobs.append(Job(ground, words, short=short))
    return tuple(jobs)


def sequence(data: Path, number: int) -> str:
    """One of the twelve."""
    paths = sorted((data / "cmu_like").glob("*.zip"))
    return f"{{data}}/cmu_like/{paths[number].name}" if len(paths) > number else "{data}/cmu_like"


def with_sequences(
    jobs: tuple[Job, ...], *before: str, short: Sequence[int] = ()
) -> tuple[Job, ...]:
    """The same jobs, of a program that takes a sequence, with these arguments."""
    return tuple(
        replace(job, arguments=(*before, job.data[0]), short=i in short)
        for i, job in enumerate(jobs)
    )


def with_points(jobs: tuple[Job, ...]) -> tuple[Job, ...]:
    """Those of recordings whose truth tells positions."""
    return tuple(job for job in jobs if RECORDINGS[job.name].points)


def of_pair_faults() -> tuple[Job, ...]:
    """pair_faults.py, its two parts."""
    ground = "{data}/real_ground"
    short = (ground, "--km=0", "--minutes=0.5", "--ground=fdtd")
    return Job("rebar", (ground, "--minutes=0")), Job("others", (ground, "--km=0"), short=short)


def of_triggers() -> tuple[Job, ...]:
    """triggers.py on each ground."""
    short = ("--ground=rays", "--seeds=1", "--spacing=0.02")
    return tuple(
        Job(ground, (f"--ground={ground}",), short=ground == "rays" and short)
        for ground in ("rays", "garage", "basement", "floor")
    )


def of_commission() -> tuple[Job, ...]:
    """Fifty robots, ten in a job, and the recordings of real ones."""
    robots = (
        Job(
            f"robots {first}",
            ("--no-radar", "--robots=10", f"--first={first}"),
            short=first == 0 and ("--no-radar", "--robots=1"),
            prefix=f"robots {first}",
        )
        for first in range(0, 50, 10)
    )
    return *robots, Job("recordings", ("--recordings", "{data}/robots"), prefix="recordings")


def of_anchors() -> tuple[Job, ...]:
    """A job for each recording, and those of simulated drives."""

    def of_recordings(part: str, *names: str) -> tuple[Job, ...]:
        return tuple(
            Job(
                f"{part} {name}",
                (part, "{data}/robots", *(("--only", name) if part != "withheld" else ())),
                files_of(name),
            )
            for name in names
        )

    return (
        Job("scale", ("scale", "--seeds=20"), short=("scale", "--seeds=1")),
        *of_recordings("ends", "wid02", "wid09", "f1tenth3"),
        *of_recordings("withheld", "husky"),
        *of_recordings("faults", "wid02", "f1tenth3"),
        Job("days", ("days", "--seeds=2")),
    )


def of_ros2() -> tuple[Job, ...]:
    """ros2_live.py on the drive of the checkout."""
    (drive,) = sample()[0].data
    return (
        Job(
            "reliable",
            (drive, "--seconds=60"),
            short=(drive, "--seconds=5", "--speed=8"),
            prefix="reliable",
        ),
        Job("best_effort", (drive, "--seconds=60", "--best-effort"), prefix="best_effort"),
    )
