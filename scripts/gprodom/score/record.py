"""A score as it is printed, written and read back: one flat record."""

import re
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

from gprodom.console import format_table
from gprodom.score.align import Alignment
from gprodom.score.answered import Answered
from gprodom.score.figures import Figures
from gprodom.score.frames import FrameStart
from gprodom.score.jumps import MapJumps

Mode = str  # causal: as published, never rewritten; smoothed: the final solution


@dataclass(frozen=True)
class Run:
    """What a score is of."""

    sequence: str
    scene: str
    method: str
    mode: Mode
    align: Alignment


@dataclass(frozen=True)
class Record(Figures, Run):  # in this order the fields of `Run` come first
    """One row of results. The fields are the columns of results.csv and the keys of --json.


    Figures as in `figures.Figures`; None (an empty cell, JSON null) if the data do not give them.
    map_jumps, map_jump_mean_m, map_jump_max_m: corrections that moved the published pose in `map`,
    None without a log.
    answered, revisits: share of the published time in which the radar told the motion, and the
    number of revisits told; None where no method was run, or it has no radar.
    before_m: metres driven in other frames than the one that is scored (`frames`); None: in none.
    """

    map_jumps: int | None = None
    map_jump_mean_m: float | None = None
    map_jump_max_m: float | None = None
    answered: float | None = None
    revisits: int | None = None
    before_m: float | None = None

    def as_dict(self) -> dict[str, Any]:
        """By column name."""
        return {field.name: getattr(self, field.name) for field in fields(self)}


COLUMNS = tuple(field.name for field in fields(Record))


def make_record(
    sequence: str,
    method: str,
    mode: Mode,
    align: Alignment,
    figures: Figures,
    jumps: MapJumps | None = None,
    told: Answered | None = None,
    frame: FrameStart | None = None,
) -> Record:
    """The record of one comparison; the scene comes from the sequence's name."""
    return Record(
        sequence=sequence,
        scene=scene_of(sequence),
        method=method,
        mode=mode,
        align=align,
        **vars(figures),
        map_jumps=jumps.count if jumps else None,
        map_jump_mean_m=jumps.mean_m if jumps else None,
        map_jump_max_m=jumps.max_m if jumps else None,
        answered=told.share if told else None,
        revisits=told.revisits if told else None,
        before_m=frame.driven_m if frame else None,
    )


def sequence_name(path: Path) -> str:
    """The sequence's name: that of its folder, zip or log; of the folder for a bare ts_meas.csv."""
    path = path.resolve()
    if path.suffix == ".csv":
        return path.parent.name
    return path.name if path.is_dir() else re.sub(r"\.(zip|lcmlog|lcm|log|tum|txt)$", "", path.name)


def scene_of(sequence: str) -> str:
    """Scene of a CMU-GPR name, TIME-0-LOC-cmu-gpr → LOC; the empty string where it is none."""
    found = re.match(r"\d+-\d+-(.+?)-cmu-gpr", sequence)
    return found.group(1) if found else ""


def describe(record: Record) -> str:
    """One score as a table of figure and value."""
    shown: list[list[object]] = [
        ["ate_rmse_m", record.ate_rmse_m],
        ["rpe_1m_m", record.rpe_1m_m],
        ["end_m", record.end_m],
        ["distance_pct (end_m of the distance)", record.distance_pct],
        ["nees_xy (2 is right)", record.nees_xy],
        ["nees_yaw (1 is right)", record.nees_yaw],
        ["n (points compared)", record.n],
        ["excluded (truth without estimate)", record.excluded],
        ["excluded_s", record.excluded_s],
        ["excluded_m (that the truth travels then)", record.excluded_m],
        ["distance_m (of the truth)", record.distance_m],
    ]
    if record.before_m is not None:
        shown.append(["before_m (driven in another frame, left out)", record.before_m])
    if record.map_jumps is not None:
        shown += [
            ["map_jumps", record.map_jumps],
            ["map_jump_mean_m", record.map_jump_mean_m],
            ["map_jump_max_m", record.map_jump_max_m],
        ]
    if record.answered is not None:
        shown += [
            ["answered (share of the time)", record.answered],
            ["revisits (told)", record.revisits],
        ]
    return format_table([f"aligned: {record.align}", "value"], shown)
