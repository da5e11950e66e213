"""Figures of benches whose rows are not figures themselves."""

from __future__ import annotations

from collections.abc import Iterator
from statistics import fmean, median, pstdev
from typing import Any

from figures import (
    COUNT,
    ERROR_M,
    NEES,
    RATIO,
    SECONDS,
    SHARE,
    TIME_SPREAD,
    Better,
    Figure,
    Unit,
    by_row,
)

SOLVERS = {
    "max_m": ERROR_M,
    "covariance": RATIO,
    "ceres_ms": Unit("ms", "lower", TIME_SPREAD),
    "chain_ms": Unit("ms", "lower", TIME_SPREAD),
    "ceres_x": Unit("", "higher", TIME_SPREAD),
    "chain_x": Unit("", "higher", TIME_SPREAD),
}


def short_name(sequence: str) -> str:
    """Of a sequence: the number that its name begins with."""
    return sequence.split("-")[0]


def mean(name: str, values: list[float], unit: str, better: Better) -> Figure:
    """Of drives that were drawn: the spread is that of the mean over other draws."""
    spread = pstdev(values) / (len(values) - 1) ** 0.5 if len(values) > 1 else None
    return Figure(name, fmean(values), unit, better, spread)


def motion(content: Any) -> Iterator[Figure]:
    """bench/motion.py, and with --cut."""
    for row in content:
        name = short_name(row["sequence"])
        for key, value in row["rmse"].items():
            yield Figure(f"{name}/{key}_m", value, "m", "lower")
        if "standing" not in row:
            continue
        for key in ("recall", "flagged"):
            yield Figure(f"{name}/standing_{key}", row["standing"][key], "", "higher")
        yield Figure(f"{name}/standing_false", row["standing"]["false"], "", "lower")
        yield Figure(f"{name}/episodes", row["episodes"], "", "")
        yield Figure(f"{name}/prompt", row["prompt"], "", "higher")
        yield Figure(f"{name}/false_flags", row["false_flags"], "", "lower")
        yield Figure(f"{name}/metres", row["metres"], "m", "")
        yield Figure(f"{name}/coherence_error", row["coherence_error"], "", "lower")


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
        yield Figure(f"{name}/runs", drives["runs"], "", "")
        yield Figure(f"{name}/rmse_m", drives["rmse_m"], "m", "lower")
        yield Figure(f"{name}/reckoned_m", drives["reckoned_m"], "m", "")


def yard(content: Any) -> Iterator[Figure]:
    """bench/yard.py: by day, or by piece."""
    units = {
        "rounds": COUNT,
        "nees_xy": NEES,
        "nees_yaw": Unit("", ""),
        "rmse_m": ERROR_M,
        "rmse_in_map_m": ERROR_M,
        "restarts": COUNT,
    }
    yield from by_row(lambda row: str(row["day"]), units)(content["days"])
    for what in ("cost", "memory", "map"):
        name = f"{what}_last_over_second"
        if name in content:
            yield Figure(name, content[name], "", "lower")


def faults(content: Any) -> Iterator[Figure]:
    """bench/faults."""
    for row in content:
        name = row["fault"].replace("/", " ")
        if "error_ratio" in row:
            yield Figure(f"{name}/error_ratio", row["error_ratio"], "", "lower")
        yield Figure(f"{name}/silent_s", row["silent_s"], "s", "lower")
        yield Figure(f"{name}/wrong", row["wrong"], "", "lower")


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
        if group == "differences":
            continue
        for column, values in columns.items():
            for key, value in values.items():
                yield Figure(f"{group}/{column}/{key}", value, "", "")


def lateral(content: Any) -> Iterator[Figure]:
    """bench/lateral.py: the ground, of which nothing is better."""
    for row in content["rows"]:
        for key in ("aside", "along"):
            yield Figure(f"{row['m']:.1f} m/{key}", row[key], "", "")
    for key in ("along_curvature_m", "stretch", "lateral_m"):
        yield Figure(key, content[key], "", "")


VISIT = {
    "right": Unit("", "higher"),
    "right_within_20_m": Unit("", "higher"),
    "runs": COUNT,
    "number": COUNT,
    "located": COUNT,
    "false": Unit("", "lower"),
    "false_on_known_ground": Unit("", "lower"),
    "false_on_unknown_ground": Unit("", "lower"),
    "strangers": COUNT,
    "false_on_strangers": Unit("", "lower"),
    "located_after_m": ERROR_M,
    "located_after_m_median": ERROR_M,
    "end_m_rms": ERROR_M,
    "along_cm_rms": Unit("cm", "lower"),
}
PERCENT, MM = Unit("%", "lower"), Unit("mm", "lower")
PAIR = {
    "drives": COUNT,
    "passages": Unit("", "higher"),
    "rms_percent": PERCENT,
    "limit_percent": Unit("%", ""),
    "match_mm": MM,
    "limit_mm": Unit("mm", ""),
    "nees": Unit("", ""),
    "wrong": Unit("", "lower"),
}
PAIR_FAULT = {
    "metres": COUNT,
    "passages": Unit("", "higher"),
    "wrong": Unit("", "lower"),
    "match_mm": MM,
    "back_after_s": SECONDS,
}
MAP = {
    "runs": COUNT,
    "coverage_end": SHARE,
    "coverage_all": SHARE,
    "nees_end_mean": NEES,
    "end_m_rms": ERROR_M,
    "moved_m_max": ERROR_M,
}
START = {
    "start_s": SECONDS,
    "normal_m": ERROR_M,
    "causal_m": ERROR_M,
    "normal_smoothed_m": ERROR_M,
    "smoothed_m": ERROR_M,
    "nees_xy": NEES,
}


def days(content: Any) -> Iterator[Figure]:
    """bench/days.py."""
    located = [day for day in content if day["located_after_m"] is not None]
    yield Figure("drives", len(content), "", "")
    yield Figure("located", len(located), "", "")
    for day in located:
        name = short_name(day["sequence"])
        yield from by_row(lambda _, name=name: name, DAY)([day])


def merge(content: Any) -> Iterator[Figure]:
    """bench/merge.py."""
    for row in content:
        name = f"{row['change_percent']:g} %"
        yield Figure(f"{name}/runs", row["runs"], "", "")
        yield Figure(f"{name}/proven", row["proven"], "", "higher")
        yield Figure(f"{name}/strangers_joined", row["strangers_joined"], "", "lower")
        if row["proven"] == 0:  # nothing was joined
            continue
        yield Figure(f"{name}/before_m", fmean(row["before_m"]), "m", "")
        yield Figure(f"{name}/after_m", fmean(row["after_m"]), "m", "lower")
        yield Figure(f"{name}/nees_after", fmean(row["nees_after"]), "", "near 2")


def changed_ground(content: Any) -> Iterator[Figure]:
    """bench/changed_ground.py."""
    yield from by_row(lambda row: f"{row['change_percent']:g} %", VISIT)(content["figures"])


def salient(content: Any) -> Iterator[Figure]:
    """bench/salient.py, its three parts; errors of apexes by their size."""
    for row in content:
        where = (
            (row["clutter"], row["pipe"]) if "clutter" in row else (str(row.get("seed", "all")),)
        )
        sizes = {key: abs(row[key]) for key in ("off_m", "depth_error") if key in row}
        name = "/".join(where)
        yield from by_row(lambda _, name=name: name, SALIENT)([row | sizes])


def doctor(content: Any) -> Iterator[Figure]:
    """bench/doctor.py."""
    values = {
        "recordings": COUNT,
        "found_in_good": Unit("", "lower"),
        "named": SHARE,
        "tried": COUNT,
    }
    yield from by_row(lambda _: "", values)([content])
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
    values = {"shown": COUNT, "rms": Unit("", "lower"), "largest": Unit("", "lower")}
    yield from by_row(lambda row: str(row["constant"]), values)(content["constants"])


def radar_time_offset(content: Any) -> Iterator[Figure]:
    """bench/radar_time_offset.py; s."""
    values = {"mean_s": COUNT, "rms_s": SECONDS, "worst_s": SECONDS, "told_s": COUNT}
    for row in content["rows"]:
        name = f"{row['ground']}/{1e3 * row['late_s']:.0f} ms"
        yield from by_row(lambda _, name=name: name, values)([row])


DRIVE = by_row(
    lambda row: f"{row['sequence'].split('-')[0]}/{row['method']}",
    {
        "dead_m": ERROR_M,
        "causal_m": ERROR_M,
        "smoothed_m": ERROR_M,
        "nees_odom": NEES,
        "nees_map": NEES,
    },
)
ROBOT = {
    "wheel_m": ERROR_M,
    "causal_m": ERROR_M,
    "smoothed_m": ERROR_M,
    "ratio": RATIO,
    "over": RATIO,
    "smoothed_over": RATIO,
    "nees_xy": NEES,
    "start_s": SECONDS,
    "jump_m": ERROR_M,
    "distance_m": Unit("m", ""),
    "wheel_distance_m": Unit("m", ""),
    "causal_distance_m": Unit("m", ""),
    "failed": COUNT,
}
METHOD = by_row(
    lambda row: f"{row['method']}/{row['mode']}/{row['sequence'].rsplit('-cmu-gpr', 1)[0]}",
    {"ate_rmse_m": ERROR_M, "nees_xy": NEES},
)
NANOSECONDS = Unit("ns", "lower")
FDTD = {
    "direct_wave_ns": NANOSECONDS,
    "pipe_ns": NANOSECONDS,
    "pipe_from_above_ns": NANOSECONDS,
    "layer_ns": NANOSECONDS,
    "attenuation_pct": Unit("%", "lower"),
}
REVISIT = {
    "told": SHARE,
    "right_told": SHARE,
    "rms_cm": Unit("cm", "lower"),
    "false": Unit("", "lower"),
    "negatives": COUNT,
}


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


SALIENT = {
    "found": SHARE,
    "off_m": ERROR_M,
    "depth_error": RATIO,
    "permittivity_ratio": COUNT,
    "others_per_m": COUNT,
    "wheel_m": Unit("m", ""),
    "imu_wheel_m": ERROR_M,
    "salient_m": ERROR_M,
    "salient_answered": SHARE,
    "salient_s": Unit("s", "lower", TIME_SPREAD),
    "salient_pipes_m": ERROR_M,
    "salient_pipes_answered": SHARE,
    "salient_pipes_s": Unit("s", "lower", TIME_SPREAD),
    "crossings": COUNT,
    "answered": SHARE,
    "answers": COUNT,
    "revisits": COUNT,
    "wrong": Unit("", "lower"),
    "rms_m": ERROR_M,
    "windows": COUNT,
    "commonest_shift": COUNT,
    "commonest_share": COUNT,
    "correlation": COUNT,
    "correlation_size": COUNT,
    "residual_rms_m": ERROR_M,
    "constant_rms_m": Unit("m", ""),
}
DAY = {
    "located_after_m": ERROR_M,
    "with_map_m": ERROR_M,
    "without_m": Unit("m", ""),
    "nees_xy": NEES,
}
FOUND = {
    "se2_c": ERROR_M,
    "se2_s": ERROR_M,
    "revisits": COUNT,
    "wrong": Unit("", "lower"),
    "rms_cm": Unit("cm", "lower"),
    "rms_sigma": RATIO,
    "scale_error": COUNT,
}
