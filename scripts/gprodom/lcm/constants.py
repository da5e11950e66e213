"""Flags, kinds and health by name. Their numbers are defined in ``lcmtypes/*.lcm`` only.

The generated classes are loaded only when a number is needed, not on import: help texts need no
build.
"""

from functools import cache

from gprodom.lcm.messages import message


@cache
def constants(name: str) -> dict[str, int]:
    """The constants of the type `name`, by their names there."""
    return {key: value for key, value in vars(message(name)).items() if key.isupper()}


def flag_bits() -> dict[str, int]:
    """The bits of odometry_t.flags, the lowest first, by what they are called: `IMU gap`."""
    bits = sorted(constants("odometry_t").items(), key=lambda item: item[1])
    return {key.lower().replace("_", " ").replace("imu", "IMU"): bit for key, bit in bits}


def flag(name: str) -> int:
    """One bit of odometry_t.flags, by its name in the type, such as SLIPPING."""
    return constants("odometry_t")[name]


def kind(name: str) -> int:
    """A value of displacement_t.kind, by its name in the type, such as REVISIT."""
    return constants("displacement_t")[name]


def health(value: int) -> str:
    """The name of a value of status_t.health."""
    return {number: key.lower() for key, number in constants("status_t").items()}[value]
