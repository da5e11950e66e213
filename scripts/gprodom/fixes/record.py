"""Positions from outside as arrays, to and from the messages of a log."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from enum import IntEnum
from pathlib import Path

import numpy as np

from gprodom.arrays import Bools, Floats, Ints
from gprodom.errors import Error
from gprodom.geodesy import Datum
from gprodom.lcm import logs
from gprodom.lcm.log_writer import Stream, encoded


class Frame(IntEnum):
    """position_fix_t.frame."""

    SITE = 0
    GEODETIC = 1


class Quality(IntEnum):
    """position_fix_t.quality."""

    NONE = 0
    SINGLE = 1
    FLOAT = 2
    FIXED = 3
    SURVEYED = 4


@dataclass(frozen=True)
class Fixes:
    """n fixes in order of time.

    position: m in `site`, or latitude, longitude (degrees) and height (m). covariance: m^2, of site
    axes or east, north, up. heading (rad, of body x from site x) is NaN where none is told.
    """

    utime: Ints  # (n,), us
    frame: Frame
    position: Floats  # (n, 3)
    covariance: Floats  # (n, 3, 3)
    quality: Ints  # (n,)
    antenna: int = 0
    heading: Floats = field(default_factory=lambda: np.zeros(0))  # (n,), or (0,): none
    heading_sigma: Floats = field(default_factory=lambda: np.zeros(0))

    def __len__(self) -> int:
        return len(self.utime)

    def select(self, chosen: Bools | Ints) -> "Fixes":
        """Those chosen."""
        parts = {
            name: getattr(self, name)[chosen]
            for name in ("utime", "position", "covariance", "quality")
        }
        if len(self.heading):
            parts |= {name: getattr(self, name)[chosen] for name in ("heading", "heading_sigma")}
        return replace(self, **parts)

    def in_site(self, datum: Datum) -> Floats:
        """Positions (n, 3), m, in the frame of `datum`."""
        return datum.to_local(self.position) if self.frame == Frame.GEODETIC else self.position

    def stream(self, channel: str) -> Stream:
        """As messages."""
        known = np.isfinite(self.heading) if len(self.heading) else np.zeros(len(self), bool)
        heading, sigma = (
            np.where(known, each, 0.0) if len(each) else 0.0
            for each in (self.heading, self.heading_sigma)
        )
        return encoded(
            channel,
            "position_fix_t",
            self.utime,
            frame=int(self.frame),
            position=self.position,
            covariance=self.covariance.reshape(-1, 9),
            quality=self.quality,
            antenna_id=self.antenna,
            has_heading=known,
            heading=heading,
            heading_sigma=sigma,
        )


def one_stream(channel: str, fixes: Sequence[Fixes]) -> Stream:
    """Several antennas' fixes as the messages of one channel, in order of time."""
    streams = [each.stream(channel) for each in fixes]
    utime = np.concatenate([each.utime for each in streams])
    payloads = [payload for each in streams for payload in each.payloads]
    order = np.argsort(utime, kind="stable")
    return Stream(channel, utime[order], [payloads[i] for i in order.tolist()])


def diagonal(sigmas: Floats) -> Floats:
    """Covariances (n, 3, 3) of standard deviations (n, 3)."""
    return np.asarray(sigmas[:, :, None] ** 2 * np.eye(3))


def read_fixes(log: Path, channel: str) -> list[Fixes]:
    """The fixes of a log, apart by antenna and frame; [] where it has none."""
    found = logs.read(log, [channel]).get(channel)
    if found is None:
        return []
    if found["type"] != "position_fix_t":
        raise Error(f"{log}: channel {channel}: expected position_fix_t, got {found['type']}")
    order = np.argsort(found["utime"], kind="stable")
    kinds = np.column_stack([found["antenna_id"], found["frame"]])
    return [
        _of_kind(found, order[(kinds[order] == kind).all(axis=1)], kind.tolist())
        for kind in np.unique(kinds, axis=0)
    ]


def _of_kind(found: logs.Channel, rows: Ints, kind: Sequence[int]) -> Fixes:
    antenna, frame = kind
    known = found["has_heading"][rows]
    heading, sigma = (np.where(known, found[n][rows], np.nan) for n in ("heading", "heading_sigma"))
    return Fixes(
        found["utime"][rows],
        Frame(frame),
        found["position"][rows],
        found["covariance"][rows].reshape(-1, 3, 3),
        found["quality"][rows].astype(np.int64),
        antenna,
        heading,
        sigma,
    )
