"""Where a map lies in `site`, as its file has it: what is told of that."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from gprodom.geodesy import Datum

if TYPE_CHECKING:
    from gprodom._core import GroundMap


def datum_of(ground: GroundMap, number: int) -> Datum | None:
    """Where the frame of a map lies on the Earth; None where fixes in degrees did not tie it."""
    told = ground.datum(number)
    return None if told is None or told["frame"] is None else Datum(*told["frame"])


def site_facts(ground: GroundMap, number: int) -> dict[str, Any] | None:
    """The pose of a map's frame in site (m, rad) with its standard deviations; None: not tied.

    origin: of site, latitude, longitude (degrees) and height (m), where it is known.
    """
    told = ground.datum(number)
    if told is None:
        return None
    covariance = np.asarray(told["covariance"])
    origin = told["origin"]
    return {
        **{name: told[name] for name in ("x", "y", "z", "yaw")},
        "covariance": covariance.tolist(),
        "sigma_m": math.sqrt(covariance[0, 0] + covariance[1, 1]),
        "sigma_yaw": math.sqrt(covariance[3, 3]),
        "origin": None if origin is None else [float(part) for part in origin],
    }


def site_as_text(facts: dict[str, Any] | None) -> str:
    """A cell of a table."""
    if facts is None:
        return "-"
    place = "{x:.2f}, {y:.2f} m, {yaw:.4f} rad".format(**facts)
    known = f"to {100 * facts['sigma_m']:.0f} cm, {facts['sigma_yaw']:.4f} rad"
    origin = facts["origin"]
    where = "" if origin is None else "; site at {:.7f}, {:.7f}, {:.1f} m".format(*origin)
    return f"{place} ({known}){where}"
