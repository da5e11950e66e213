"""The whole configuration, as the daemon reads it."""

import subprocess
from collections.abc import Sequence
from typing import Any

from gprodom.config import Configs, config_arguments
from gprodom.errors import Error
from gprodom.odometry.replay import find_program


def printed_settings(configs: Configs = (), overrides: Sequence[str] = ()) -> str:
    """Every setting with its unit and meaning, as YAML; what is wrong with one raises `Error`."""
    command = [str(find_program("gprodomd")), *config_arguments(configs), "--print-config"]
    for override in overrides:
        command += ["--set", override]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise Error(done.stderr.strip().splitlines()[-1].removeprefix("gprodomd: "))
    return done.stdout


def read_settings(configs: Configs = (), overrides: Sequence[str] = ()) -> dict[str, Any]:
    """The same, by section and key."""
    import yaml

    content: dict[str, Any] = yaml.safe_load(printed_settings(configs, overrides))
    return content
