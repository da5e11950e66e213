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
FAULTS = ("-c", "{checkout}/config/cmu_gpr.yaml", "--combinations=0", "-j1")


def drives(data: Path, folder: str, short: Sequence[int]) -> tuple[Job, ...]:
    """A job for each zip of a folder; those of --short by their number."""
    names = [path.name for path in sorted((data / folder).glob("*.zip"))]
    return tuple(
        Job(
            "-".join(name.split("-")[0:3:2]),
            (f"{{data}}/{folder}/{name}", "-j1"),
            (f"{{data}}/{folder}/{name}",),
            i in short,
        )
        for i, name in enumerate(names)
    )


def sample() -> tuple[Job, ...]:
    """The drive that lies in every checkout."""
    (path,) = (CHECKOUT / "sample").glob("*-cmu-gpr.zip")
    name = f"{{checkout}}/sample/{path.name}"
    return (Job("sample", (name, "--only", "gprodom_full", "-j1"), (name,), True),)


def recordings(more: tuple[str, ...], short: Sequence[str]) -> tuple[Job, ...]:
    """A job for each recording of a real robot."""
    return tuple(
        Job(
            name,
            ("{data}/robots", "--only", name, *more),
            tuple(f"{{data}}/robots/{file}" for file in recording.files),
            name in short,
        )
        for name, recording in RECORDINGS.items()
    )


def simulated(*arguments: str, short: tuple[str, ...] | bool = False) -> tuple[Job, ...]:
    """A single job on drives that are simulated."""
    return (Job("all", arguments, (), short),)


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
        jobs.append(Job(job, words, files))
    return tuple(jobs)


def of_salient(twelve: tuple[Job, ...]) -> tuple[Job, ...]:
    """The parts of salient.py; its windows are those of the gentle drives together."""
    lines = "{checkout}/test/python/pipe_lines.npz"
    names = tuple(job.data[0] for job in twelve)
    return (
        Job("apexes", ("apexes",), (lines,), True, "apexes"),
        Job("drives", ("drives",), (), prefix="drives"),
        Job("windows", ("windows", *names), names, prefix="windows"),
    )


def of_grounds() -> tuple[Job, ...]:
    """pair_distance.py on each ground."""
    jobs = []
    for ground in ("fdtd", "beach", "field"):
        words = ("{data}/real_ground", f"--ground={ground}", "-j1", "--drives=20")
        short = ground == "fdtd" and (*words[:-1], "--drives=1", "--case=centre")
        jobs.append(Job(ground, words, ("{data}/real_ground",), short))
    return tuple(jobs)


def sequence(data: Path, number: int) -> str:
    """One of the twelve."""
    paths = sorted((data / "cmu_like").glob("*.zip"))
    return f"{{data}}/cmu_like/{paths[number].name}" if len(paths) > number else "{data}/cmu_like"


def with_sequences(jobs: tuple[Job, ...], *before: str, short: Sequence[int] = ()) -> list[Job]:
    """The same jobs, of a program that takes a sequence, with these arguments."""
    return [
        replace(job, arguments=(*before, job.data[0]), short=i in short)
        for i, job in enumerate(jobs)
    ]
