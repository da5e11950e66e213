"""A connection to LCM, or what to do about it."""

from gprodom.errors import Error
from gprodom.lcm import LCM


def connect(url: str) -> LCM:
    """To the network that `url` names."""
    try:
        return LCM(url)
    except RuntimeError:
        raise Error(
            f"LCM URL {url}: cannot be used; is there a route for multicast "
            "(ip route add 224.0.0.0/4 dev lo)?"
        ) from None
