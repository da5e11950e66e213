"""Flags, kinds and health by name. Their numbers are defined in ``lcmtypes/*.lcm`` only.

The generated classes are loaded only when a number is needed, not on import: help texts need no
build.
"""

from __future__ import annotations

from functools import cache

from gprodom.lcm.messages import message

# Bits of odometry_t.flags and what they are called.
_FLAGS = {
    "STANDING": "standing",
    "SLIPPING": "slipping",
    "NO_WHEEL": "no wheel",
    "NO_RADAR": "no radar",
    "IMU_GAP": "IMU gap",
    "SOLVER_FAILED": "solver failed",
    "WHEEL_FAST": "wheel fast",
    "WHEEL_SLOW": "wheel slow",
    "LEFT_SLIPS": "left slips",
    "RIGHT_SLIPS": "right slips",
    "IMMOBILISED": "immobilised",
}


@cache
def constants(name: str) -> dict[str, int]:
    """The constants of the type `name`, by their names there."""
    return {key: value for key, value in vars(message(name)).items() if key.isupper()}


def flag_bits() -> dict[str, int]:
    """The bits of odometry_t.flags by name, the lowest first."""
    bits = constants("odometry_t")
    return {text: bits[key] for key, text in sorted(_FLAGS.items(), key=lambda item: bits[item[0]])}


def flag(name: str) -> int:
    """One bit of odometry_t.flags, by its name in the type, such as SLIPPING."""
    return constants("odometry_t")[name]


def kind(name: str) -> int:
    """A value of displacement_t.kind, by its name in the type, such as REVISIT."""
    return constants("displacement_t")[name]


def health(value: int) -> str:
    """The name of a value of status_t.health."""
    return {number: key.lower() for key, number in constants("status_t").items()}[value]
