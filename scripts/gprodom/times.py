"""Times as text, to the microsecond."""

import re
from decimal import ROUND_HALF_UP, Decimal

_SECONDS = re.compile(rb"\s*(\d{1,12})(?:\.(\d*))?\s*\Z")
_LATEST = 1 << 62  # us


def to_microseconds(text: bytes, per_second: int = 1) -> int:
    """A decimal time to the nearest microsecond, by digits: never through a float.

    per_second: of the time's unit, such as 1000 of milliseconds. Raises ValueError where `text` is
    no such number since 1970.
    """
    match = _SECONDS.match(text) if per_second == 1 else None
    if match is not None:
        seconds, fraction = match.group(1), match.group(2) or b""
        digits = fraction[:7].ljust(7, b"0")
        return int(seconds) * 1_000_000 + int(digits[:6]) + (digits[6] >= 0x35)
    try:
        value = Decimal(text.decode("ascii").strip())
        exact = (value * 1_000_000 / per_second).to_integral_value(ROUND_HALF_UP)
    except (ArithmeticError, UnicodeDecodeError):
        raise ValueError("not a time") from None
    if not value.is_finite() or not 0 <= exact < _LATEST:
        raise ValueError("not a time since 1970")
    return int(exact)
