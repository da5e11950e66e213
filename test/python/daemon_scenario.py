"""What test_daemon.py does with a running gprodomd. Runs in a network namespace of its own:

    python daemon_scenario.py SCENARIO FOLDER

FOLDER is for files; the scenario fails by an exception.
"""

import ctypes
import io
import math
import os
import select
import signal
import socket
import struct
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rich.console import Console

from gprodom.lcm import LCM
from gprodom.lcm.messages import fingerprint, message
from gprodom.odometry.replay import find_program
from gprodom.status.heard import Heard
from gprodom.status.view import page

URL = "udpm://239.255.76.67:7667?ttl=0"
START_UTIME = 1_700_000_000_000_000
PATIENCE_S = 15.0


@dataclass
class Robot:
    """One that drives straight ahead: utime, speed (m/s) and the way behind it (m)."""

    utime: int
    speed: float = 0.0
    travelled: float = 0.0

    def step(self, i: int, speed: float) -> list[tuple[str, Any]]:
        """IMU and wheel of the next 10 ms; it speeds up by 0.5 m/s^2 at most."""
        imu, wheel = message("imu_t")(), message("wheel_t")()
        gain = min(max(speed - self.speed, -0.005), 0.005)
        imu.utime = wheel.utime = self.utime
        forward = gain / 0.01 + 0.002 * math.sin(i)
        imu.linear_acceleration = [forward, 0.002 * math.cos(i), 9.80665]
        imu.angular_velocity = [4e-4 * math.sin(1.7 * i), 4e-4 * math.cos(2.3 * i), 0.0]
        wheel.ticks, wheel.metres_per_tick = round(self.travelled * 1000), 0.001
        self.speed += gain
        self.travelled += self.speed * 0.01
        self.utime += 10_000
        return [("IMU", imu), ("WHEEL", wheel)]


class Daemon:
    """A gprodomd of our own, its log and what it publishes."""

    def __init__(self, folder: Path, config: str, **environment: str) -> None:
        self.config = folder / "config.yaml"
        self.config.write_text(config)
        self._log_path = folder / "log"
        with open(self._log_path, "w") as log:
            self.process = subprocess.Popen(
                [str(find_program("gprodomd")), "-c", str(self.config)],
                stderr=log,
                env={**os.environ, **environment},
            )
        self.lcm = LCM(URL)
        self.heard: dict[str, list[Any]] = {}
        for channel, name in (("ODOMETRY", "odometry_t"), ("STATUS", "status_t")):
            kept = self.heard.setdefault(channel, [])
            self.lcm.subscribe(
                channel,
                lambda _, data, kept=kept, name=name: kept.append(message(name).decode(data)),
            )
        self.await_log(" runs: ")

    def __enter__(self) -> "Daemon":
        return self

    def __exit__(self, *_: object) -> None:
        self.process.kill()  # where the scenario has not ended it
        self.process.wait()

    def log(self) -> str:
        return self._log_path.read_text()

    def wait_for(
        self, what: str, happened: Callable[[], bool], patience_s: float = PATIENCE_S
    ) -> None:
        """Handles messages until it `happened`."""
        deadline = time.monotonic() + patience_s
        while not happened():
            assert self.process.poll() is None, f"gprodomd ended:\n{self.log()}"
            assert time.monotonic() < deadline, f"in vain: {what}; the log:\n{self.log()}"
            self.lcm.handle_timeout(20)

    def await_log(self, text: str) -> None:
        self.wait_for(f'"{text}" in the log', lambda: text in self.log())

    def await_status(self, text: str) -> None:
        self.wait_for(
            f'"{text}" in STATUS',
            lambda: any(text in reason for m in self.heard["STATUS"] for reason in m.reasons),
        )

    def reread(self, config: str) -> None:
        self.config.write_text(config)
        self.process.send_signal(signal.SIGHUP)

    def command(self, name: str, argument: str = "", utime: int = START_UTIME) -> None:
        m = message("command_t")()
        m.utime, m.name, m.argument = utime, name, argument
        self.lcm.publish("COMMAND", m.encode())

    def stop(self, how: signal.Signals) -> None:
        self.process.send_signal(how)
        code = self.process.wait(PATIENCE_S)
        assert code == 0, f"exit code {code}:\n{self.log()}"
        assert self.log().rstrip().endswith("stopped"), self.log()

    def stand(self, seconds: float, utime: int) -> int:
        """A robot that stands; the utime at its end."""
        robot = Robot(utime)
        self.drive(robot, seconds, 0.0)
        return robot.utime

    def drive(self, robot: Robot, seconds: float, speed: float) -> None:
        """Changes the robot's speed; 100 Hz, sent at ten times real time."""
        for i in range(round(seconds * 100)):
            for channel, m in robot.step(i, speed):
                self.lcm.publish(channel, m.encode())
            self.lcm.handle_timeout(1)


def reread(folder: Path) -> None:
    """SIGHUP: changes are reported and applied; a bad file leaves the old configuration."""
    with Daemon(folder, "wheel:\n  scale: 1.0\n") as daemon:
        daemon.reread("wheel:\n  scale: 1.0\nlogging:\n  level: warning\n")
        daemon.await_log("config: logging.level: info -> warning")
        daemon.reread("wheel:\n  scale: abc\n")
        daemon.await_log(":2: wheel.scale: expected a number")
        daemon.reread("smoother:\n  lag: 0.2\n  state_rate: 1\n")
        daemon.await_log("smoother.lag: expected at least two state intervals")
        daemon.reread("gpr:\n  filter: {band_low: 9.0e8, band_high: 2.0e8}\n")
        daemon.await_log("gpr.filter.band_low: expected less than gpr.filter.band_high")
        assert daemon.log().count("config not applied, the old one stays") == 3
        assert "restarts" not in daemon.log()
        daemon.reread("wheel:\n  scale: 0.97\n")
        daemon.await_log("config: wheel.scale: 1 -> 0.97")
        daemon.await_log("config: logging.level: warning -> info")
        daemon.await_log("the estimator restarts with the new config")
        daemon.stand(5.0, START_UTIME)
        daemon.wait_for("poses with the new scale", lambda: bool(daemon.heard["ODOMETRY"]))
        assert daemon.heard["ODOMETRY"][-1].wheel_scale == 0.97
        daemon.stop(signal.SIGTERM)


def hostile(folder: Path) -> None:
    """Packets that would crash the generated decoders are counted, and the daemon goes on."""
    with Daemon(folder, "") as daemon:
        trace = struct.pack(
            ">8sqqiddd", fingerprint("gpr_trace_t"), START_UTIME, 1, 0, 2e-10, 0.0, 0.0
        )
        for count in (-1, 1 << 30, 2**31 - 1, -(2**31)):
            daemon.lcm.publish("GPR_TRACE", trace + struct.pack(">i", count) + b"\0" * 64)
        for channel in ("GPR_TRACE", "IMU", "WHEEL", "COMMAND", "GPR_DISPLACEMENT_IN"):
            for data in (b"", b"\xff", b"\xff" * 100, fingerprint("imu_t") + b"\0" * 9):
                daemon.lcm.publish(channel, data)
        text = struct.pack(">8sqi", fingerprint("command_t"), START_UTIME, -5)
        daemon.lcm.publish("COMMAND", text + b"reset\0")
        end = daemon.stand(5.0, START_UTIME)
        daemon.await_log("GPR_TRACE: message announces an impossible count of samples")
        daemon.await_log("COMMAND: message announces an impossible length of name")
        daemon.wait_for("poses", lambda: bool(daemon.heard["ODOMETRY"]))

        daemon.command("reset", utime=end)
        daemon.await_log("reset by command")
        daemon.await_status("no input for")  # silence is told of, not kept
        daemon.await_log("health: failed: no input for")
        daemon.stop(signal.SIGINT)
        assert "health: ok" not in daemon.log().split("health: failed")[-1], daemon.log()


class Manager:
    """Stands in for systemd with a service of Type=notify: a socket for its notices."""

    def __init__(self, folder: Path) -> None:
        self.path = folder / "notify"
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        self._socket.bind(str(self.path))
        self.heard: list[str] = []

    def receive(self, patience_s: float) -> bool:
        """Takes the next notice; False where none comes."""
        self._socket.settimeout(patience_s)
        try:
            self.heard.append(self._socket.recv(4096).decode())
            return True
        except (TimeoutError, BlockingIOError):
            return False

    def await_notices(self, start: str, count: int = 1) -> None:
        while sum(notice.startswith(start) for notice in self.heard) < count:
            assert self.receive(PATIENCE_S), f"in vain: {count} of {start} in {self.heard}"


class FrozenThread:
    """Stops one thread of a process for a while, as a debugger would."""

    SEIZE, INTERRUPT, DETACH, WALL = 0x4206, 0x4207, 17, 0x40000000

    def __init__(self, process: int, name: str) -> None:
        tasks = Path(f"/proc/{process}/task").iterdir()
        (self._task,) = [
            int(task.name) for task in tasks if (task / "comm").read_text().strip() == name
        ]
        self._libc = ctypes.CDLL(None, use_errno=True)

    def _ptrace(self, request: int) -> None:
        arguments = (ctypes.c_long(request), self._task, ctypes.c_void_p(), ctypes.c_void_p())
        if self._libc.ptrace(*arguments) != 0:
            raise OSError(ctypes.get_errno(), os.strerror(ctypes.get_errno()))

    def __enter__(self) -> "FrozenThread":
        self._ptrace(self.SEIZE)
        self._ptrace(self.INTERRUPT)
        os.waitpid(self._task, self.WALL)
        return self

    def __exit__(self, *_: object) -> None:
        self._ptrace(self.DETACH)


def service(folder: Path) -> None:
    """Readiness, reload, and a watchdog that silence feeds and a stuck estimator does not."""
    manager = Manager(folder)
    with Daemon(folder, "", NOTIFY_SOCKET=str(manager.path), WATCHDOG_USEC="1000000") as daemon:
        manager.await_notices("READY=1")
        manager.await_notices("WATCHDOG=1", 3)  # without any input
        manager.await_notices("STATUS=health: failed: no input for")
        daemon.reread("logging:\n  level: debug\n")
        manager.await_notices("RELOADING=1")
        manager.await_notices("READY=1", 2)
        with FrozenThread(daemon.process.pid, "estimator"):
            while manager.receive(0.0):  # sent before it stood still
                pass
            daemon.stand(1.0, START_UTIME)
            assert not manager.receive(3.0), manager.heard[-1]
        daemon.stop(signal.SIGTERM)
        manager.await_notices("STOPPING=1")


def journal(folder: Path) -> None:
    """Where standard error is the journal, lines begin with their level and have no stamp."""
    with open(folder / "log", "w") as log:
        file = os.fstat(log.fileno())
    # The daemon opens the same file again, which keeps its device and inode.
    with Daemon(folder, "", JOURNAL_STREAM=f"{file.st_dev}:{file.st_ino}") as daemon:
        daemon.reread("wheel:\n  scale: abc\n")
        daemon.await_log("<3>config not applied")
        assert daemon.log().startswith("<6>gprodomd ")
        daemon.stop(signal.SIGTERM)


def killed(folder: Path) -> None:
    """kill -9 in mid-drive: the next daemon resumes from the saved pose."""
    config = f"gpr:\n  enabled: false\nstate:\n  directory: {folder}\n"
    robot = Robot(START_UTIME)
    with Daemon(folder, config) as daemon:
        daemon.drive(robot, 5.0, 0.0)
        daemon.drive(robot, 5.0, 0.5)
        daemon.wait_for("poses", lambda: bool(daemon.heard["ODOMETRY"]))
        before = daemon.heard["ODOMETRY"][-1]
        assert before.position[0] > 1.0, before.position
        daemon.wait_for("the pose on disk", lambda: (folder / "pose.state").exists())
        behind = robot.travelled - (robot.utime - before.utime) * 1e-6 * robot.speed
        daemon.process.send_signal(signal.SIGKILL)
        daemon.process.wait()
    robot.travelled += 2.0 * robot.speed  # unheard
    robot.utime += 2_000_000
    with Daemon(folder, config) as daemon:
        daemon.drive(robot, 3.0, 0.5)
        daemon.wait_for("poses", lambda: bool(daemon.heard["ODOMETRY"]))
        assert "resumed from the pose saved" in daemon.log(), daemon.log()
        after = daemon.heard["ODOMETRY"][-1]
        now = robot.travelled - (robot.utime - after.utime) * 1e-6 * robot.speed
        moved = after.position[0] - before.position[0]
        assert abs(moved - (now - behind)) < 0.1, (moved, now - behind)
        assert after.distance > before.distance
        daemon.stop(signal.SIGTERM)


def asked_once(daemon: Daemon, utime: int) -> tuple[int, str, int]:
    """Exit code and words of `gprodom status --once` while the robot stands; utime after it."""
    command = [sys.executable, "-m", "gprodom", "status", "--once"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT) as asked:
        while asked.poll() is None:
            utime = daemon.stand(0.1, utime)
        assert asked.stdout is not None
        return asked.returncode, asked.stdout.read().decode(), utime


def into_a_pipe(daemon: Daemon, utime: int) -> bytes:
    """What `gprodom status` says where there is no screen, until it is ok."""
    command, said = [sys.executable, "-m", "gprodom", "status"], b""
    deadline = time.monotonic() + 4 * PATIENCE_S  # a busy machine starts it slowly
    with subprocess.Popen(command, stdout=subprocess.PIPE) as told:
        assert told.stdout is not None
        while b"\nok: IMU " not in said and time.monotonic() < deadline:
            utime = daemon.stand(0.1, utime)
            if select.select([told.stdout], [], [], 0.0)[0]:
                said += os.read(told.stdout.fileno(), 4096)
        told.terminate()
    return said


def status(folder: Path) -> None:
    """`gprodom status`: healthy, degraded, into a pipe and on a terminal."""
    with Daemon(folder, "gpr:\n  enabled: false\n") as daemon:
        end = daemon.stand(5.0, START_UTIME)
        code, said, end = asked_once(daemon, end)
        assert (code, said.split(":")[0]) == (0, "ok"), said
        assert "standing" in said
        assert " 0 revisits" in said
        lines = into_a_pipe(daemon, end)
        assert b"\nok: IMU " in lines and b"\x1b" not in lines, lines
        daemon.stop(signal.SIGTERM)
    with Daemon(folder, "") as daemon:
        end = daemon.stand(5.0, START_UTIME)
        code, said, end = asked_once(daemon, end)
        assert code == 1, said
        assert said.startswith("degraded (GPR_TRACE: no data for a second or more): "), said
        heard = Heard()
        daemon.lcm.subscribe(".*", heard.take).set_queue_capacity(0)
        parts, text = ("degraded", "standing", "wheel scale", "IMU  ", "solver.mean_ms"), ""
        for _ in range(50):  # a slow machine says at first that it has no input
            end = daemon.stand(0.2, end)
            daemon.lcm.handle_timeout(50)
            shown = Console(record=True, width=100, file=io.StringIO())
            shown.print(page(heard, URL))
            text = shown.export_text()
            if all(part in text for part in parts):
                break
        assert all(part in text for part in parts), text
        daemon.stop(signal.SIGTERM)


def two(folder: Path) -> None:
    """Two daemons on the same channels notice each other, and that one of them has ended."""
    said, quiet = "another estimator publishes on our channels", "gpr:\n  enabled: false\n"
    (folder / "other").mkdir()
    with Daemon(folder, quiet) as daemon:
        end = daemon.stand(5.0, START_UTIME)
        with Daemon(folder / "other", quiet) as other:
            end = daemon.stand(5.0, end)
            daemon.await_log("STATUS: " + said)
            other.await_log("health: degraded")
            code, shown, end = asked_once(daemon, end)
            assert code == 1 and said in shown, shown
            other.stop(signal.SIGTERM)
        time.sleep(3.5)  # a Status counts for 3 s
        daemon.stand(2.0, end)
        daemon.await_log("STATUS: over: " + said)
        daemon.stop(signal.SIGTERM)


SCENARIOS = (two, reread, hostile, service, journal, status, killed)

if __name__ == "__main__":
    (chosen,) = [scenario for scenario in SCENARIOS if scenario.__name__ == sys.argv[1]]
    chosen(Path(sys.argv[2]))
