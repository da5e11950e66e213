"""Fixes from a table's columns."""

import numpy as np

from gprodom.arrays import Floats, Ints
from gprodom.errors import Error
from gprodom.fixes import trust
from gprodom.fixes.record import Fixes, Frame, Quality, diagonal

# Columns after the time by how many there are: three of the position, then none, three standard
# deviations or the six values of a covariance, and perhaps the quality.
WIDTHS = (3, 4, 6, 7, 9, 10)
_UPPER = np.triu_indices(3)  # xx, xy, xz, yy, yz, zz


def fixes_of_table(
    where: str, utime: Ints, values: Floats, geodetic: bool, code: str, sigma: float | None
) -> Fixes:
    """values: (n, one of `WIDTHS`). code: of the qualities, see `trust.CODES`. sigma: m, where the
    table has neither standard deviations nor covariances."""
    position, rest = values[:, :3], values[:, 3:]
    beyond = np.abs(position[:, :2]).max(axis=0) if len(position) else np.zeros(2)
    if geodetic and (beyond[0] > 90 or beyond[1] > 180):
        raise Error(f"{where}: expected latitude and longitude in degrees, in this order")
    quality = None
    if rest.shape[1] % 3 == 1:
        quality, rest = _qualities(where, rest[:, -1], code), rest[:, :-1]
    if rest.shape[1] == 6:
        covariance = np.zeros((len(values), 3, 3))
        covariance[:, _UPPER[0], _UPPER[1]] = rest
        covariance[:, _UPPER[1], _UPPER[0]] = rest
    elif rest.shape[1] == 3:
        covariance = diagonal(rest)
    elif sigma is not None:
        covariance = diagonal(np.full((len(values), 3), sigma))
    elif quality is not None:
        covariance = trust.conservative(quality)
    else:
        raise Error(
            f"{where}: how good are the fixes? Name columns of standard deviations, a covariance "
            "or a quality, or give --fix-sigma M"
        )
    if quality is None:
        quality = trust.pose_quality(covariance, trust.known(covariance))
    position = np.where((quality == Quality.NONE)[:, None], 0.0, position)
    wrong = (quality != Quality.NONE) & (
        ~trust.known(covariance) | (np.linalg.eigvalsh(covariance)[:, 0] < 0)
    )
    if wrong.any():
        raise Error(
            f"{where}: {np.count_nonzero(wrong)} fixes with standard deviations of 0 or a "
            "covariance that is none"
        )
    frame = Frame.GEODETIC if geodetic else Frame.SITE
    return Fixes(utime, frame, position, covariance, quality)


def _qualities(where: str, column: Floats, code: str) -> Ints:
    codes = trust.CODES[code]
    unknown = sorted({value for value in column.tolist() if value not in codes})
    if unknown:
        raise Error(
            f"{where}: quality {unknown[0]:g}: expected one of {', '.join(map(str, codes))} "
            f"(--fix-quality-code {code})"
        )
    return np.array([int(codes[int(value)]) for value in column.tolist()], np.int64)
