"""gprodom view: what a recording holds, live as from a log, and that nothing leaves the machine."""

import os
import re
import subprocess
import sys
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from conftest import Cli, run_cli, run_isolated
from gprodom.lcm import EventLog
from gprodom.lcm.messages import fingerprint
from made_drive import RADIUS, SECONDS, SLIPS_S, SPEED, STANDS_S, START_US, place, spread

pytest.importorskip("rerun", reason="rerun-sdk (the extra view) is not installed")

from gprodom.config import STANDARD
from gprodom.drive.imu_mounting import ImuMounting, matrix_of, read_mounting
from gprodom.drive.imu_speed import imu_speed
from gprodom.errors import Error
from gprodom.view.live import ROLES, Live
from gprodom.view.record import Recorder, cut, new_stream


def rows(recording: Path) -> dict[str, dict[str, Any]]:
    """By entity the columns of all its rows: times (s after START_US) in "time"."""
    from rerun.chunk import RrdReader

    found: dict[str, dict[str, list[Any]]] = {}
    for chunk in RrdReader(recording).stream().to_chunks():
        columns = found.setdefault(chunk.entity_path, {})
        for name, values in chunk.to_record_batch().to_pydict().items():
            columns.setdefault(name.rsplit(":")[-1], []).extend(values)
    for columns in found.values():
        if "time" in columns:
            stamps = np.array(columns["time"], "datetime64[us]").astype(np.int64)
            columns["time"] = ((stamps - START_US) * 1e-6).tolist()
    return found


@pytest.fixture(scope="module")
def shown(made_log: Path) -> dict[str, dict[str, Any]]:
    path = made_log.with_name("drive.rrd")
    run_cli("view", made_log, "-o", path)
    return rows(path)


def check_reckoning(found: dict[str, dict[str, Any]]) -> None:
    """Of a perfect wheel and gyro it is the circle that was driven, without a gap, to its end."""
    strips = [np.array(strip[0]) for strip in found["/way/wheel_and_gyro"]["strips"]]
    for one, other in pairwise(strips):
        np.testing.assert_allclose(one[-1], other[0], atol=1e-5)
    way = np.concatenate(strips)[:, :2]
    np.testing.assert_allclose(np.linalg.norm(way - [0.0, RADIUS], axis=1), RADIUS, atol=0.05)
    np.testing.assert_allclose(way[-1], place(SECONDS), atol=0.15)


def check_drive(found: dict[str, dict[str, Any]], slack_s: float) -> None:
    """What both a log and the live view must show of the made-up drive."""
    way = np.concatenate([np.array(strip[0]) for strip in found["/way/map"]["strips"]])
    centre = np.linalg.norm(way[:, :2] - [0.0, RADIUS], axis=1)
    np.testing.assert_allclose(centre, RADIUS, atol=1e-3)
    speed = np.array(found["/speed/wheel"]["scalars"]).ravel()
    time = np.array(found["/speed/wheel"]["time"])
    inside = (time > STANDS_S + 1) & (time < SECONDS - 2)
    np.testing.assert_allclose(speed[inside], SPEED, atol=0.01)
    assert np.all(np.diff(time) > 0) and len(time) > 900
    # A lane changes where the robot begins and ceases to slip.
    lane = found["/state/slipping"]
    changes = [(t, s[0]) for t, s in zip(lane["time"], lane["state"], strict=True) if s is not None]
    edges = sorted(edge for span in SLIPS_S for edge in span)
    np.testing.assert_allclose([t for t, s in changes][-4:], edges, atol=slack_s)
    assert [s for _, s in changes][-4:] == ["yes", "", "yes", ""]
    health = [s[0] for s in found["/state/health"]["state"] if s is not None]
    assert health == ["ok", "degraded", "ok"]
    # Two revisits: from where the robot was then to where it is now, and as arcs along the way.
    links = [np.array(strip[0]) for strip in found["/way/revisits"]["strips"]]
    assert len(links) == 2
    for (then, now), link in zip(((20, 100), (30, 110)), links, strict=True):
        for t, end in zip((then, now), link, strict=True):
            np.testing.assert_allclose(end[:2], place(t), atol=0.05)
    assert len(found["/ground_along_the_way/revisits"]["strips"]) == 2


def test_recording_of_a_log(shown: dict[str, dict[str, Any]]) -> None:
    check_drive(shown, 0.1)
    assert np.ptp(shown["/way/map"]["time"]) > SECONDS - 3  # the line grows with time
    told = [text[0] for text in shown["/told"]["text"]]
    assert told[0].startswith("GPR_TRACE: no data") and "map: searching for earlier ground" in told
    check_reckoning(shown)


def check_same(live: dict[str, dict[str, Any]], of_log: dict[str, dict[str, Any]]) -> None:
    """The way in odom begins and ends at the same places; the speed by the IMU is the same."""
    strips = [found["/way/odom"]["strips"] for found in (live, of_log)]
    lines = [[point for row in rows for strip in row for point in strip] for rows in strips]
    for end in (0, -1):
        np.testing.assert_allclose(lines[0][end], lines[1][end], atol=0.05)
    time, speed = (
        [np.ravel(found["/speed/IMU"][name]) for found in (live, of_log)]
        for name in ("time", "scalars")
    )
    assert len(time[0]) > 0.9 * len(time[1])
    off = np.abs(speed[0] - np.interp(time[0], time[1], speed[1].astype(float)))
    assert np.mean(off > 0.05) < 0.01  # where the drive of the test starts, it starts at once


def test_ring_holds_95_percent(shown: dict[str, dict[str, Any]]) -> None:
    ring = shown["/way/ring"]
    kept = [(t, m) for t, m in zip(ring["time"], ring["mat3x3"], strict=True) if m is not None]
    for t, matrix in kept[:: len(kept) // 10]:
        axes = np.array(matrix).reshape(3, 3).T[:2, :2]  # Rerun stores columns
        np.testing.assert_allclose(axes @ axes.T, 2.4477**2 * spread(t), rtol=0.01)


def shown_live(log: Path, path: Path, mounting: ImuMounting) -> dict[str, dict[str, Any]]:
    """The messages of the log, taken one by one and sent every half second."""
    stream = new_stream("live")
    stream.save(path)
    live = Live(Recorder(stream), STANDARD.of(*ROLES), mounting)
    due = START_US
    for event in EventLog(str(log), "r"):
        if event.channel in STANDARD.of(*ROLES).values():
            live.take(event.channel, event.data)
        if event.timestamp >= due:
            live.send()
            due = event.timestamp + 500_000
    live.finish()
    stream.flush()
    stream.disconnect()
    return rows(path)


def test_live_view_shows_the_same(
    made_log: Path, tmp_path: Path, shown: dict[str, dict[str, Any]]
) -> None:
    found = shown_live(made_log, tmp_path / "live.rrd", ImuMounting())
    check_drive(found, 0.2)
    check_reckoning(found)
    check_same(found, shown)
    # A trace that comes is a column of the ground by time; the robot moved 1 m in 2 s.
    pieces = [name for name in found if re.fullmatch(r"/ground_by_time/pieces/\d+", name)]
    assert len(pieces) == -(-SECONDS * 10 // 256)
    along = [name for name in found if re.fullmatch(r"/ground_along_the_way/pieces/\d+", name)]
    # Where no pose was published, the robot is where it was last: the ground there is not drawn.
    assert len(along) >= SPEED * (SECONDS - STANDS_S) / 0.02 / 256 - 1


def test_a_message_of_another_type_does_not_end_the_live_view(tmp_path: Path) -> None:
    stream = new_stream("live")
    stream.save(tmp_path / "live.rrd")
    live = Live(Recorder(stream), STANDARD.of(*ROLES), ImuMounting())
    for channel in STANDARD.of(*ROLES).values():
        live.take(channel, b"not one of ours, but long enough")
        live.take(channel, b"short")
        live.take(channel, fingerprint("odometry_t") + b"ours, but damaged")
    live.send()


def test_pieces_join_and_cover_all() -> None:
    time = np.array([0, 10, 20, 35, 36, 90, 91])
    pieces = cut(time, 30)
    assert pieces[0][0] == 0 and pieces[-1][1] == len(time) - 1
    assert all(a[1] == b[0] for a, b in pairwise(pieces))
    assert cut(time[:1], 30) == []


def test_without_rerun_it_says_how_to_get_it(
    made_log: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, cli: Cli
) -> None:
    monkeypatch.setitem(sys.modules, "rerun", None)
    assert "pip install 'gprodom[view]'" in cli.error("view", made_log, "-o", tmp_path / "a.rrd")
    assert not list(tmp_path.iterdir())


def test_usage(made_log: Path, tmp_path: Path, cli: Cli) -> None:
    output = tmp_path / "a.rrd"
    for arguments in ([], [made_log, "--live"], [made_log, "-o", output, "--web"]):
        assert cli.error("view", *arguments, code=2).count("\n") == 1


# In a network of its own: what the process and its children listen on and where they connect to, by
# the system calls. A page is fetched meanwhile.
WATCHED = """
import os, re, signal, subprocess, sys, time, urllib.request
trace, port, *command = sys.argv[1:]
env = {**os.environ, "FORCE_RERUN_ANALYTICS": "1", "HOME": os.path.dirname(trace)}
env.pop("CI", None)
watched = ["strace", "-f", "-qq", "-e", "trace=connect,bind,sendto", "-o", trace, *command]
process = subprocess.Popen(watched, env=env, start_new_session=True)
page = b""
for _ in range(300):
    try:
        page = urllib.request.urlopen(f"http://127.0.0.1:{port}/", timeout=2).read(); break
    except OSError:
        time.sleep(0.1)
time.sleep(4.0)  # for what it may want to send after its start
listening = subprocess.run(["ss", "-tlnH"], capture_output=True, text=True).stdout
os.killpg(process.pid, signal.SIGINT)
try:
    process.wait(10)
except subprocess.TimeoutExpired:
    os.killpg(process.pid, signal.SIGKILL)
print(len(page)); print(listening)
"""


def watched(folder: Path, command: list[str]) -> tuple[int, set[str], set[str], str]:
    """Bytes of the page, addresses listened on, addresses of others connected to, and stderr."""
    trace = folder / "trace"
    done = run_isolated(WATCHED, trace, "9411", *command, timeout_s=180)
    size, *listening = done.stdout.splitlines()
    listened = {line.split()[3].rsplit(":", 1)[0] for line in listening if line.strip()}
    calls = re.findall(r"(?:connect|sendto)\(.*?sin6?_addr[=(].*", trace.read_text())
    reached = {found for call in calls for found in re.findall(r'"([0-9a-f.:]+)"', call)}
    others = {each for each in reached if not each.startswith(("127.", "::1", "0.0.0.0"))}
    return int(size), listened, others, done.stderr


@pytest.fixture
def a_resolver() -> Iterator[None]:
    """Where the names of hosts cannot be asked for, no attempt to send would be seen."""
    text = Path("/etc/resolv.conf")
    if not text.is_file() or "nameserver" not in text.read_text():
        pytest.skip("/etc/resolv.conf names no server: that something is sent would not be seen")
    yield


@pytest.mark.usefixtures("a_resolver")
@pytest.mark.parametrize("live", [False, True])
@pytest.mark.parametrize("address", ["127.0.0.1", "0.0.0.0"])
def test_nothing_leaves_and_nobody_else_can_reach_it(
    made_log: Path, tmp_path: Path, live: bool, address: str
) -> None:
    """A viewer that could not read that statistics are off would welcome to its first session, in
    which it only says that it will send them."""
    view = [sys.executable, "-m", "gprodom", "view", "--live" if live else str(made_log)]
    view += ["--web", "--web-port", "9411", "--address", address]
    size, listened, reached, said = watched(tmp_path, view)
    assert size > 100
    assert address in listened and listened <= {address, "127.0.0.1"}
    # The group of LCM, which the live view listens to.
    assert not {each for each in reached if not each.startswith("239.255.")}
    assert "usage data" not in said and "analytics" not in said


@pytest.mark.usefixtures("a_resolver")
def test_left_to_itself_the_viewer_would_be_seen_to_send(made_log: Path, tmp_path: Path) -> None:
    """The measurement itself, on the viewer as it comes."""
    recording = made_log.with_name("alone.rrd")
    run_cli("view", made_log, "-o", recording)
    rerun = [sys.executable, "-m", "rerun"]
    # At its first start it only says that it will.
    home = {**os.environ, "HOME": str(tmp_path)}
    subprocess.run([*rerun, "analytics", "enable"], env=home, check=True, capture_output=True)
    alone = [*rerun, str(recording), "--serve-web", "--web-viewer-port", "9411"]
    _, listened, reached, _ = watched(tmp_path, alone)
    assert "0.0.0.0" in listened
    assert reached


@pytest.mark.parametrize("arm", [(0.0, 0.0, 0.0), (0.5, -0.3, 0.0)])
def test_speed_by_the_imu_follows_what_the_wheel_does_not_show(
    arm: tuple[float, float, float],
) -> None:
    """Mounted askew and beside the origin, on a slope, with a bias; it turns to and fro."""
    seconds = np.arange(0, 20, 0.01)
    speed = 0.5 + 0.4 * np.sin(seconds)
    slope, bias, rpy = 0.1, 0.05, (0.2, -0.3, 1.1)
    body = np.zeros((len(seconds), 3))  # nose up: gravity pulls backwards, the force is forwards
    body[:, 0] = 0.4 * np.cos(seconds) + 9.81 * np.sin(slope) + bias
    body[:, 2] = 9.81 * np.cos(slope)
    turn, faster = 0.8 * np.sin(0.7 * seconds), 0.56 * np.cos(0.7 * seconds)  # rad/s, rad/s^2
    body[:, 0] -= turn**2 * arm[0] + faster * arm[1]
    body[:, 1] += faster * arm[0] - turn**2 * arm[1]
    imu = {
        "utime": START_US + np.round(1e6 * seconds).astype(np.int64),
        "linear_acceleration": body @ matrix_of(rpy),  # R_imu_body f
        "angular_velocity": np.outer(turn, [0.0, 0.0, 1.0]) @ matrix_of(rpy),
    }
    rows = slice(None, None, 5)
    poses = len(seconds[rows])
    level = np.array([np.cos(slope / 2), 0.0, -np.sin(slope / 2), 0.0])  # pitched up
    odometry = {
        "utime": imu["utime"][rows],
        "orientation": np.tile(level, (poses, 1)),
        "accel_bias": np.tile([bias, 0.0, 0.0], (poses, 1)),
        "velocity": np.column_stack([speed[rows], np.zeros((poses, 2))]),
    }
    time, told = imu_speed(imu, odometry, ImuMounting(rpy, arm))
    truth = 0.5 + 0.4 * np.sin((time - START_US) * 1e-6)
    assert len(time) == poses - 20
    np.testing.assert_allclose(told, truth, atol=2e-3 if not any(arm) else 0.02)


def test_the_place_of_the_imu_is_taken_into_account(made_log: Path, tmp_path: Path) -> None:
    """On the circle an IMU that feels no force 20 m ahead feels one of 20 w^2 at the origin."""
    recording = tmp_path / "log.rrd"
    run_cli("view", made_log, "-o", recording, "--set", "imu.lever_arm=[20, 0, 0]")
    live = shown_live(made_log, tmp_path / "live.rrd", ImuMounting(arm=(20.0, 0.0, 0.0)))
    for found in (rows(recording), live):
        time, speed = (np.ravel(found["/speed/IMU"][name]) for name in ("time", "scalars"))
        after = speed[(time > STANDS_S + 2) & (time < SECONDS - 2)].astype(float)
        assert np.median(after) == pytest.approx(SPEED + 20 * (SPEED / RADIUS) ** 2, abs=0.01)


def test_mounting_of_the_imu_comes_from_the_configuration(tmp_path: Path) -> None:
    (tmp_path / "robot.yaml").write_text("imu: {rpy_body_imu: [0.1, 0, 1.5]}\n")
    config = [tmp_path / "robot.yaml"]
    assert read_mounting(config) == ImuMounting((0.1, 0.0, 1.5))
    settings = ["imu.rpy_body_imu=[0, 0, 2]", "imu.lever_arm=[0.5, 0, 0.1]"]
    assert read_mounting(config, settings) == ImuMounting((0.0, 0.0, 2.0), (0.5, 0.0, 0.1))
    with pytest.raises(Error, match="three angles"):
        read_mounting(config, ["imu.rpy_body_imu=[0, 0]"])
    assert read_mounting(config, ["imu.rpy_body_imu=auto"]).rpy == (0.0, 0.0, 0.0)
    with pytest.raises(Error, match="in metres, found"):
        read_mounting(config, ["imu.lever_arm=[0, 0]"])


LIVE = """
import signal, subprocess, sys, time
from gprodom.lcm import DEFAULT_URL, LCM, EventLog
log, recording = sys.argv[1:]
view = subprocess.Popen(
    [sys.executable, "-m", "gprodom", "view", "--live", "-o", recording],
    stderr=subprocess.PIPE, text=True)
lcm = LCM(DEFAULT_URL)
events = [each for each in EventLog(log, "r")][:4000]
for round in range(100):  # until it listens
    for event in events[40 * round : 40 * (round + 1)]:
        lcm.publish(event.channel, event.data)
    time.sleep(0.1)
view.send_signal(signal.SIGINT)
print(view.wait(30), view.stderr.read())
"""


def test_live_view_of_the_network_ends_with_what_it_heard(made_log: Path, tmp_path: Path) -> None:
    recording = tmp_path / "live.rrd"
    done = run_isolated(LIVE, made_log, recording, timeout_s=120)
    assert done.stdout.startswith("0 "), done.stdout
    assert "Traceback" not in done.stdout
    found = rows(recording)
    assert found["/way/map"]["strips"] and found["/speed/wheel"]["scalars"]
