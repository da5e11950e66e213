"""Flags and kinds have the numbers of the message types, and one name each in all commands."""

from gprodom.lcm.constants import constants, flag, flag_bits, health, kind
from gprodom.lcm.messages import fingerprint, message

# Fingerprints of the released types. Constants and comments do not change them. A changed field
# would make older logs unreadable, so it needs a new type.
FINGERPRINTS = {
    "gpr_trace_t": "49e526d0b0c7b2c9",
    "imu_t": "0a170b716bb0a149",
    "wheel_t": "679ea99815b041e2",
    "wheels_t": "4d0f4d39e0feb30d",
    "displacement_t": "f888749f9d266787",
    "odometry_t": "abbdede81f929f4d",
    "correction_t": "a359df710ec0655d",
    "sfm_t": "cd0519d87babcb41",
    "status_t": "9273f74c71f3eb9b",
    "position_truth_t": "0a7e47c86cccfbab",
    "command_t": "8a8691b212605be7",
    "position_fix_t": "d2ba87590c33a909",
}


def test_released_types_keep_their_fingerprints() -> None:
    assert {name: fingerprint(name).hex() for name in FINGERPRINTS} == FINGERPRINTS


def test_every_flag_of_the_type_has_a_name() -> None:
    bits = set(flag_bits().values())
    assert bits == set(constants("odometry_t").values()) == {1 << i for i in range(11)}
    assert flag("SLIPPING") == message("odometry_t").SLIPPING


def test_kinds_and_health_are_those_of_the_types() -> None:
    assert [kind(name) for name in ("SEQUENTIAL", "MOTION", "REVISIT", "EXTERNAL")] == [0, 1, 2, 3]
    assert [health(value) for value in range(3)] == ["ok", "degraded", "failed"]
