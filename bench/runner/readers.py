"""Figures of what benches print, with their units."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from statistics import fmean, median, pstdev
from typing import Any

from figures import (
    COUNT,
    ERROR_M,
    FEWER,
    METRES,
    MORE,
    NEES,
    SECONDS,
    TIME_SPREAD,
    Better,
    Figure,
    Unit,
    by_row,
    each,
    of_row,
)

PERCENT, MM, CM = Unit("%", "lower"), Unit("mm", "lower"), Unit("cm", "lower")
TIME_S, TIME_MS = Unit("s", "lower", TIME_SPREAD), Unit("ms", "lower", TIME_SPREAD)
TIMES = Unit("", "higher", TIME_SPREAD)  # of real time


def short_name(sequence: str) -> str:
    """Of a sequence: the number that its name begins with."""
    return sequence.split("-")[0]


# ---- units by key ----

DRIVE = by_row(
    lambda row: f"{short_name(row['sequence'])}/{row['method']}",
    each(ERROR_M, "dead_m", "causal_m", "smoothed_m") | each(NEES, "nees_odom", "nees_map"),
)
ROBOT = {
    **each(ERROR_M, "wheel_m", "causal_m", "smoothed_m"),
    **each(FEWER, "ratio", "over", "smoothed_over"),
    "nees_xy": NEES,
    "start_s": SECONDS,
    "jump_m": ERROR_M,
    **each(METRES, "distance_m", "wheel_distance_m", "causal_distance_m"),
}
METHOD = by_row(
    lambda row: f"{row['method']}/{row['mode']}/{row['sequence'].rsplit('-cmu-gpr', 1)[0]}",
    {"ate_rmse_m": ERROR_M, "nees_xy": NEES},
)
START = {
    "start_s": SECONDS,
    **each(ERROR_M, "normal_m", "causal_m", "normal_smoothed_m", "smoothed_m"),
    "nees_xy": NEES,
}
MOTION = {
    **each(MORE, "standing_recall", "standing_flagged"),
    "standing_false": FEWER,
    "episodes": COUNT,
    "prompt": MORE,
    "false_flags": FEWER,
    "metres": METRES,
    "coherence_error": FEWER,
}
MOUNTING = {"over": FEWER, "right_m": ERROR_M, "auto_m": ERROR_M, "known_s": SECONDS}
TRIGGER = {"error_m": ERROR_M, "without_m": METRES, "revisits": COUNT}
SALIENT = {
    "found": MORE,
    "off_m": ERROR_M,
    "depth_error": FEWER,
    **each(COUNT, "permittivity_ratio", "others_per_m"),
    "wheel_m": METRES,
    "imu_wheel_m": ERROR_M,
    "salient_m": ERROR_M,
    "salient_answered": MORE,
    "salient_s": TIME_S,
    "salient_pipes_m": ERROR_M,
    "salient_pipes_answered": MORE,
    "salient_pipes_s": TIME_S,
    "crossings": COUNT,
    "answered": MORE,
    **each(COUNT, "answers", "revisits"),
    "wrong": FEWER,
    "rms_m": ERROR_M,
    **each(COUNT, "windows", "commonest_shift", "commonest_share"),
    **each(COUNT, "correlation", "correlation_size"),
    "residual_rms_m": ERROR_M,
    "constant_rms_m": METRES,
}
PAIR = {
    "drives": COUNT,
    "passages": MORE,
    "rms_percent": PERCENT,
    "limit_percent": Unit("%", ""),
    "match_mm": MM,
    "limit_mm": Unit("mm", ""),
    "nees": COUNT,
    "wrong": FEWER,
}
PAIR_FAULT = {
    "metres": COUNT,
    "passages": MORE,
    "wrong": FEWER,
    "match_mm": MM,
    "back_after_s": SECONDS,
}
FOUND = {
    **each(ERROR_M, "se2_c", "se2_s"),
    "revisits": COUNT,
    "wrong": FEWER,
    "rms_cm": CM,
    "rms_sigma": FEWER,
    "scale_error": COUNT,
}
MAP = {
    "runs": COUNT,
    "coverage_end": MORE,
    "coverage_all": MORE,
    "nees_end_mean": NEES,
    **each(ERROR_M, "end_m_rms", "moved_m_max"),
}
YARD = {
    "rounds": COUNT,
    "nees_xy": NEES,
    "nees_yaw": COUNT,
    "rmse_m": ERROR_M,
    "rmse_in_map_m": ERROR_M,
    "restarts": COUNT,
}
VISIT = {
    **each(MORE, "right", "right_within_20_m"),
    **each(COUNT, "runs", "number", "located"),
    **each(FEWER, "false", "false_on_known_ground", "false_on_unknown_ground"),
    "strangers": COUNT,
    "false_on_strangers": FEWER,
    **each(ERROR_M, "located_after_m", "located_after_m_median", "end_m_rms"),
    "along_cm_rms": CM,
}
DAY = {**each(ERROR_M, "located_after_m", "with_map_m"), "without_m": METRES, "nees_xy": NEES}
REVISIT = {"told": MORE, "right_told": MORE, "rms_cm": CM, "false": FEWER, "negatives": COUNT}
WAVES = ("direct_wave_ns", "pipe_ns", "pipe_from_above_ns", "layer_ns")
FDTD = {**each(Unit("ns", "lower"), *WAVES), "attenuation_pct": PERCENT}
OFFSET = {"mean_s": COUNT, "rms_s": SECONDS, "worst_s": SECONDS, "told_s": COUNT}
KERNEL = {"us": Unit("us", "lower", "spread_us")}
REPLAY = {"times_real_time_cpu": TIMES, "solve_ms": TIME_MS}
VIEW = {
    "open_processor_s": TIME_S,
    "recording_mb": Unit("MB", "lower"),
    **each(Unit("%", "lower", TIME_SPREAD), "live_to_file_core_pct", "live_to_viewer_core_pct"),
}
PAGE = {**each(FEWER, "errors", "cut", "console"), "contrast": MORE, "sheets": FEWER}
SOLVERS = {
    "max_m": ERROR_M,
    "covariance": FEWER,
    **each(TIME_MS, "ceres_ms", "chain_ms"),
    **each(TIMES, "ceres_x", "chain_x"),
}


# ---- benches whose rows are not figures themselves ----


def mean(name: str, values: list[float], unit: str, better: Better) -> Figure:
    """Of drives that were drawn: the spread is that of the mean over other draws."""
    spread = pstdev(values) / (len(values) - 1) ** 0.5 if len(values) > 1 else None
    return Figure(name, fmean(values), unit, better, spread)


def as_told(name: str, row: Mapping[str, Any], values: Mapping[str, Unit]) -> Iterator[Figure]:
    """NAME/KEY for each of `values`, counts as whole numbers."""
    for key, unit in values.items():
        yield Figure(f"{name}/{key}" if name else key, row[key], unit.unit, unit.better)


def motion(content: Any) -> Iterator[Figure]:
    """bench/motion.py, and with --cut."""
    for row in content:
        name = short_name(row["sequence"])
        errors = {f"{key}_m": value for key, value in row["rmse"].items()}
        yield from as_told(name, errors, each(ERROR_M, *errors))
        if "standing" in row:
            standing = {f"standing_{key}": value for key, value in row["standing"].items()}
            yield from as_told(name, row | standing, MOTION)


def immobilised(content: Any) -> Iterator[Figure]:
    """bench/immobilised.py."""
    cases = [case for drive in content for case in drive["cases"]]
    if cases:
        late = [case["late_s"] for case in cases if case["late_s"] is not None]
        yield Figure("cases", len(cases), "", "")
        yield Figure("in_time", sum(case["in_time"] for case in cases), "", "higher")
        yield Figure("late_median_s", median(late) if late else None, "s", "lower")
        yield mean("moved_m", [case["moved_m"] for case in cases], "m", "lower")
    yield Figure("km", sum(drive["km"] for drive in content), "km", "")
    alarms = sum(len(drive["false_alarms"]) for drive in content)
    yield Figure("false_alarms", alarms, "", "lower", alarms**0.5 or 1.0)  # Poisson


def consistency(content: Any) -> Iterator[Figure]:
    """bench/consistency.py: a NEES whose band holds 99 % of such means has its spread from that."""
    for name, drives in content.items():
        for key, width in (("nees_xy", 2), ("nees_yaw", 1)):
            value = drives[key]["mean"]
            spread = value * (2 / (width * drives["runs"])) ** 0.5
            better: Better = "near 2" if width == 2 else ""
            yield Figure(f"{name}/{key}", value, "", better, spread)
        yield from as_told(name, drives, {"runs": COUNT, "rmse_m": ERROR_M, "reckoned_m": METRES})


def yard(content: Any) -> Iterator[Figure]:
    """bench/yard.py: by day, or by piece."""
    yield from by_row(lambda row: str(row["day"]), YARD)(content["days"])
    ratios = [f"{what}_last_over_second" for what in ("cost", "memory", "map")]
    yield from as_told("", content, each(FEWER, *(key for key in ratios if key in content)))


def faults(content: Any) -> Iterator[Figure]:
    """bench/faults."""
    units = {"error_ratio": FEWER, "silent_s": SECONDS, "wrong": FEWER}
    for row in content:
        there = {key: unit for key, unit in units.items() if key in row}
        yield from as_told(row["fault"].replace("/", " "), row, there)


def live(content: Any) -> Iterator[Figure]:
    """bench/live_load.py, ros2_live.py: times of one run, on a machine whose host takes what it
    wants."""
    for key, value in content.items():
        if key in ("lost", "poses_missing"):
            yield Figure(key, value, "", "lower")
        elif key == "memory_mb":
            yield Figure(key, value, "MB", "lower", 0.05 * value)
        elif key == "core_percent":
            yield Figure(key, value, "%", "lower", 0.15 * value)
        elif key.endswith("_ms") and isinstance(value, (int, float)):
            yield Figure(key, value, "ms", "lower", 0.3 * value)


def smoothers(content: Any) -> Iterator[Figure]:
    """bench/smoothers.py: processor time of an update, and error."""
    for label, times in content["times_s"].items():
        for key in ("median", "p99"):
            value = 1e3 * times["cpu"][key]
            yield Figure(f"{label}/{key}_ms", value, "ms", "lower", 0.15 * value)
    for label, value in content["error_m"].items():
        yield Figure(f"{label}/error_m", value, "m", "lower")


def realism(content: Any) -> Iterator[Figure]:
    """bench/realism.py: figures of made and of real data, none of which is better."""
    for group, columns in content.items():
        for column, values in columns.items():
            yield from as_told(f"{group}/{column}", values, each(COUNT, *values))


def lateral(content: Any) -> Iterator[Figure]:
    """bench/lateral.py: the ground, of which nothing is better."""
    for row in content["rows"]:
        yield from as_told(f"{row['m']:.1f} m", row, each(COUNT, "aside", "along"))
    yield from as_told("", content, each(COUNT, "along_curvature_m", "stretch", "lateral_m"))


def days(content: Any) -> Iterator[Figure]:
    """bench/days.py."""
    located = [day for day in content if day["located_after_m"] is not None]
    yield Figure("drives", len(content), "", "")
    yield Figure("located", len(located), "", "")
    yield from by_row(lambda day: short_name(day["sequence"]), DAY)(located)


def merge(content: Any) -> Iterator[Figure]:
    """bench/merge.py."""
    for row in content:
        name = f"{row['change_percent']:g} %"
        counts = {"runs": COUNT, "proven": MORE, "strangers_joined": FEWER}
        yield from as_told(name, row, counts)
        if row["proven"] > 0:  # else nothing was joined
            units = {"before_m": METRES, "after_m": ERROR_M, "nees_after": NEES}
            yield from as_told(name, {key: fmean(row[key]) for key in units}, units)


def changed_ground(content: Any) -> Iterator[Figure]:
    """bench/changed_ground.py."""
    yield from by_row(lambda row: f"{row['change_percent']:g} %", VISIT)(content["figures"])


def salient(content: Any) -> Iterator[Figure]:
    """bench/salient.py, its three parts; errors of apexes by their size."""
    for row in content:
        apex = "clutter" in row
        name = f"{row['clutter']}/{row['pipe']}" if apex else str(row.get("seed", "all"))
        sizes = {key: abs(row[key]) for key in ("off_m", "depth_error") if key in row}
        yield from of_row(name, row | sizes, SALIENT)


def doctor(content: Any) -> Iterator[Figure]:
    """bench/doctor.py."""
    values = {"recordings": COUNT, "found_in_good": FEWER, "named": MORE, "tried": COUNT}
    yield from of_row("", content, values)
    yield from by_row(lambda row: str(row["damage"]), values)(
        {**row, "named": row["named"] / row["tried"]} for row in content["kinds"] if row["tried"]
    )


def commission(content: Any) -> Iterator[Figure]:
    """bench/commission.py: errors in standard deviations, and the estimate after it."""
    measured = [row for row in content["robots"] if row.get("over") is not None]
    yield Figure("robots", len(content["robots"]), "", "")
    yield Figure("allowed", fmean(row["allowed"] for row in measured), "", "higher")
    yield mean("over", [row["over"] for row in measured], "", "lower")
    seconds = [row["seconds"] for row in content["robots"] if "seconds" in row]
    yield Figure("seconds", median(seconds), "s", "lower", TIME_SPREAD)
    values = {"shown": COUNT, "rms": FEWER, "largest": FEWER}
    yield from by_row(lambda row: str(row["constant"]), values)(content["constants"])


def radar_time_offset(content: Any) -> Iterator[Figure]:
    """bench/radar_time_offset.py; s."""
    read = by_row(lambda row: f"{row['ground']}/{1e3 * row['late_s']:.0f} ms", OFFSET)
    yield from read(content["rows"])


def process_faults(content: Any) -> Iterator[Figure]:
    """bench/process_faults.py."""
    yield Figure("faults", len(content["runs"]), "", "")
    yield Figure("wrong", len(content["wrong"]), "", "lower")
    for run in content["runs"]:
        if "killed" in run["fault"]:
            yield Figure("killed/pose_after_s", run["pose_after_s"], "s", "lower", 0.2)


def hostile_packets(content: Any) -> Iterator[Figure]:
    """bench/hostile_packets.py."""
    yield Figure("packets", content["packets"], "", "")
    yield Figure("wrong", len(content["wrong"]), "", "lower")
    yield Figure("apart_m", content["apart_m"], "m", "lower")
    yield Figure("memory_end_mb", content["memory_end_mb"], "MB", "lower", 1.0)
