"""A trajectory as GeoJSON, GPX and CSV, and a row for each radar trace."""

import json
from collections.abc import Iterable, Mapping
from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np

from gprodom.arrays import Floats, Ints
from gprodom.errors import need_module
from gprodom.files import write_bytes
from gprodom.geodesy import Datum
from gprodom.trajectory import Trajectory


def moment(utime: int) -> datetime:
    """The time of a stamp (us since 1970), exactly."""
    return datetime(1970, 1, 1, tzinfo=UTC) + timedelta(microseconds=int(utime))


def position_sigma(trajectory: Trajectory) -> Floats:
    """Standard deviation of the position (n,), m, root of the covariance's trace; NaN: unknown."""
    if trajectory.covariance is None:
        return np.full(len(trajectory), np.nan)
    variance = trajectory.covariance[:, [0, 1, 2], [0, 1, 2]].sum(axis=1)
    return np.asarray(np.sqrt(np.maximum(variance, 0)))


def write_geojson(path: Path, trajectories: Mapping[str, Trajectory], datum: Datum) -> None:
    """A line of longitude, latitude, height (RFC 7946) for each, with the times of its points."""
    features = [_feature(name, one, datum) for name, one in trajectories.items()]
    content = {"type": "FeatureCollection", "features": features}
    write_bytes(path, (json.dumps(content) + "\n").encode())


def _feature(name: str, trajectory: Trajectory, datum: Datum) -> dict[str, object]:
    fixes = datum.to_geographic(trajectory.position)
    return {
        "type": "Feature",
        "geometry": {
            "type": "LineString",
            "coordinates": [
                [round(lon, 9), round(lat, 9), round(h, 4)] for lat, lon, h in fixes.tolist()
            ],
        },
        "properties": {
            "name": name,
            "times": [moment(t).isoformat() for t in trajectory.time.tolist()],
        },
    }


def write_gpx(path: Path, trajectory: Trajectory, datum: Datum, name: str) -> None:
    """A track of one segment."""
    gpx = need_module("gpxpy.gpx", "export", "python3-gpxpy")
    document, track, segment = gpx.GPX(), gpx.GPXTrack(name=name), gpx.GPXTrackSegment()
    for (lat, lon, height), time in zip(
        datum.to_geographic(trajectory.position).tolist(), trajectory.time.tolist(), strict=True
    ):
        segment.points.append(gpx.GPXTrackPoint(lat, lon, elevation=height, time=moment(time)))
    track.segments.append(segment)
    document.tracks.append(track)
    write_bytes(path, document.to_xml().encode())


def write_csv(
    path: Path, trajectory: Trajectory, datum: Datum | None, piece: Ints | None = None
) -> None:
    """Time (s), position (m), quaternion w x y z, sigma (m), with a datum latitude, longitude
    (degrees) and height (m), and where `piece` is given the number of the path."""
    q = trajectory.orientation
    if q is None:
        q = np.full((len(trajectory), 4), np.nan)
    columns = [trajectory.position, q, position_sigma(trajectory)[:, None]]
    header = "time,x,y,z,qw,qx,qy,qz,sigma"
    if datum is not None:
        columns.append(datum.to_geographic(trajectory.position))
        header += ",latitude,longitude,height"
    if piece is not None:
        columns.append(piece[:, None].astype(float))
        header += ",path"
    _write_rows(path, header, trajectory.time, np.hstack(columns))


def write_traces(path: Path, poses: Trajectory, antennas: Ints) -> None:
    """A row for each radar trace: time (s), x, y, z and sigma (m), and the antenna_id (n,), to grid
    a survey by."""
    rows = np.column_stack([poses.position, position_sigma(poses), antennas])
    _write_rows(path, "time,x,y,z,sigma,antenna_id", poses.time, rows)


def _write_rows(path: Path, header: str, time: Ints, rows: Floats) -> None:
    def lines() -> Iterable[str]:
        yield header
        for t, row in zip(time.tolist(), rows.tolist(), strict=True):
            seconds, micro = divmod(int(t), 1_000_000)
            cells = ("" if np.isnan(value) else f"{value:.10g}" for value in row)
            yield f"{seconds}.{micro:06d},{','.join(cells)}"

    write_bytes(path, ("\n".join(lines()) + "\n").encode())
