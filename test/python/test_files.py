"""Outputs: never over an input, by any name or link, and whole or not at all."""

import argparse
import os
import stat
from collections.abc import Iterator
from pathlib import Path

import pytest

from conftest import Cli
from gprodom import files
from gprodom.cli import build_parser
from gprodom.errors import Error, UsageError
from gprodom.files import Output, OutputFile, OutputFolder, replacing, write_bytes

# What these arguments of a type that is no output read. A new option that writes must be an Output.
READ = {
    *("bag", "config", "configs", "estimate", "estimates", "file", "files", "first", "folder"),
    *("layout", "log", "networks", "radar", "scene", "second", "sequence", "sequences", "source"),
    *("sources", "table", "truth", "wheel", "imu", "accelerometer", "gyroscope", "wheel_speed"),
    *("wheel_distance", "wheel_counts", "gpr", "gpr_times", "pipes", "position", "python"),
    *("sensors", "map_file", "fix", "markers"),
}


def leaves(parser: argparse.ArgumentParser) -> Iterator[argparse.ArgumentParser]:
    """The parsers of all commands that do something."""
    nested = [a for a in parser._actions if isinstance(a, argparse._SubParsersAction)]
    if not nested:
        yield parser
    for action in nested:
        for each in action.choices.values():
            yield from leaves(each)


def paths(parser: argparse.ArgumentParser) -> list[argparse.Action]:
    return [
        action
        for action in parser._actions
        if isinstance(action.type, type) and issubclass(action.type, Path)
    ]


def test_every_path_of_a_command_is_an_input_or_an_output() -> None:
    for parser in leaves(build_parser()):
        for action in paths(parser):
            assert isinstance(action.type, type)
            assert issubclass(action.type, Output) or action.dest in READ, (parser.prog, action)


@pytest.mark.parametrize("how", ["name", "symbolic link", "hard link"])
@pytest.mark.parametrize("command", ["export --csv", "plot trajectory -o", "calibrate wheel -o"])
def test_no_command_writes_over_its_input(command: str, how: str, tmp_path: Path, cli: Cli) -> None:
    """Refused before any work: what the file holds does not matter. One place sees to it for all
    commands, by the types of their arguments."""
    *names, option = command.split()
    read = tmp_path / "drive.lcmlog"
    read.write_bytes(b"what the user has")
    link = tmp_path / "other"
    if how == "name":
        link = tmp_path / "." / "x" / ".." / read.name
        (tmp_path / "x").mkdir()
    elif how == "symbolic link":
        link.symlink_to(read)
    else:
        os.link(read, link)
    assert "is an input of this command" in cli.error(*names, read, option, link, code=2)
    assert read.read_bytes() == b"what the user has"
    assert sorted(path.name for path in tmp_path.iterdir() if path.is_file()) == sorted(
        {read.name, *([] if how == "name" else [link.name])}
    )


def test_two_outputs_in_one_file(tmp_path: Path, cli: Cli) -> None:
    log = tmp_path / "a.lcmlog"
    log.touch()
    (tmp_path / "b").symlink_to(tmp_path / "a.csv")
    outputs = ["--csv", tmp_path / "a.csv", "--traces", tmp_path / "b"]
    assert "two outputs in one file" in cli.error("export", log, *outputs, code=2)


def test_what_is_in_a_folder_that_is_read_stays(tmp_path: Path) -> None:
    """A sequence's folder: its tables are not written over; a new file may be put there."""
    sequence = tmp_path / "sequence"
    sequence.mkdir()
    table = sequence / "imu_meas.csv"
    table.write_text("data")
    with files.reading([sequence]):
        with pytest.raises(UsageError, match="exists already"):
            write_bytes(table, b"other")
        write_bytes(sequence / "new.lcmlog", b"log")
    assert table.read_text() == "data"
    write_bytes(table, b"other")  # nothing reads it any more


def test_what_is_found_to_be_read_is_kept_too(tmp_path: Path) -> None:
    header = tmp_path / "line.HD"
    header.write_text("header")
    with files.reading([]):
        files.also_read(header)
        with pytest.raises(UsageError, match="is an input"):
            write_bytes(header, b"other")
    write_bytes(header, b"other")


def test_an_output_is_written_whole_or_not_at_all(tmp_path: Path) -> None:
    path = tmp_path / "out.csv"
    path.write_text("before")
    with pytest.raises(ZeroDivisionError), replacing(path) as part:
        part.write_text("half of")
        _ = 1 / 0
    assert path.read_text() == "before"
    assert list(tmp_path.iterdir()) == [path]


def test_a_full_disk_is_told_with_the_name_of_the_output(tmp_path: Path) -> None:
    path = tmp_path / "out.csv"
    path.write_text("before")
    with pytest.raises(Error, match=r"out\.csv: cannot be written: No space"), replacing(path):
        raise OSError(28, "No space left on device")
    assert path.read_text() == "before"


def test_a_link_stays_and_its_file_is_replaced(tmp_path: Path) -> None:
    path, link = tmp_path / "out.csv", tmp_path / "link"
    path.write_text("before")
    link.symlink_to(path)
    write_bytes(link, b"after")
    assert link.is_symlink()
    assert path.read_text() == "after"


def test_a_pipe_or_a_device_is_written_to_and_not_replaced(tmp_path: Path) -> None:
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    reader = os.open(pipe, os.O_RDONLY | os.O_NONBLOCK)
    try:
        write_bytes(pipe, b"through")
        assert os.read(reader, 100) == b"through"
    finally:
        os.close(reader)
    assert stat.S_ISFIFO(pipe.stat().st_mode)
    write_bytes(Path(os.devnull), b"gone")
    assert stat.S_ISCHR(os.stat(os.devnull).st_mode)


def test_before_the_work(tmp_path: Path) -> None:
    """What cannot be written is told before the work, and not after an hour of it."""
    (tmp_path / "file").touch()
    with pytest.raises(Error, match="does not exist"):
        files.check_outputs([OutputFile(tmp_path / "none" / "out.csv")])
    with pytest.raises(UsageError, match="directory"):
        files.check_outputs([OutputFile(tmp_path)])
    with pytest.raises(UsageError, match="folder"):
        files.check_outputs([OutputFolder(tmp_path / "file")])


# Options of all commands.


@pytest.mark.parametrize(
    ("line", "name", "value"),
    [
        ("score a b --prism -0.1,0,0", "prism", (-0.1, 0.0, 0.0)),
        ("score --prism -.1,-2,-3 a b", "prism", (-0.1, -2.0, -3.0)),
        ("map cut a --area -10,-5,3,3 -o b", "area", (-10.0, -5.0, 3.0, 3.0)),
        ("map cut a --area=-10,-5,3,3 -o b", "area", (-10.0, -5.0, 3.0, 3.0)),
        ("calibrate wheel a --prism -0.1,0", "prism", (-0.1, 0.0)),
        ("score a b --first-m -1e-3", "first_m", -1e-3),
    ],
)
def test_a_value_may_begin_with_a_minus(line: str, name: str, value: object) -> None:
    assert getattr(build_parser().parse_args(line.split()), name) == value


def test_a_datum_south_of_the_equator() -> None:
    line = "export out.lcmlog --datum -33.9,18.4,40 --csv path.csv"
    datum = build_parser().parse_args(line.split()).datum
    assert (datum.latitude, datum.longitude, datum.height) == (-33.9, 18.4, 40.0)


def test_flags_and_what_follows_two_dashes_stay(cli: Cli) -> None:
    args = build_parser().parse_args(["score", "--json", "--plot", "out", "--", "a", "b"])
    assert (args.json, str(args.plot), str(args.truth)) == (True, "out", "b")
    assert "expected one argument" in cli.error("score", "a", "b", "--prism", "--json", code=2)
