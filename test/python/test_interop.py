"""LCM programs of others: the pose type they share, and the programs in examples/."""

import math
import struct
import sys
from pathlib import Path

import numpy as np

from conftest import CHECKOUT, run_isolated, run_program
from gprodom.lcm.messages import fingerprint
from gprodom.odometry.replay import find_program
from packets import packet

EXAMPLES = CHECKOUT / "examples"
UTIME = 1_700_000_000_123_456

# As others generate it: 0x170b77d82958082f in their sources, rotated left by one bit in a message.
POSE_FINGERPRINT = struct.pack(">Q", 0x170B77D82958082F << 1)


def test_pose_is_byte_for_byte_that_of_bot_core() -> None:
    assert fingerprint("pose_t", "bot_core") == POSE_FINGERPRINT
    values = {"pos": [1, 2, 3], "vel": [4, 5, 6], "orientation": [7, 8, 9, 10]}
    values |= {"rotation_rate": [11, 12, 13], "accel": [14, 15, 16]}
    expected = POSE_FINGERPRINT + struct.pack(">q16d", UTIME, *range(1, 17))
    assert packet("pose_t", "bot_core", utime=UTIME, **values) == expected


PUBLISH = """
import subprocess, sys, time
from gprodom.lcm import LCM, DEFAULT_URL
lcm = LCM(DEFAULT_URL)
with subprocess.Popen(sys.argv[2:] + ["2"], stdout=subprocess.PIPE, text=True) as example:
    while example.poll() is None:
        lcm.publish("POSE", b"not for it")
        lcm.publish("ODOMETRY_MAP", bytes.fromhex(sys.argv[1]))
        time.sleep(0.02)
    print(example.stdout.read(), end="")
sys.exit(example.returncode)
"""


def odometry() -> bytes:
    place = {"position": [1.25, -0.5, 0.0], "orientation": [math.cos(0.4), 0, 0, math.sin(0.4)]}
    covariance = np.diag([0.0009, 0.0016, 0, 0, 0, 0]).ravel().tolist()
    return packet("odometry_t", utime=UTIME, frame="map", pose_covariance=covariance, **place)


def heard_by(*command: object) -> None:
    result = run_isolated(PUBLISH, odometry().hex(), *command)
    assert result.stdout == 2 * "1700000000123456 map 1.250 -0.500 45.8 +-0.050\n"


SEND = """
import subprocess, sys, threading
from gprodom.lcm import LCM, DEFAULT_URL
from gprodom.lcm.messages import message
daemon, *example = sys.argv[1:]
types = {"STATUS": "status_t", "WHEEL": "wheel_t", "IMU": "imu_t", "ODOMETRY_MAP": "odometry_t"}
heard = {channel: [] for channel in types}
lcm = LCM(DEFAULT_URL)
for channel, name in types.items():
    decode = message(name).decode
    take = lambda channel, data, decode=decode: heard[channel].append(decode(data))
    lcm.subscribe(channel, take).set_queue_capacity(10_000)
with subprocess.Popen([daemon, "-c", "/dev/null"], stderr=subprocess.DEVNULL) as gprodomd:
    while not heard["STATUS"] and gprodomd.poll() is None:
        lcm.handle_timeout(100)
    with subprocess.Popen(example + ["9"]) as sender:
        while sender.poll() is None:
            lcm.handle_timeout(100)
    while lcm.handle_timeout(500):  # what is under way; STATUS goes on, once a second
        pass
    gprodomd.terminate()
newest = heard["ODOMETRY_MAP"][-1]
wheel = heard["WHEEL"][-1]
print(len(heard["IMU"]), len(heard["WHEEL"]), newest.utime - wheel.utime, newest.flags,
      *newest.position, wheel.ticks * wheel.metres_per_tick)
"""


def drives_the_daemon(*command: object) -> None:
    """What the example sends is a drive that gprodomd follows, live."""
    result = run_isolated(SEND, find_program("gprodomd"), *command)
    said = [float(word) for word in result.stdout.split()]
    imu, wheel, since_us, flags, x, y, z, driven_m = said
    assert wheel == imu // 5 + (imu % 5 > 0)
    assert flags == 0, "moves, and has wheel and radar"
    assert driven_m > 1.5
    # The wheel's last word is some tens of milliseconds old, at 0.5 m/s.
    assert abs(x - driven_m) < 0.03 + 0.5e-6 * abs(since_us)
    assert abs(y) < 0.02 and abs(z) < 0.02


def test_example_in_python() -> None:
    heard_by(sys.executable, EXAMPLES / "python" / "listen.py")
    drives_the_daemon(sys.executable, EXAMPLES / "python" / "send.py")


def test_example_in_cpp(tmp_path: Path) -> None:
    types = f"-DLCMTYPES={CHECKOUT / 'lcmtypes'}"
    run_program("cmake", "-S", EXAMPLES / "cpp", "-B", tmp_path, types)
    run_program("cmake", "--build", tmp_path)
    heard_by(tmp_path / "listen")
    drives_the_daemon(tmp_path / "send")
