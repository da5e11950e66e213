"""What the tests share: where test data lie, and a network of their own for live LCM."""

from __future__ import annotations

import importlib.util
import os
import shutil
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

import pytest

CHECKOUT = Path(__file__).resolve().parents[2]


def shared_folder() -> Path:
    """Recorded data for tests: beside the checkout, or named by GPRODOM_SHARED."""
    return Path(os.environ.get("GPRODOM_SHARED", CHECKOUT.parent / "shared"))


@pytest.fixture(scope="session")
def shared() -> Path:
    """The folder of shared test data; the test is skipped where there is none."""
    folder = shared_folder() / "data"
    if not folder.is_dir():
        pytest.skip(f"no shared test data in {folder} (name its parent in GPRODOM_SHARED)")
    return folder


@pytest.fixture(scope="session")
def compiled() -> None:
    """The compiled module is needed: without it the test is skipped, as where Python alone is."""
    if importlib.util.find_spec("gprodom._core") is None:
        pytest.skip("the extension gprodom._core is not built")


UNPRIVILEGED = ("setpriv", "--reuid=65534", "--regid=65534", "--clear-groups", "--no-new-privs")


def run_isolated(
    code: str, *arguments: str, as_user: Sequence[str] = (), timeout_s: float = 60.0
) -> subprocess.CompletedProcess[str]:
    """Runs Python code in a network namespace where LCM multicast stays on the loopback.

    Root may give `UNPRIVILEGED` as `as_user`, to run the code as nobody.
    """
    if shutil.which("unshare") is None:
        pytest.skip("unshare (util-linux) is not installed")
    setup = "ip link set lo up && ip route add 224.0.0.0/4 dev lo"
    # In a chroot root may make a network namespace but no user namespace.
    unshare = ["unshare", "-n" if os.geteuid() == 0 else "-rn"]
    probe = subprocess.run([*unshare, "sh", "-c", setup], capture_output=True, text=True)
    if probe.returncode != 0:
        pytest.skip(f"no network namespace: {probe.stderr.strip()}")
    inside = ["sh", "-c", f'{setup} && exec "$@"', "sh"]
    return subprocess.run(
        [*unshare, *inside, *as_user, sys.executable, "-c", code, *arguments],
        capture_output=True,
        text=True,
        timeout=timeout_s,
    )
