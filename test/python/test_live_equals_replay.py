"""One log through the live daemon and through replay: the same poses; and replay from outside."""

import json
import os
import shutil
import signal
import subprocess
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from conftest import CHECKOUT, CONFIG, UNPRIVILEGED, Cli, run_cli, run_program
from gprodom.lcm import EventLog
from gprodom.lcm.logs import Channel, read
from gprodom.lcm.messages import message
from gprodom.odometry.replay import find_program
from packets import write_events

IntArray = NDArray[np.int64]
PAPER = CHECKOUT / "config" / "paper.yaml"


def replay(*words: object, config: Path | None = CONFIG) -> subprocess.CompletedProcess[str]:
    command = [find_program(), *(("-c", config) if config else ()), *words]
    return subprocess.run([*map(str, command)], capture_output=True, text=True, timeout=120)


def simulated(folder: Path, seed: int, distance_m: float, standstill_s: float, config: Path) -> str:
    """Makes in.lcmlog, a simulated drive, and of its replay out.lcmlog, out.tum, out.smoothed.tum
    and out.json. What the replay said."""
    log, outputs = folder / "in.lcmlog", ["-o", folder / "out.lcmlog", "--tum", folder / "out.tum"]
    outputs += ["--smoothed", folder / "out.smoothed.tum", "--stats", folder / "out.json"]
    drive = ["--seed", seed, "--distance", distance_m, "--standstill", standstill_s]
    sequence = folder / "1700000000-0-yard-cmu-gpr"
    run_cli("simulate", *drive, "-o", sequence)
    run_cli("convert", "cmu", sequence, "-o", log)
    result = replay(log, *outputs, "--progress", config=config)
    assert result.returncode == 0, result.stderr
    return result.stderr


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A short drive and its replay."""
    folder = tmp_path_factory.mktemp("replay")
    assert "progress 1.00\n" in simulated(folder, 3, 4.0, 4.0, CONFIG)
    return folder


def run_live(config: Path, log: Path, output: Path, speed: int) -> bool:
    """Whether every result of the radar, the window and the map was there at its data time.

    If not, live need not equal replay to the last bit. So a busy machine gets more time for it.
    """
    command = [CHECKOUT / "scripts" / "live", config, log, output, str(speed)]
    live = subprocess.run(command, capture_output=True, text=True, timeout=120)
    if live.returncode == 3:
        pytest.skip(live.stderr.strip())
    assert live.returncode == 0, live.stderr
    told = read(output, ["STATUS"])["STATUS"]["messages"][-1].names
    late = ("not answered within", "not ready after", "joined with later input")
    in_time = not any(text in name for name in told for text in late)
    return in_time or (speed > 1 and run_live(config, log, output, speed // 2))


def pairs(folder: Path, channel: str) -> tuple[Channel, Channel, IntArray, IntArray]:
    """The channel of replay and live, and which of its messages are those of the same time."""
    ours, theirs = (read(folder / f"{how}.lcmlog", [channel])[channel] for how in ("out", "live"))
    _, at_ours, at_theirs = np.intersect1d(ours["utime"], theirs["utime"], return_indices=True)
    assert len(at_ours) > 0.9 * len(ours["utime"])  # the logger may miss some
    return ours, theirs, at_ours, at_theirs


def check_poses(folder: Path, channel: str, in_time: bool) -> None:
    """The same, live as of replay."""
    ours, theirs, i, j = pairs(folder, channel)
    apart = np.abs(ours["position"][i] - theirs["position"][j])
    assert apart.max() < 0.01
    # A lost message makes more than a rounding error; hardly ever is one lost here.
    assert not in_time or np.median(apart) < 1e-9


def test_live_equals_replay(folder: Path) -> None:
    in_time = run_live(CONFIG, folder / "in.lcmlog", folder / "live.lcmlog", 2)
    for channel in ("ODOMETRY", "ODOMETRY_MAP"):
        check_poses(folder, channel, in_time)


@pytest.fixture(scope="module")
def paper(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A drive long enough for paper.yaml, and its replay."""
    folder = tmp_path_factory.mktemp("paper")
    simulated(folder, 5, 14.0, 3.0, PAPER)
    return folder


def test_paper_config_publishes_at_every_tick(paper: Path) -> None:
    log = read(paper / "out.lcmlog", ["GPR_DISPLACEMENT", "SFM"])
    traces = read(paper / "in.lcmlog", ["GPR_TRACE"])["GPR_TRACE"]["utime"]
    displacements, sfm = log["GPR_DISPLACEMENT"], log["SFM"]
    tick = 500_000
    assert np.all(displacements["utime_to"] - displacements["utime_from"] == tick)
    assert np.all(np.diff(displacements["utime_to"]) == tick)
    assert displacements["utime_to"][0] <= traces[0] + 5_000_000 + 3 * tick  # two windows of 5 s
    assert displacements["utime_to"][-1] >= traces[-1] - 2 * tick
    assert set(displacements["source"].tolist()) == {"sfm"}
    # Once the amplitude scale is fixed every tick has a matrix, and hardly a match fails.
    fixed = displacements["utime_to"] > traces[0] + 21_000_000
    assert np.array_equal(sfm["utime"][-fixed.sum() :], displacements["utime_to"][fixed])
    assert np.all(displacements["utime_to"][displacements["valid"]] > traces[0] + 20_000_000)
    assert displacements["valid"][fixed].mean() > 0.9 and fixed.sum() >= 10
    # All but those still under way at the end are fused.
    values = json.loads((paper / "out.json").read_text())["values"]
    assert values["displacements.used"] >= displacements["valid"].sum() - 3
    assert values["displacements.dropped"] == 0
    for matrix in sfm["messages"]:
        level = np.array(matrix.level)
        assert level.shape == (matrix.rows, matrix.columns) == (50, 50)
        assert level.min() == 0 and 1 <= level.max() <= 10
        assert abs(matrix.column_spacing - 0.1) < 0.02


def test_paper_config_live_equals_replay(paper: Path) -> None:
    in_time = run_live(PAPER, paper / "in.lcmlog", paper / "live.lcmlog", 4)
    ours, theirs, i, j = pairs(paper, "GPR_DISPLACEMENT")
    for field in ("utime_from", "utime_to", "valid", "distance", "sigma", "score"):
        assert np.mean(ours[field][i] == theirs[field][j]) > 0.9, field
    ours, theirs, i, j = pairs(paper, "SFM")
    same = [
        ours["messages"][a].level == theirs["messages"][b].level for a, b in zip(i, j, strict=True)
    ]
    assert np.mean(same) > 0.9
    check_poses(paper, "ODOMETRY", in_time)


@pytest.mark.parametrize("config", [CONFIG, None])
def test_replay_is_repeatable_to_the_byte(folder: Path, config: Path | None) -> None:
    """Without a configuration too, where the defaults hold."""
    outputs = ["-o", folder / "2.lcmlog", "--tum", folder / "2.tum"]
    again = replay(folder / "in.lcmlog", *outputs, config=config)
    assert again.returncode == 0, again.stderr
    assert (folder / "2.lcmlog").read_bytes() == (folder / "out.lcmlog").read_bytes()
    assert (folder / "2.tum").read_bytes() == (folder / "out.tum").read_bytes()


def test_outputs_hold_together(folder: Path) -> None:
    log = read(folder / "out.lcmlog")
    odometry, in_map = log["ODOMETRY"], log["ODOMETRY_MAP"]
    assert np.array_equal(odometry["log_utime"], odometry["utime"])  # stamped with data time
    assert np.array_equal(odometry["position"], in_map["position"])  # no revisits: map is odom
    assert set(log) >= {"ODOMETRY", "ODOMETRY_MAP", "STATUS"} and "TOTAL_STATION" not in log
    trajectory = np.loadtxt(folder / "out.tum")
    assert np.allclose(trajectory[:, 1:4], in_map["position"], atol=1e-9)
    assert np.allclose(trajectory[:, 0], in_map["utime"] * 1e-6, atol=1e-6)

    smoothed = np.loadtxt(folder / "out.smoothed.tum")
    assert np.all(np.diff(smoothed[:, 0]) > 0)
    span = trajectory[-1, 0] - trajectory[0, 0]
    assert 4.5 < len(smoothed) / span < 5.5  # smoother.state_rate
    # No slip in this drive: the two solutions differ by what was learned later, centimetres.
    causal = [np.interp(smoothed[:, 0], trajectory[:, 0], trajectory[:, k]) for k in (1, 2, 3)]
    assert 0 < np.abs(np.transpose(causal) - smoothed[:, 1:4]).max() < 0.2

    stats = json.loads((folder / "out.json").read_text())
    assert stats["published"]["ODOMETRY"] == stats["poses"] == len(odometry["utime"])
    assert stats["read"]["IMU"] == len(read(folder / "in.lcmlog", ["IMU"])["IMU"]["utime"])
    assert stats["unused"] == len(read(folder / "in.lcmlog")["TOTAL_STATION"]["utime"])
    assert stats["refused"] == 0 and stats["damage"] == []
    assert stats["solver"]["jobs"] == len(smoothed) - 1  # the first state is the initialiser's
    assert stats["health"] == "ok" and stats["times_real_time"] > 0
    assert "instance" not in stats["values"]  # a number of the process, which would differ


def test_truncated_log_is_used_as_far_as_it_goes(folder: Path) -> None:
    whole = (folder / "in.lcmlog").read_bytes()
    cut = folder / "cut.lcmlog"
    cut.write_bytes(whole[: len(whole) * 3 // 4 + 5])
    result = replay(cut, "-o", folder / "cut.out.lcmlog")
    assert result.returncode == 0
    assert f"warning: {cut}: event " in result.stderr and "cut off" in result.stderr
    kept = read(folder / "cut.out.lcmlog", ["ODOMETRY"])["ODOMETRY"]
    full = read(folder / "out.lcmlog", ["ODOMETRY"])["ODOMETRY"]
    n = len(kept["utime"])
    assert n > 0.5 * len(full["utime"])
    assert np.array_equal(kept["position"], full["position"][:n])


def test_failures_leave_nothing_behind(folder: Path, tmp_path: Path) -> None:
    log = folder / "in.lcmlog"
    text = tmp_path / "text"
    text.write_text("no log, but long enough to be mistaken for one\n")
    link, config = tmp_path / "link", tmp_path / "config.yaml"
    link.symlink_to(log)
    config.write_text("{}\n")
    before = log.read_bytes()
    for arguments, code, said in [
        ([log], 2, "-o OUT.lcmlog is needed"),
        (["-o", tmp_path / "x"], 2, "expected one IN.lcmlog"),
        ([tmp_path / "none", "-o", tmp_path / "x"], 1, "none: cannot be read: No such file"),
        ([text, "-o", tmp_path / "x"], 1, "text: expected an LCM log"),
        ([log, "-o", tmp_path / "no" / "x"], 1, "cannot be written: No such file or directory"),
        ([log, "-o", log], 1, "is an input file"),
        ([log, "-o", tmp_path / "x", "--stats", log], 1, "is an input file"),
        ([log, "-o", tmp_path / "x", "--tum", link], 1, "is an input file"),
        ([log, "-o", tmp_path / "x", "-c", config, "--stats", config], 1, "is an input file"),
        ([log, "-o", tmp_path / "x", "--tum", tmp_path / "x"], 1, "two outputs in one file"),
        ([log, "-o", tmp_path / "x", "--set", "wheel.scale=no"], 1, "--set wheel.scale=no: expec"),
        ([log, "-o", "/dev/full"], 1, "/dev/full: cannot be written: No space left on device"),
    ]:
        result = replay(*arguments)
        assert (result.returncode, said in result.stderr) == (code, True), result.stderr
    assert {file.name for file in tmp_path.iterdir()} == {"text", "link", "config.yaml"}
    assert log.read_bytes() == before and config.read_text() == "{}\n"


def short_log(path: Path, source: Path, seconds: float, gravity: float = 9.80665) -> Path:
    """The first seconds of IMU and wheel; the accelerometer in other units."""
    events, first = [], 0
    for event in EventLog(str(source), "r"):
        first = first or event.timestamp
        if event.timestamp > first + seconds * 1e6 or event.channel not in ("IMU", "WHEEL"):
            continue
        data = event.data
        if event.channel == "IMU":
            imu = message("imu_t").decode(data)
            imu.linear_acceleration = [x * gravity / 9.80665 for x in imu.linear_acceleration]
            data = imu.encode()
        events.append((event.timestamp, event.channel, data))
    return write_events(path, events)


def test_no_pose_is_a_failure_with_its_reason_in_every_program(
    folder: Path, tmp_path: Path, cli: Cli
) -> None:
    in_g = short_log(tmp_path / "g.lcmlog", folder / "in.lcmlog", 4.0, gravity=1.0)
    brief = short_log(tmp_path / "brief.lcmlog", folder / "in.lcmlog", 1.0)
    for log, settings, reason in [
        (in_g, [], "start: specific force 1.0"),
        (brief, [], "start: collecting initializer.duration of standstill"),
        (brief, ["--set", "channels.imu=OTHER"], "the log has no message on channel OTHER"),
    ]:
        outputs = ["-o", tmp_path / "out.lcmlog", "--smoothed", tmp_path / "out.tum"]
        replayed = replay(log, *outputs, *settings)
        assert replayed.returncode == 1, replayed.stderr
        said = replayed.stderr.splitlines()[-1].removeprefix("gprodom-replay: ")
        assert said.startswith(f"no pose was estimated: {reason}"), replayed.stderr
        assert (tmp_path / "out.lcmlog").exists() and not (tmp_path / "out.tum").exists()
        command = ["run", log, "--method", "imu_wheel", "-c", CONFIG, *settings]
        said = cli.error(*command, "--set", "gpr.enabled=true").splitlines()[-1]
        assert said.startswith(f"gprodom: error: no pose was estimated: {reason}")


def test_run_reports_the_warnings_of_replay_unchanged(
    folder: Path, tmp_path: Path, cli: Cli
) -> None:
    bounded = ["--set", "wheel.max_speed=0.05"]  # drops most of the wheel, which is reported
    replayed = replay(folder / "in.lcmlog", "-o", tmp_path / "out.lcmlog", *bounded, config=CONFIG)
    warnings = [line for line in replayed.stderr.splitlines() if line.startswith("warning: ")]
    assert replayed.returncode == 0 and warnings
    method = ["--method", "gprodom_full", "-c", CONFIG, *bounded]
    said = cli("run", folder / "in.lcmlog", *method).err.splitlines()
    assert [line for line in said if "warning" in line] == [f"gprodom: {each}" for each in warnings]


def test_interrupted_replay_leaves_nothing_behind(folder: Path, tmp_path: Path) -> None:
    # The daemon's own input many times over, so that there is time to interrupt.
    long_log = tmp_path / "long.lcmlog"
    with open(long_log, "wb") as out:
        for _ in range(40):
            out.write((folder / "in.lcmlog").read_bytes())
    command = [find_program(), "-c", CONFIG, long_log, "-o", tmp_path / "out", "--progress"]
    process = subprocess.Popen(
        [str(part) for part in command], stderr=subprocess.PIPE, stdout=subprocess.DEVNULL
    )
    assert process.stderr is not None
    process.stderr.readline()  # under way
    process.send_signal(signal.SIGTERM)
    said = process.communicate(timeout=30)[1]
    assert process.returncode == 1
    assert b"interrupted; nothing was written" in said
    assert [file.name for file in tmp_path.iterdir()] == ["long.lcmlog"]


def test_runs_unprivileged(folder: Path, open_folder: Path) -> None:
    if os.geteuid() != 0:
        pytest.skip("not root: the other tests run unprivileged already")
    command = [*UNPRIVILEGED, str(find_program()), "--version"]
    if subprocess.run(command, capture_output=True).returncode != 0:
        pytest.skip("other users cannot run this checkout's programs")
    log, out = open_folder / "in.lcmlog", open_folder / "out.lcmlog"
    shutil.copy(folder / "in.lcmlog", log)
    log.chmod(0o644)
    run_program(*UNPRIVILEGED, find_program(), "-c", CONFIG, log, "-o", out)
    assert out.read_bytes() == (folder / "out.lcmlog").read_bytes()
