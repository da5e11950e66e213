"""Channels by the names that the configuration gives them, in every command that reads logs."""

from dataclasses import asdict
from pathlib import Path

import pytest
import yaml

import gprodom
from conftest import CONFIG, Cli, run_cli
from gprodom.config import STANDARD, Channels, read_channels
from gprodom.errors import Error
from gprodom.lcm import EventLog

RENAMED = {role: f"R2_{name}" for role, name in asdict(STANDARD).items()}


def channels_of(log: Path) -> set[str]:
    return {event.channel for event in EventLog(str(log), "r")}


@pytest.fixture(scope="module")
def config(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("config") / "renamed.yaml"
    path.write_text(yaml.safe_dump({"channels": RENAMED, "wheel": {"scale_sigma": 0.01}}))
    return path


@pytest.fixture(scope="module")
def sequence(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("drive") / "1700000000-0-yard-cmu-gpr.zip"
    drive = ["--route", "loop", "--distance", "14", "--seed", "3"]
    run_cli("simulate", *drive, "-o", path)
    return path


@pytest.fixture(scope="module")
def log(sequence: Path, config: Path) -> Path:
    path = sequence.parent / "input.lcmlog"
    run_cli("convert", "cmu", sequence, "-o", path, "-c", config)
    return path


@pytest.fixture(scope="module")
def replayed(log: Path, config: Path) -> Path:
    path = log.parent / "output.lcmlog"
    method = ["--method", "gprodom_full", "-o", str(path)]
    run_cli("run", log, *method, "-c", config)
    return path


def test_the_standard_names_are_those_of_the_default_configuration() -> None:
    section = yaml.safe_load(CONFIG.read_text())["channels"]
    assert section.pop("prefix") == ""
    assert asdict(STANDARD) == section
    assert read_channels() == STANDARD


def test_a_prefix_stands_before_the_names_left_at_their_defaults(tmp_path: Path) -> None:
    config = tmp_path / "robot.yaml"
    config.write_text("channels:\n  prefix: R2_\n  wheel: LEFT\n")
    channels = asdict(read_channels([config]))
    assert channels == {**RENAMED, "wheel": "LEFT"}
    assert asdict(read_channels([config], ["channels.prefix=A"]))["imu"] == "AIMU"
    described = tmp_path / "described.yaml"
    described.write_text(gprodom.describe_config(["channels.prefix=R2_", "channels.wheel=LEFT"]))
    assert asdict(read_channels([described])) == channels


def test_names_come_from_file_and_overrides(tmp_path: Path) -> None:
    file = tmp_path / "gprodom.yaml"
    file.write_text("channels:\n  imu: XSENS\n  wheel: ENCODER\nimu:\n  time_offset: 0.1\n")
    found = read_channels([file], ["wheel.scale=0.9", "channels.wheel=LEFT"])
    assert found == Channels(imu="XSENS", wheel="LEFT")
    file.write_text("wheel:\n  scale: 1.0\n")
    assert read_channels([file]) == STANDARD


def test_a_later_file_overrides_earlier_ones(tmp_path: Path, log: Path, config: Path) -> None:
    other = tmp_path / "other.yaml"
    other.write_text("channels:\n  odometry: THERE\n")
    names = Channels(**{**RENAMED, "odometry": "THERE"})
    assert read_channels([config, other]) == names
    output = tmp_path / "output.lcmlog"
    run = ["run", str(log), "--method", "imu_wheel", "-o", str(output)]
    run_cli(*run, "-c", config, "-c", other)
    assert {"THERE", names.odometry_map} < channels_of(output)
    assert RENAMED["odometry"] not in channels_of(output)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("channels:\n  imus: XSENS\n", "channels.imus: unknown key"),
        ("channels:\n  imu: 3\n", "channels.imu: expected the name of a channel"),
        ("channels: [IMU]\n", "channels: expected the names"),
        ("channels: {imu: [\n", "gprodom.yaml: while parsing"),
    ],
)
def test_a_wrong_configuration_is_told_of(tmp_path: Path, text: str, said: str) -> None:
    file = tmp_path / "gprodom.yaml"
    file.write_text(text)
    with pytest.raises(Error, match=said):
        read_channels([file])


def test_replay_and_daemon_use_renamed_channels(log: Path, replayed: Path) -> None:
    names = Channels(**RENAMED)
    assert channels_of(log) == {names.imu, names.wheel, names.gpr_trace, "TOTAL_STATION"}
    assert {names.odometry, names.odometry_map, names.displacement} < channels_of(replayed)
    assert not channels_of(replayed) & set(asdict(STANDARD).values())


def test_methods_and_scores_read_renamed_channels(
    sequence: Path, log: Path, replayed: Path, config: Path, cli: Cli
) -> None:
    run = ["--truth", log, "-c", config, "--method"]
    radar = ["--set", "paper.k=0.05"]
    errors = {}
    for method, more in (("wheel", []), ("gpr_sfm", radar), ("gprodom_full", [])):
        errors[method] = cli.json("run", log, *run, method, *more)["ate_rmse_m"]
    scored = cli.json("score", replayed, sequence, "-c", config)
    assert scored["ate_rmse_m"] == pytest.approx(errors["gprodom_full"])
    assert scored["map_jumps"] is not None  # corrections and odometry were found, too
    # The sequence itself is converted to the same channels.
    assert cli.json("run", sequence, *run, "wheel")["ate_rmse_m"] == pytest.approx(errors["wheel"])


def test_calibration_and_pictures_read_renamed_channels(
    tmp_path: Path, log: Path, replayed: Path, config: Path, cli: Cli
) -> None:
    for what in ("wheel", "time"):
        cli("calibrate", what, log, "-c", config)
    for command in (
        ("log", replayed, "--wheel", log),
        ("revisits", replayed),
        ("trajectory", replayed),
        ("radar", log, "--at", "8"),
    ):
        cli("plot", *command, "-c", config, "-o", tmp_path / "picture.png")
    # By the standard names there is nothing in it.
    assert "channels.wheel" in cli.error("calibrate", "wheel", log)


def test_a_benchmark_reads_and_makes_renamed_channels(
    tmp_path: Path, log: Path, config: Path, cli: Cli
) -> None:
    simulated = ["--simulate", "2", "--grounds", "rays", "--distance", "8"]
    methods = ["--methods", "wheel,gpr_sfm,imu_wheel", "-j1", "-o", tmp_path]
    records = cli.json("benchmark", *simulated, *methods, "-c", config)["records"]
    assert {record["method"] for record in records} == {"wheel", "gpr_sfm", "imu_wheel"}
    for made in (tmp_path / "simulated").glob("*.lcmlog"):
        assert channels_of(made) <= {*RENAMED.values(), "TOTAL_STATION"}
