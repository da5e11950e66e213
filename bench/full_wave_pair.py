#!/usr/bin/env python3
"""Full waves as a spot check: one line of a scene, and the same line when permittivity has changed.

Makes both lines by FDTD (gprMax, the extra `fdtd`), on the first one a map, and drives on the
second one with it. Every layer's permittivity changes by the percentage or by half as much, drawn
for each layer; the antenna has another pulse and runs 3 cm aside. A trace takes seconds, so the
pair of 65 m takes hours: --estimate makes a few traces and says how many. The lines are kept
(--keep) and used again.

    bench/full_wave_pair.py --estimate
    bench/full_wave_pair.py --change 10 --keep lines.npz --json
"""

from __future__ import annotations

import argparse
import os
import sys
import tempfile
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from gprodom.console import Progress, add_json_flag, format_table, print_json
from gprodom.files import write_npz
from gprodom.ground.fdtd import simulate_line
from gprodom.ground.materials import sections
from gprodom.ground.scene import Scene, read_scene
from gprodom.ground.survey import to_counts
from gprodom.simulate import stream
from real_another_day import Line, save_map, visit

SCENE = Path(__file__).resolve().parents[1] / "config" / "scenes" / "basement.yaml"
ASIDE = 0.03  # m
PULSE = 0.95  # of the frequency
TRIED = 4  # traces, for the estimate


def another_day(scene: Scene, percent: float) -> Scene:
    """The same ground, wetter or drier, and another antenna."""
    share = stream(scene.seed, f"full waves {percent}").uniform(0.5, 1.0, len(scene.layers))
    layers = tuple(
        replace(layer, permittivity=layer.permittivity * (1 + 0.01 * percent * part))
        for layer, part in zip(scene.layers, share, strict=True)
    )
    antenna = replace(scene.antenna, frequency=PULSE * scene.antenna.frequency)
    return replace(scene, layers=layers, antenna=antenna)


def longer(scene: Scene, metres: float) -> Scene:
    """The scene with both lines of that length, and stones as dense as they were."""
    stones = tuple(
        replace(one, number=round(one.number * metres / scene.length)) for one in scene.stones
    )
    return replace(scene, length=metres, aside=(0.0, ASIDE), stones=stones)


def processor_time() -> float:
    """Of this process and those it has waited for, s."""
    return sum(os.times()[:4])


def hours(scene: Scene) -> float:
    """Of one processor that both lines take, by a few traces."""
    section = sections(scene, scene.window[1])[0]
    begin = processor_time()
    simulate_line(scene, section, np.arange(TRIED) * scene.spacing)
    return 2 * scene.traces * (processor_time() - begin) / TRIED / 3600


def made(scene: Scene, percent: float, keep: Path | None) -> tuple[Line, Line]:
    """The line of one day, and the line beside it of the other; from the file if there is one."""
    if keep and keep.is_file():
        with np.load(keep) as data:
            lines = data["lines"].astype(float)
    else:
        places = np.arange(scene.traces) * scene.spacing
        with Progress(scene.name, 2 * scene.traces) as progress:
            lines = np.array([
                to_counts(
                    simulate_line(
                        day, sections(day, day.window[1])[number], places, progress.advance
                    )
                )
                for number, day in enumerate((scene, another_day(scene, percent)))
            ])  # fmt: skip
        if keep:
            write_npz(keep, {"lines": lines})
    first, second = (Line(one.astype(float), scene.spacing, scene.sample_interval) for one in lines)
    return first, second


def main() -> int:
    """Runs the command line."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--scene", type=Path, default=SCENE, help="default: %(default)s")
    parser.add_argument("--metres", type=float, default=65.0, help="default: %(default)s")
    parser.add_argument("--change", type=float, default=10.0, metavar="PERCENT", help="(10)")
    parser.add_argument("--keep", type=Path, metavar="NPZ", help="file of both lines")
    parser.add_argument("--estimate", action="store_true", help="only say how long it takes")
    add_json_flag(parser)
    args = parser.parse_args()
    scene = longer(read_scene(args.scene), args.metres)
    if args.estimate:
        figures: dict[str, Any] = {"traces": 2 * scene.traces, "processor_hours": hours(scene)}
    else:
        first, second = made(scene, args.change, args.keep)
        with tempfile.TemporaryDirectory() as folder:
            known = save_map(first, 1, Path(folder) / "line.map")
            found = visit(second, False, 2, known)
        along = np.array(found.along_m)
        figures = {
            "change_percent": args.change,
            "right": found.right,
            "located_after_m": found.located_after_m,
            "end_m": found.end_m if found.located_after_m is not None else None,
            "along_cm_rms": 100 * float(np.sqrt(np.mean(along**2))) if len(along) else None,
        }
    if args.json:
        print_json(figures)
    else:
        print(format_table(["figure", "value"], [list(item) for item in figures.items()]))
    return 0


if __name__ == "__main__":
    sys.exit(main())
