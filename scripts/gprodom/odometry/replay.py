"""Runs gprodom-replay, the estimator driven by a log, with progress."""

from __future__ import annotations

import re
import shutil
import subprocess
from collections import deque
from collections.abc import Callable, Sequence
from pathlib import Path

import gprodom
from gprodom.config import Configs, config_arguments
from gprodom.errors import Error

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
) -> None:
    """Replays `log` into `output`; raises `Error` with the program's own last line where it fails.

    `on_progress` is told the share of the log that is done, from 0 to 1.
    `smoothed`: a TUM file for the solution over all data, where given.
    """
    command = [str(find_program()), *config_arguments(configs), "--progress"]
    command += [str(log), "-o", str(output)]
    if smoothed is not None:
        command += ["--smoothed", str(smoothed)]
    for override in overrides:
        command += ["--set", override]
    said: deque[str] = deque(maxlen=20)
    with subprocess.Popen(
        command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, errors="replace"
    ) as process:
        try:
            assert process.stderr is not None
            for line in process.stderr:
                share = re.fullmatch(r"progress ([0-9.]+)\s*", line)
                if share is None:
                    said.append(line.strip())
                elif on_progress is not None:
                    on_progress(float(share.group(1)))
        except BaseException:
            process.terminate()
            raise
    if process.returncode != 0:
        code = process.returncode
        how = f"signal {-code}" if code < 0 else f"code {code}"
        last = next((line for line in reversed(said) if line), "it said nothing")
        raise Error(f"{PROGRAM} ended with {how}: {last}")
