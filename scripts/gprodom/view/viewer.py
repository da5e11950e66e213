"""Rerun's viewer as a process of its own: on this machine alone, and without usage statistics.

Left to itself it listens on all addresses and, from its second start on, tells its makers how it is
used. Here it is bound to one address, and gets a folder for its configuration in which statistics
are switched off; the user's own configuration is not touched.
"""

import json
import os
import socket
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from gprodom.errors import Error
from gprodom.files import temporary_folder
from gprodom.view.record import NOT_INSTALLED, is_installed

LOCAL = "127.0.0.1"
STARTS_S = 30.0  # at most; on a busy computer without a graphics card some ten
_FORCED = "FORCE_RERUN_ANALYTICS"  # would switch them on again


@contextmanager
def without_statistics() -> Iterator[dict[str, str]]:
    """The environment for Rerun's programs, and for its library in this process."""
    if not is_installed():
        raise NOT_INSTALLED
    with temporary_folder() as folder:
        environment = {key: value for key, value in os.environ.items() if key != _FORCED}
        environment |= {"XDG_CONFIG_HOME": str(folder), "XDG_DATA_HOME": str(folder)}
        settings = folder / "rerun" / "analytics.json"
        settings.parent.mkdir()
        settings.write_text(json.dumps(_switched_off(settings)))
        before = dict(os.environ)
        os.environ.clear()
        os.environ.update(environment)
        try:
            yield environment
        finally:
            os.environ.clear()
            os.environ.update(before)


def _switched_off(settings: Path) -> dict[str, object]:
    """What `rerun analytics disable` writes, which itself sends what is left of earlier sessions.

    All of its fields: where one is missing, the viewer takes its defaults, and those are on.
    """
    return {
        "analytics_enabled": False,
        "analytics_id": "",
        "metadata": {},
        "config_file_path": str(settings),
        "data_dir_path": str(settings.parent / "analytics"),
    }


def viewer_command(
    address: str, port: int | None, web_port: int | None, more: Sequence[str] = ()
) -> list[str]:
    """The viewer's command line. port: for recordings sent to it (None: a free one); web_port: of
    the page for a browser (None: a window in place of a page)."""
    command = [sys.executable, "-m", "rerun", "--bind", address, "--hide-welcome-screen"]
    command += ["--port", "auto" if port is None else str(port)]
    if web_port is not None:
        command += ["--serve-web", "--web-viewer-port", str(web_port)]
    return [*command, *more]


def show(command: list[str], environment: dict[str, str]) -> int:
    """Runs a viewer until its window is closed (or the page is no longer served)."""
    try:
        return subprocess.run(command, env=environment).returncode
    except KeyboardInterrupt:
        return 0


def started(command: list[str], environment: dict[str, str], port: int) -> subprocess.Popen[bytes]:
    """A viewer that runs beside this program, once it listens on `port`."""
    # In a session of its own: what interrupts this program lets it send what is left.
    viewer = subprocess.Popen(command, env=environment, start_new_session=True)
    address = command[command.index("--bind") + 1]
    there = LOCAL if address in ("0.0.0.0", "::") else address
    due = time.monotonic() + STARTS_S
    while time.monotonic() < due and viewer.poll() is None:
        try:
            socket.create_connection((there, port), timeout=1.0).close()
        except OSError:
            time.sleep(0.1)
        else:
            return viewer
    viewer.kill()
    raise Error(
        "the Rerun viewer did not start; without a screen use --web, without a graphics card "
        "--renderer vulkan with the package mesa-vulkan-drivers"
    )


def free_port() -> int:
    """One that nothing listens on."""
    with socket.socket() as one:
        one.bind((LOCAL, 0))
        return int(one.getsockname()[1])
