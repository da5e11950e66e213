"""Where `site` lies: the datum that a log, its estimator's status or a configuration tells."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from gprodom.config import Channels
from gprodom.fixes.record import Frame, Quality, read_fixes
from gprodom.geodesy import Datum
from gprodom.lcm import logs

# Values of STATUS: the origin of site (deg, deg, m) and how many fixes hold the map there.
ORIGIN = ("site.latitude", "site.longitude", "site.height")
USED = "fixes.used"


def datum_of_log(
    log: Path,
    channels: Channels,
    configured: tuple[float, float, float] | None,
    others: Sequence[Path] = (),
) -> Datum | None:
    """Of an estimate whose map is `site`; None where fixes did not tie it, or nothing tells where.

    It is what STATUS says, else the configured one, else that of the estimator's own rule: the
    first fix in degrees in the log or in `others`, such as the one that was replayed.
    """
    status = logs.read_roles(log, channels.of("status")).get("status")
    told = [dict(zip(m.names, m.values, strict=True)) for m in status["messages"]] if status else []
    for values in reversed(told):
        if all(name in values for name in ORIGIN):
            return Datum(*(float(values[name]) for name in ORIGIN))
    if not any(values.get(USED, 0.0) > 0 for values in told):
        return None
    if configured is not None:
        return Datum(*configured)
    first: tuple[int, Datum] | None = None
    for fixes in (
        one for path in (log, *others) for one in read_fixes(path, channels.position_fix)
    ):
        usable = np.flatnonzero(fixes.quality != Quality.NONE)
        if fixes.frame == Frame.GEODETIC and usable.size:
            time = int(fixes.utime[usable[0]])
            if first is None or time < first[0]:
                first = time, Datum(*(float(part) for part in fixes.position[usable[0]]))
    return first[1] if first else None
