"""LCM: messages and logs as classes and arrays. This module decides which LCM binding is used.

The PyPI module ``lcm`` where it is installed (a checkout's virtual environment); else our own thin
binding over Debian's liblcm, `gprodom.lcm.binding`, which has the same API. GPRODOM_LCM=pypi or
GPRODOM_LCM=ctypes forces one.
"""

import os
from importlib.util import find_spec
from typing import TYPE_CHECKING

from gprodom.errors import Error

_choice = os.environ.get("GPRODOM_LCM", "")
if _choice not in ("", "pypi", "ctypes"):
    raise Error(f"GPRODOM_LCM is {_choice!r}: expected pypi or ctypes")

SOURCE = _choice or ("pypi" if find_spec("lcm") else "ctypes")
if TYPE_CHECKING or SOURCE == "ctypes":
    from gprodom.lcm.binding import LCM, Event, EventLog, LCMSubscription
else:
    try:
        from lcm import LCM, Event, EventLog, LCMSubscription
    except ModuleNotFoundError:
        raise Error("GPRODOM_LCM=pypi, but the module lcm is not installed") from None

DEFAULT_URL = "udpm://239.255.76.67:7667?ttl=0"  # nothing leaves the machine


def connect(url: str) -> LCM:
    """To the network that `url` names, or what to do about it."""
    try:
        return LCM(url)
    except RuntimeError:
        raise Error(
            f"LCM URL {url}: cannot be used; is there a route for multicast "
            "(ip route add 224.0.0.0/4 dev lo)?"
        ) from None


__all__ = ["DEFAULT_URL", "LCM", "SOURCE", "Event", "EventLog", "LCMSubscription", "connect"]
