#!/usr/bin/env python3
"""The speed of everything in one table, and plots: report.md, report.json and pictures in a folder.

Runs the google-benchmark programs (each kernel, a state's update against the lag), the estimator on
a log driven again and again (bench/soak.cpp: cost and memory against the length of the run, and
bytes a metre of the trace memory), replays (replay_speed.py), and the daemon live (live_load.py:
idle, with two processes computing beside it, and at ten times the message rates). What a machine
does besides shows: times are told as they were. Some ten minutes with the defaults.

    bench/report.py SEQ.lcmlog -o out/speed
    bench/report.py SEQ.lcmlog -o out/speed --hours 10 --live 900     # a soak
    bench/report.py SEQ.lcmlog -o out/speed --parts kernels,length
"""

from __future__ import annotations

import argparse
import csv
import json
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import gprodom
from gprodom import canvas
from gprodom.console import format_table
from gprodom.errors import Error, UsageError

HERE = Path(__file__).resolve().parent
KERNELS = ("message", "gpr_filter", "gpr_peaks", "gpr_sfm", "gpr_revisit", "estimation", "map")
RUNS = {"gprodom": ["graph.enabled=false"], "gprodom_full": []}
LIVE: dict[str, list[str]] = {
    "live": [],
    "live, both cores loaded": ["--busy", "2"],
    "live, ten times the rates": ["--speed", "10", "--max-core", "100"],
}
TO_MICROSECONDS = {"ns": 1e-3, "us": 1.0, "ms": 1e3, "s": 1e6}

Row = list[object]


def told(command: list[str], fine: tuple[int, ...] = (0,)) -> str:
    """What a program prints. `fine`: exit codes that are none of ours to judge."""
    done = subprocess.run(command, stdout=subprocess.PIPE, text=True)
    if done.returncode not in fine:
        raise Error(f"{' '.join(command)}: exit code {done.returncode}")
    return done.stdout


def kernels(args: argparse.Namespace) -> dict[str, Any]:
    """Microseconds of processor time by benchmark."""
    found = {}
    for name in KERNELS:
        program = args.build / "bench" / f"bench_{name}"
        print(program.name, file=sys.stderr, flush=True)
        command = [str(program), "--benchmark_format=json", f"--benchmark_min_time={args.min_time}"]
        for each in json.loads(told(command))["benchmarks"]:
            unit = TO_MICROSECONDS[each["time_unit"]]
            found[f"{name}: {each['name']}"] = each["cpu_time"] * unit
    return found


def length(args: argparse.Namespace) -> dict[str, Any]:
    """Cost and memory along a long run, with and without the memory of ground."""
    found = {}
    for name, keys in RUNS.items():
        out = args.output / f"{name}.csv"
        program = str(args.build / "bench" / "bench_soak")
        told([program, str(args.log), str(args.hours), str(out), *keys])
        with out.open(encoding="utf-8") as file:
            rows = [{k: float(v) for k, v in row.items()} for row in csv.DictReader(file)]
        early = next(row for row in rows if row["hours"] >= min(1 / 6, args.hours / 3))
        last = rows[-1]
        late = rows[-max(1, len(rows) // 5) :]  # a row is a minute: the mean of some
        soon = [row for row in rows if early["hours"] <= row["hours"] <= 2 * early["hours"]]
        metres = last["distance_m"] - early["distance_m"]
        found[name] = {
            "hours": last["hours"],
            "cost_early": mean(soon, "cpu_per_s"),
            "cost_late": mean(late, "cpu_per_s"),
            # In yardsticks, which what else the machine does makes longer alike.
            "growth": in_yardsticks(late) / in_yardsticks(soon) - 1,
            "solve_ms_early": mean(soon, "solve_ms"),
            "solve_ms_late": mean(late, "solve_ms"),
            "resident_early_mb": early["resident_bytes"] / 1e6,
            "resident_late_mb": last["resident_bytes"] / 1e6,
            "bytes_per_metre": (last["resident_bytes"] - early["resident_bytes"]) / max(metres, 1),
            "metres": last["distance_m"],
            "rows": rows,
        }
    return found


def in_yardsticks(rows: list[dict[str, float]]) -> float:
    """Cost of a second of data over that of the yardstick of bench/soak.cpp."""
    return mean(rows, "cpu_per_s") / mean(rows, "yardstick_us")


def mean(rows: list[dict[str, float]], key: str) -> float:
    """Of a column."""
    return sum(row[key] for row in rows) / len(rows)


def replays(args: argparse.Namespace) -> Any:
    """bench/replay_speed.py."""
    return json.loads(
        told([sys.executable, str(HERE / "replay_speed.py"), str(args.log), "--json"])
    )


def live(args: argparse.Namespace) -> dict[str, Any]:
    """bench/live_load.py, in each of its ways."""
    found = {}
    for name, options in LIVE.items():
        print(name, file=sys.stderr, flush=True)
        command = [sys.executable, str(HERE / "live_load.py"), str(args.log), "--json"]
        series = args.output / f"{name.replace(', ', '-').replace(' ', '-')}.csv"
        command += ["--seconds", str(args.live), "--series", str(series), *options]
        found[name] = json.loads(told(command, fine=(0, 1)))
    return found


def table(results: dict[str, Any]) -> list[Row]:
    """What, how much, of which unit."""
    rows: list[Row] = []
    for name, value in results.get("kernels", {}).items():
        rows.append([name, f"{value:.2f}", "us"])
    for name, run in results.get("length", {}).items():
        for key, unit in (
            ("cost", "ms of processor time a second of data"),
            ("solve_ms", "ms a solve"),
        ):
            factor = 1e3 if key == "cost" else 1.0
            early, late = (factor * run[f"{key}_{when}"] for when in ("early", "late"))
            rows.append(
                [f"{name}: early, and at {run['hours']:.1f} h", f"{early:.2f}, {late:.2f}", unit]
            )
        rows.append([f"{name}: growth of cost", f"{100 * run['growth']:.1f}", "% of early"])
        sizes = f"{run['resident_early_mb']:.1f}, {run['resident_late_mb']:.1f}"
        rows.append([f"{name}: resident early, late", sizes, "MB"])
        rows.append(
            [
                f"{name}: memory over {run['metres']:.0f} m",
                f"{run['bytes_per_metre']:.0f}",
                "bytes/m",
            ]
        )
    for run in results.get("replays", []):
        rows.append(
            [f"replay, {run['case']}", f"{run['times_real_time_cpu']:.0f}", "times real time"]
        )
    for name, run in results.get("live", {}).items():
        for key, value in run.items():
            rows.append([f"{name}: {key}", f"{value:.3f}", ""])
    return rows


def draw(results: dict[str, Any], folder: Path) -> None:
    """Update against lag; cost and memory along the run."""
    lags = {
        float(name.rsplit(":", 1)[1]): value / 1e3
        for name, value in results.get("kernels", {}).items()
        if "update/lag_s" in name
    }
    if lags:
        figure, (axis,) = canvas.new_figure(width=5.0, height=3.5)
        axis.plot(list(lags), list(lags.values()), "o-")
        axis.set(xlabel="lag (s), 10 states a second", ylabel="update (ms)", ylim=(0, None))
        canvas.save(figure, folder / "lag.png")
    if "length" in results:
        figure, axes = canvas.new_figure(1, 2, width=9.0, height=3.5)
        for name, run in results["length"].items():
            hours = [row["hours"] for row in run["rows"]]
            axes[0].plot(hours, [1e3 * row["cpu_per_s"] for row in run["rows"]], label=name)
            axes[1].plot(hours, [row["resident_bytes"] / 1e6 for row in run["rows"]], label=name)
        axes[0].set(xlabel="hours of data", ylabel="processor time (ms/s)", ylim=(0, None))
        axes[1].set(xlabel="hours of data", ylabel="resident memory (MB)", ylim=(0, None))
        axes[0].legend()
        canvas.save(figure, folder / "run_length.png")


PARTS: dict[str, Callable[[argparse.Namespace], Any]] = {
    "kernels": kernels,
    "length": length,
    "replays": replays,
    "live": live,
}


def main() -> int:
    """Runs the command line."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("log", type=Path, metavar="SEQ.lcmlog", help="begins and ends standing")
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="DIR")
    parser.add_argument("--build", type=Path, default=gprodom._build, help="build folder")
    parser.add_argument("--parts", default=",".join(PARTS), help="of: %(default)s")
    parser.add_argument("--hours", type=float, default=1.0, help="of data, long run (%(default)s)")
    parser.add_argument("--live", type=float, default=60.0, help="s, each live run (%(default)s)")
    parser.add_argument("--min-time", type=float, default=0.2, help="s a benchmark (%(default)s)")
    args = parser.parse_args()
    try:
        chosen = args.parts.split(",")
        if unknown := [name for name in chosen if name not in PARTS]:
            raise UsageError(f"--parts {unknown[0]}: expected some of {', '.join(PARTS)}")
        if not args.log.is_file():
            raise Error(f"{args.log}: no such log")
        args.output.mkdir(parents=True, exist_ok=True)
        results = {name: PARTS[name](args) for name in chosen}
    except UsageError as error:
        print(f"report: error: {error}", file=sys.stderr)
        return 2
    except Error as error:
        print(f"report: error: {error}", file=sys.stderr)
        return 1
    draw(results, args.output)
    rows = table(results)
    lines = ["| what | measured | |", "|---|---|---|"]
    lines += [f"| {' | '.join(str(cell) for cell in row)} |" for row in rows]
    load = ", ".join(f"{value:.1f}" for value in os.getloadavg())
    lines += ["", f"Load of the machine at the end (1, 5, 15 minutes): {load}."]
    (args.output / "report.md").write_text("\n".join(lines) + "\n", encoding="utf-8")
    (args.output / "report.json").write_text(json.dumps(results, indent=1), encoding="utf-8")
    print(format_table(["what", "measured", ""], rows))
    return 0


if __name__ == "__main__":
    sys.exit(main())
