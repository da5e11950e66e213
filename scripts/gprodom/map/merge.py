"""Two maps become one where ground that both drove over proves how they lie, or fixes have tied
both to one site."""

import math
from dataclasses import dataclass
from typing import Any

from gprodom.errors import Error
from gprodom.map.ground import MapFile

# The search tries travel times as they are, and so much longer and shorter; from there on they are
# followed by what fits a patch better. What is less is not told from none.
TOLD_APART = 0.05


@dataclass(frozen=True)
class Merged:
    """A merged map, and what is known of it."""

    data: bytes
    joins: list[dict[str, Any]]  # of each map of the second file
    known_m: float  # of the second file's ground, which the first has


def merge(first: MapFile, second: MapFile) -> Merged:
    """Raises `Error` where nothing proves how they lie, or where the files cannot be compared."""
    try:
        found = first.ground.merged(second.ground)
    except ValueError as error:
        raise Error(f"{first.path}, {second.path}: not merged: {error}") from None
    joins = [_facts(join) for join in found["joins"]]
    if not any(join["proven"] for join in joins):
        most = max((join["proven_m"] for join in joins), default=0.0)
        raise Error(
            f"{second.path}: no ground in common with {first.path} is proven"
            + (f" ({most:.1f} m of it look alike)" if most else "")
            + ", nor do both lie in one site surely enough: not merged, nothing is written"
        )
    return Merged(found["ground"].to_bytes(), joins, found["known_m"])


def _facts(join: dict[str, Any]) -> dict[str, Any]:
    """What is told of a join. Its sigmas are those of the track's last pose in the first map."""
    sigmas = [math.sqrt(join["covariance"][i]) for i in (0, 4, 8)]
    names = ("map", "proven", "into", "by_datum", "revisits", "refused", "proven_m", "datum")
    known = dict.fromkeys(("longer_travel_times", "scale", "sigma_m", "sigma_yaw"))
    if join["proven"]:
        known |= {
            "longer_travel_times": None if join["by_datum"] else math.expm1(join["stretch"]),
            "scale": join["scale"],
            "sigma_m": math.hypot(*sigmas[:2]),
            "sigma_yaw": sigmas[2],
        }
    return {name: join[name] for name in names} | known


def _travel_times(join: dict[str, Any]) -> str:
    longer = join["longer_travel_times"]
    if abs(longer) <= TOLD_APART:
        return f"travel times alike within {100 * TOLD_APART:.0f} %"
    return f"travel times about {100 * longer:+.0f} % (to some {100 * TOLD_APART:.0f} %)"


def as_text(join: dict[str, Any]) -> str:
    """A line on one map of the second file."""
    if not join["proven"]:
        return f"map {join['map']}: no ground in common is proven: left out"
    known = f"its last pose is known to {100 * join['sigma_m']:.0f} cm"
    joins = f"map {join['map']} joins map {join['into']}"
    if join["by_datum"]:
        return f"{joins}: by where both lie in site, without ground in common; {known}"
    return (
        f"{joins}: {join['revisits']} revisits over {join['proven_m']:.1f} m, {join['refused']} "
        f"refused; {_travel_times(join)}; {known}{_check(join['datum'])}"
    )


def _check(datum: dict[str, Any] | None) -> str:
    """Of a join by ground: whether the datums of both say the same."""
    if datum is None:
        return ""
    off = f"{datum['off_m']:.2f} m apart, {datum['deviations']:.1f} standard deviations"
    return f"; the datums {'agree' if datum['agrees'] else 'CONTRADICT it'}: {off}"
