"""Runs gprodom-replay, the estimator driven by a log, with progress."""

import json
import shutil
import subprocess
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import gprodom
from gprodom.config import Configs, config_arguments
from gprodom.errors import Error
from gprodom.files import temporary_folder

PROGRAM = "gprodom-replay"


def find_program(name: str = PROGRAM) -> Path:
    """The program of this checkout's build, else the one on the path."""
    build = gprodom._build_folder()
    if build is not None and (build / "bin" / name).is_file():
        return build / "bin" / name
    found = shutil.which(name)
    if found is None:
        raise Error(
            f"{name} is not built or not installed: run scripts/setup (in a checkout), then "
            "`. scripts/env`"
        )
    return Path(found)


def run_replay(
    log: Path,
    output: Path,
    configs: Configs = (),
    overrides: Sequence[str] = (),
    on_progress: Callable[[float], None] | None = None,
    smoothed: Path | None = None,
    on_warning: Callable[[str], None] | None = None,
    poses_needed: bool = True,
) -> dict[str, Any]:
    """Replays `log` into `output`, and gives its statistics; raises `Error` with the program's own
    last line where it fails.

    `on_progress` is called with the share of the log that is done, from 0 to 1.
    `smoothed`: a TUM file for the solution over all data, where given.
    `on_warning` is called with each warning of the estimator.
    `poses_needed`: a replay without a pose counts as failed.
    """
    with temporary_folder() as folder:
        stats = folder / "stats.json"
        command = [str(find_program()), *config_arguments(configs), "--progress"]
        command += [str(log), "-o", str(output), "--stats", str(stats)]
        if smoothed is not None:
            command += ["--smoothed", str(smoothed)]
        for override in overrides:
            command += ["--set", override]
        streams: dict[str, Any] = {"stdout": subprocess.DEVNULL, "stderr": subprocess.PIPE}
        code, said = run_telling(command, on_progress, on_warning, **streams)
        # With statistics it went through, and has found no pose.
        if code == 0 or (stats.exists() and not poses_needed):
            return dict(json.loads(stats.read_text()))
    if code < 0:
        raise Error(f"{PROGRAM} ended with signal {-code}: {said or 'it said nothing'}")
    raise Error(said.removeprefix(f"{PROGRAM}: ") or f"{PROGRAM} ended with code {code}")


def run_telling(
    command: list[str],
    on_progress: Callable[[float], None] | None = None,
    on_warning: Callable[[str], None] | None = None,
    **streams: Any,
) -> tuple[int, str]:
    """Exit code, and the last line that is neither progress (`progress SHARE`) nor a warning.

    streams: of `subprocess.Popen`; standard error is read, or where it is no pipe, the output.
    """
    said = ""
    with subprocess.Popen(command, text=True, errors="replace", **streams) as process:
        try:
            for line in process.stderr or process.stdout or ():
                kind, _, text = line.strip().partition(" ")
                if kind == "progress":
                    if on_progress is not None:
                        on_progress(float(text.split()[0]))
                elif kind == "warning:":
                    if on_warning is not None:
                        on_warning(text)
                else:
                    said = line.strip() or said
        except BaseException:
            process.terminate()
            raise
    return process.returncode, said
