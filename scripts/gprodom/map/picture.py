"""A map seen from above."""

from math import ceil

import numpy as np

from gprodom import canvas
from gprodom.map.ground import MapFile, stored_positions

MOST_COLUMNS = 3  # of maps side by side
MOST_POINTS = 20_000  # of a map's ground that are drawn


def map_figure(file: MapFile) -> canvas.Figure:
    """Paths and, as a band, the ground that is stored; an axis for each map, as their frames are
    not related."""
    columns = min(len(file.maps), MOST_COLUMNS)
    rows = ceil(len(file.maps) / columns)
    figure, axes = canvas.new_figure(rows, columns, width=6.0 * columns, height=5.5 * rows)
    for axis in axes[len(file.maps) :]:
        axis.set_axis_off()
    for axis, number in zip(axes, file.maps, strict=False):
        stored = stored_positions(file, number)
        thinned = stored[:: 1 + len(stored) // MOST_POINTS]
        label = f"ground stored: {len(stored) * file.ground.spacing:.1f} m"
        axis.plot(*thinned.T, "o", color=canvas.COLOURS[5], ms=7, alpha=0.3, mew=0, label=label)
        paths = file.paths(number)
        for i, path in enumerate(paths):
            axis.plot(
                *path.position[:, :2].T,
                color=canvas.COLOURS[0],
                lw=1.0,
                label=f"paths: {len(paths)}" if i == 0 else None,
            )
            begins = "where a path begins" if i == 0 else None
            axis.plot(*path.position[0, :2], ".", color=canvas.COLOURS[1], ms=7, label=begins)
        canvas.seen_from_above(axis)
        begin = np.datetime64(int(file.places["time"][file.places["map"] == number].min()), "ns")
        axis.set_title(f"map {number}, from {np.datetime_as_string(begin, 'm')} UTC")
        canvas.legend_below(axis, 2)
    figure.suptitle(file.path.name)
    return figure
