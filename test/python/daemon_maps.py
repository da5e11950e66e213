"""As daemon_scenario.py: what a running gprodomd does with its maps."""

import os
import signal
import subprocess
import sys
from pathlib import Path

from daemon_scenario import PATIENCE_S, URL, Daemon
from gprodom.odometry.replay import find_program


def player(folder: Path) -> subprocess.Popen[bytes]:
    """A player of the drive."""
    command = ["/usr/bin/lcm-logplayer", "--speed=4", f"--lcm-url={URL}", folder / "in.lcmlog"]
    return subprocess.Popen(command, stdout=subprocess.DEVNULL)


def length_of_map(path: Path) -> float:
    """In metres, by the extension of the ordinary build: the sanitizers' builds have none."""
    code = """
import pathlib, sys
from gprodom.map.ground import read_map
print(read_map(pathlib.Path(sys.argv[1])).length_m)
"""
    ordinary = {name: value for name, value in os.environ.items() if name != "GPRODOM_BUILD"}
    command = [sys.executable, "-c", code, str(path)]
    return float(subprocess.run(command, env=ordinary, stdout=subprocess.PIPE, check=True).stdout)


def ground(folder: Path) -> None:
    """A recorded drive (FOLDER/in.lcmlog) with all that is kept and asked for meanwhile.

    Each of the daemon's threads works and hands on here; scripts/check-sanitizers watches them.
    """
    keep = f"state:\n  directory: {folder}\n  save_period: 0.02\n"

    def value(daemon: Daemon, name: str) -> float:
        status = daemon.heard["STATUS"][-1]
        return dict(zip(status.names, status.values, strict=True)).get(name, 0.0)

    def played(daemon: Daemon, played_s: float) -> bool:
        heard = daemon.heard["ODOMETRY"]
        return bool(heard) and heard[-1].utime - heard[0].utime > played_s * 1e6

    with Daemon(folder, keep) as daemon, player(folder) as log:
        daemon.wait_for("poses of 20 s", lambda: played(daemon, 20.0), 40.0)
        daemon.command("save_map", "half")
        daemon.reread(keep + "logging:\n  level: debug\n")
        daemon.await_log("half.map: saved")
        daemon.wait_for("end of the log", lambda: log.poll() is not None, 60.0)
        daemon.wait_for("revisits", lambda: value(daemon, "revisits.trusted") > 0, 40.0)
        daemon.stop(signal.SIGTERM)
    assert {"ground.map", "half.map", "pose.state", "wheel.state"} <= set(os.listdir(folder))
    with Daemon(folder, keep) as daemon, player(folder) as log:
        daemon.wait_for("poses of 10 s", lambda: played(daemon, 10.0), 40.0)
        daemon.command("reset")
        daemon.await_log("reset by command")
        daemon.command("load_map", "half")
        daemon.await_log("map half loaded")
        daemon.reread(keep + "wheel:\n  scale: 0.99\n")
        daemon.await_log("the estimator restarts with the new config")
        heard = len(daemon.heard["ODOMETRY"])
        daemon.wait_for("poses", lambda: len(daemon.heard["ODOMETRY"]) > heard, 40.0)
        daemon.stop(signal.SIGTERM)  # amid the drive
        log.terminate()


def reload(folder: Path) -> None:
    """SIGHUP in mid-drive (FOLDER/in.lcmlog) with a change that restarts the estimator, then the
    end: the ground of before is there."""
    keep = f"state:\n  directory: {folder}\n"
    with Daemon(folder, keep) as daemon, player(folder) as log:
        heard = daemon.heard["ODOMETRY"]

        def driven() -> bool:
            return bool(heard) and heard[-1].distance - heard[0].distance > 12.0

        daemon.wait_for("12 m", driven, 60.0)
        log.terminate()
        daemon.reread(keep + "wheel:\n  max_speed: 4.5\n")
        daemon.await_log("the estimator restarts with the new config")
        daemon.stop(signal.SIGTERM)
    assert length_of_map(folder / "ground.map") > 5.0
    with Daemon(folder, keep) as daemon:
        (folder / "other").mkdir()
        (folder / "other" / "c.yaml").write_text(keep)
        other = [str(find_program("gprodomd")), "-c", str(folder / "other" / "c.yaml")]
        refused = subprocess.run(other, capture_output=True, text=True, timeout=PATIENCE_S)
        assert refused.returncode == 1, refused
        assert f"in use by another estimator (process {daemon.process.pid})" in refused.stderr
        checked = subprocess.run([*other, "--check-config"], capture_output=True, text=True)
        assert checked.returncode == 0, checked.stderr
        with Daemon(folder / "other", "") as elsewhere:
            elsewhere.reread(keep)
            elsewhere.await_log("config not applied, the old one goes on: ")
            elsewhere.stop(signal.SIGTERM)
        daemon.stop(signal.SIGTERM)


if __name__ == "__main__":
    {"ground": ground, "reload": reload}[sys.argv[1]](Path(sys.argv[2]))
