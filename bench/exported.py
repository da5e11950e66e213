#!/usr/bin/env python3
"""Draws what `gprodom export` wrote, as other libraries read it.

The path in degrees out of GeoJSON; odometry with and without the map's corrections, and the radar's
last picture, out of MCAP by mcap-ros2-support; the traces at their places out of SEG-Y by segyio.

    gprodom convert cmu sample/*-cmu-gpr.zip -o in.lcmlog
    gprodom run in.lcmlog --method gprodom_full -o out.lcmlog
    gprodom export out.lcmlog --datum 52.3906,13.0645 --geojson path.geojson
    gprodom export out.lcmlog --radar in.lcmlog --mcap out.mcap --segy survey.sgy
    bench/exported.py path.geojson out.mcap survey.sgy -o docs/export.png
"""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path

import numpy as np

from gprodom.canvas import legend_below, line_style, new_figure, png


def of_geojson(path: Path) -> np.ndarray:
    """(n, 2): longitude and latitude."""
    (feature,) = json.loads(path.read_text())["features"]
    return np.array(feature["geometry"]["coordinates"])[:, :2]


def of_mcap(path: Path) -> tuple[dict[str, np.ndarray], np.ndarray]:
    """(n, 2) x and y of each odometry, and the last B-scan (samples, traces)."""
    from mcap_ros2.reader import read_ros2_messages

    places: dict[str, list[tuple[float, float]]] = {}
    scan = None
    for each in read_ros2_messages(str(path)):
        topic, message = each.channel.topic.removeprefix("/gprodom/"), each.ros_msg
        if topic.startswith("odometry"):
            place = message.pose.pose.position
            places.setdefault(topic, []).append((place.x, place.y))
        elif topic == "bscan":
            scan = np.frombuffer(bytes(message.data), np.uint8).reshape(message.height, -1)
    assert scan is not None, f"{path}: no B-scan"
    return {topic: np.array(each) for topic, each in places.items()}, scan


def of_segy(path: Path) -> tuple[np.ndarray, np.ndarray]:
    """(n, 2): x and y of each trace, m, and the root mean square of what changes in it."""
    import segyio

    with segyio.open(str(path), ignore_geometry=True) as file:
        names = (segyio.TraceField.SourceX, segyio.TraceField.SourceY)
        scale = 1 / abs(file.header[0][segyio.TraceField.SourceGroupScalar])
        places = np.column_stack([file.attributes(name)[:] for name in names]) * scale
        traces = file.trace.raw[:].astype(float)
    return places, np.sqrt(np.mean((traces - traces.mean(axis=0)) ** 2, axis=1))


def main() -> int:
    """One picture of four panels."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    for name in ("geojson", "mcap", "segy"):
        parser.add_argument(name, type=Path)
    parser.add_argument("-o", "--output", metavar="PNG", type=Path, required=True)
    args = parser.parse_args()
    figure, (degrees, paths, radar, survey) = new_figure(2, 2, 9.0, 7.0)
    degrees.plot(*of_geojson(args.geojson).T, **line_style(0, 2))
    degrees.set(title="GeoJSON", xlabel="longitude (degrees)", ylabel="latitude (degrees)")
    degrees.ticklabel_format(useOffset=False)
    degrees.tick_params(axis="x", labelrotation=20)
    places, scan = of_mcap(args.mcap)
    for i, (topic, path) in enumerate(sorted(places.items())):
        paths.plot(*path.T, **line_style(i, len(places)), label=f"gprodom/{topic}")
    legend_below(paths, 1)
    paths.set(title="MCAP", xlabel="x (m)", ylabel="y (m)", aspect="equal")
    radar.imshow(scan, cmap="gray", aspect="auto")
    radar.grid(visible=False)
    radar.set(title="MCAP: gprodom/bscan, the last", xlabel="trace", ylabel="sample")
    where, strength = of_segy(args.segy)
    dots = survey.scatter(*where.T, s=3, c=strength, cmap="viridis")
    figure.colorbar(dots, ax=survey, label="RMS of the trace less the mean trace (counts)")
    survey.set(
        title="SEG-Y: traces at their places", xlabel="x (m)", ylabel="y (m)", aspect="equal"
    )
    args.output.write_bytes(png(figure, dpi=80))
    return 0


if __name__ == "__main__":
    sys.exit(main())
