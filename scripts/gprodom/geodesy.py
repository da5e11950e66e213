"""Latitude and longitude to local metres and back, by pyproj."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from gprodom.arrays import Floats
from gprodom.errors import need_module
from gprodom.rotation import yaw_matrix


@dataclass(frozen=True)
class Datum:
    """Where a frame's origin lies on WGS 84, degrees and m, and how its x axis points.

    yaw_deg: from east to the frame's x axis, counter-clockwise.
    """

    latitude: float
    longitude: float
    height: float = 0.0
    yaw_deg: float = 0.0

    def to_local(self, fixes: Floats) -> Floats:
        """Positions (n, 3), m, in the frame, of latitude, longitude (degrees), height (m)."""
        east, north, up = self._topocentric.transform(fixes[:, 1], fixes[:, 0], fixes[:, 2])
        return np.column_stack([east, north, up]) @ self._turn

    def to_geographic(self, position: Floats) -> Floats:
        """Latitude, longitude (degrees) and height (m), (n, 3), of positions in the frame, m."""
        enu = position @ self._turn.T
        longitude, latitude, height = self._topocentric.transform(*enu.T, direction="INVERSE")
        return np.column_stack([latitude, longitude, height])

    @property
    def _turn(self) -> Floats:
        """R_enu_frame."""
        return yaw_matrix(np.radians(self.yaw_deg))

    @cached_property
    def _topocentric(self) -> Any:
        pyproj = need_module("pyproj", "export", "python3-pyproj")
        return pyproj.Transformer.from_pipeline(
            "+proj=pipeline +step +proj=unitconvert +xy_in=deg +xy_out=rad "
            "+step +proj=cart +ellps=WGS84 +step +proj=topocentric +ellps=WGS84 "
            f"+lat_0={self.latitude!r} +lon_0={self.longitude!r} +h_0={self.height!r}"
        )


def local_positions(fixes: Floats) -> Floats:
    """East, north, up (n, 3), m, from the first of latitude, longitude (degrees), height (m)."""
    return Datum(*(float(value) for value in fixes[0])).to_local(fixes)
