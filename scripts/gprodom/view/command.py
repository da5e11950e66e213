"""``gprodom view``."""

import argparse
import os
import signal
import subprocess
from pathlib import Path
from typing import Any

from gprodom.config import Channels, read_channels
from gprodom.drive.imu_mounting import read_mounting
from gprodom.errors import UsageError
from gprodom.files import replacing, temporary_folder
from gprodom.lcm import DEFAULT_URL, connect
from gprodom.options import Subparsers, add_command, add_config_options

DESCRIPTION = """\
Shows a drive on one screen, in the Rerun viewer: the way from above (map, odom, wheel and gyro
alone, truth) with the ellipse that holds the position, the ground under it along the way and as it
comes, places that were known again, speeds, doubt, standstill, slip and health along time. LOG is
the output of gprodom-replay or a recording of gprodomd; --live shows what a running gprodomd
publishes.

It needs rerun-sdk (the extra `view`; pip install 'gprodom[view]'; Debian has no package of it). Its
usage statistics are switched off, and it listens on this machine alone unless --address says else.
-o writes a recording, which colleagues open with `rerun FILE` or `gprodom view FILE.rrd`.

examples:
  gprodom view recording.lcmlog
  gprodom view out.lcmlog --sensors in.lcmlog --map yesterday.map
  gprodom view out.lcmlog --sensors in.lcmlog -o drive.rrd
  gprodom view --live
  gprodom view --live --web --address 192.168.1.5    # on a robot: open the page that it names
"""

WEB_PORT = 9090


def add_parser(subparsers: Subparsers) -> None:
    """Adds ``view``."""
    parser = add_command(
        subparsers, "view", "a drive on one screen, or a running gprodomd", DESCRIPTION, run
    )
    parser.operand("log", "LOG", "log with the estimate, or a .rrd file", nargs="?")
    parser.flag("--live", "show a running gprodomd")
    parser.option("--sensors SEQ|LOG", Path, "the replay's input, where LOG has none")
    parser.option("--map MAP", Path, "ground of earlier drives", dest="map_file")
    parser.option("--map-number N", int, "map of that file, of several")
    parser.output("FILE.rrd", "write this, show nothing", required=False)
    parser.flag("--web", "for a browser, in place of a window")
    parser.option("--web-port N", WEB_PORT, "default %(default)s")
    parser.option(
        "--address IP",
        "127.0.0.1",
        "address to listen on (default %(default)s: this machine alone)",
    )
    parser.choice(
        "--renderer",
        ("vulkan", "gl"),
        None,
        "of the window; vulkan with mesa-vulkan-drivers needs no graphics card",
    )
    parser.option("--lcm-url URL", DEFAULT_URL, "with --live (default %(default)s)")
    add_config_options(parser)


def run(args: argparse.Namespace) -> int:
    """Shows it until the window is closed, or writes it."""
    if (args.log is None) != args.live:
        raise UsageError("give either a LOG or --live")
    if args.output and (args.web or args.renderer):
        raise UsageError("-o shows nothing: leave out --web and --renderer")
    from gprodom.view.viewer import without_statistics

    channels = read_channels(args.configs, args.overrides)
    with without_statistics() as environment:
        if args.live:
            return _live(args, channels, environment)
        if args.log.suffix == ".rrd":
            return _show(args, args.log, environment)
        if args.output:
            with replacing(args.output) as part:
                write(args, channels, part)
            print(f"{args.output}: {args.output.stat().st_size / 1e6:.1f} MB")
            return 0
        with temporary_folder() as folder:
            made = folder / f"{args.log.stem}.rrd"
            write(args, channels, made)
            return _show(args, made, environment)


def write(args: argparse.Namespace, channels: Channels, path: Path) -> None:
    """The recording of a log."""
    from gprodom.drive.log import read_drive
    from gprodom.view.layout import for_drive
    from gprodom.view.log import log_drive
    from gprodom.view.record import Recorder, new_stream

    drive = read_drive(args.log, channels, args.sensors)
    stream = new_stream(args.log.stem)
    stream.save(path)
    recorder = Recorder(stream)
    columns = log_drive(recorder, drive, read_mounting(args.configs, args.overrides))
    stream.send_blueprint(for_drive(drive, _earlier_ground(args, recorder), columns))
    stream.flush()
    stream.disconnect()


def _earlier_ground(args: argparse.Namespace, recorder: Any) -> Any:
    """Logs the map that was asked for; its places (n, 2), or None."""
    if args.map_file is None:
        return None
    from gprodom.map.ground import read_map, stored_positions

    file = read_map(args.map_file)
    places = stored_positions(file, file.one_map(args.map_number))
    recorder.ground_of_map("earlier ground", places)
    return places


def _show(args: argparse.Namespace, recording: Path, environment: dict[str, str]) -> int:
    from gprodom.view.viewer import show, viewer_command

    web = args.web_port if args.web else None
    more = [str(recording), *(["--renderer", args.renderer] if args.renderer else [])]
    return show(viewer_command(args.address, None, web, more), environment)


def _live(args: argparse.Namespace, channels: Channels, environment: dict[str, str]) -> int:
    from gprodom.view.layout import for_live
    from gprodom.view.live import ROLES, Live, interruptions, listen
    from gprodom.view.record import Recorder, new_stream
    from gprodom.view.viewer import LOCAL, free_port, started, viewer_command

    lcm = connect(args.lcm_url)
    stream = new_stream("live")
    viewer: subprocess.Popen[bytes] | None = None
    if args.output:
        stream.save(args.output)
    else:
        port, web = free_port(), args.web_port if args.web else None
        more = ["--renderer", args.renderer] if args.renderer else []
        viewer = started(viewer_command(args.address, port, web, more), environment, port)
        there = LOCAL if args.address in ("0.0.0.0", "::") else args.address
        stream.connect_grpc(f"rerun+http://{there}:{port}/proxy")
    recorder = Recorder(stream)
    stream.send_blueprint(for_live(_earlier_ground(args, recorder)))
    live = Live(recorder, channels.of(*ROLES), read_mounting(args.configs, args.overrides))
    live.subscribe(lcm)
    try:
        with interruptions() as interrupted:
            listen(lcm, live, lambda: viewer is None or viewer.poll() is None, interrupted)
            live.finish()
            stream.flush()
            stream.disconnect()
    finally:
        if viewer is not None and viewer.poll() is None:
            os.killpg(viewer.pid, signal.SIGTERM)  # the viewer, too, not its starter alone
            viewer.wait()
    return 0
