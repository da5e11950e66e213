"""``gprodom ground``: survey lines of a scene by FDTD."""

import argparse

import numpy as np

from gprodom.console import Progress, add_json_flag, tell
from gprodom.ground.scene import read_scene
from gprodom.ground.survey import Survey, to_counts, write_survey
from gprodom.options import Subparsers, add_command

DESCRIPTION = """\
Simulates the survey lines of a scene (config/scenes/*.yaml) by full-wave 2-D FDTD with gprMax, with
one model for each trace, and writes them as a compressed npz of int16 for `gprodom simulate
--ground`. Needs the extra `fdtd` of the package. A trace takes about a second on one core, so a
scene of two lines of 10 m at 2 cm takes about 20 minutes. The lines of garage, basement and floor,
which come with the package, were made by this command.

examples:
  gprodom ground config/scenes/basement.yaml -o basement.npz
  gprodom simulate --ground basement.npz --seed 3 -o 1700000000-0-cellar-cmu-gpr.zip
"""


def add_parser(subparsers: Subparsers) -> None:
    """Adds ``ground``."""
    parser = add_command(subparsers, "ground", "survey lines of a scene by FDTD", DESCRIPTION, run)
    parser.operand("scene", "SCENE", "YAML file")
    parser.output("FILE", "npz")
    add_json_flag(parser)


def run(args: argparse.Namespace) -> int:
    """Simulates and writes."""
    from gprodom.ground.fdtd import cells_per_wavelength, simulate_lines, source_delay

    scene = read_scene(args.scene)
    with Progress(scene.name, scene.traces * len(scene.aside)) as progress:
        volts = simulate_lines(scene, progress.advance)
    survey = Survey(
        scene.name,
        to_counts(volts),
        scene.spacing,
        np.array(scene.aside),
        scene.sample_interval,
        source_delay(scene),
    )
    write_survey(args.output, survey)
    facts = {
        "lines": len(scene.aside),
        "traces": scene.traces,
        "length_m": survey.length,
        "cells_per_wavelength": float(cells_per_wavelength(scene)),
        "bytes": args.output.stat().st_size,
    }
    text = (
        f"{args.output}: {facts['lines']} lines of {scene.traces} traces, "
        f"{survey.length:g} m; {facts['cells_per_wavelength']:.1f} cells a wavelength at "
        f"{2e-9 * scene.antenna.frequency:g} GHz in the slowest layer"
    )
    tell(args.json, facts, text)
    return 0
