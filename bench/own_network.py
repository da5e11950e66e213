"""A network of the bench's own for live runs: nothing reaches a network card."""

from __future__ import annotations

import argparse
import os
import signal
import sys

GROUP, PORT = "239.255.76.67", 7667
URL = f"udpm://{GROUP}:{PORT}?ttl=0"
_LOOPBACK = 'ip link set lo up && ip route add 224.0.0.0/4 dev lo && exec "$@"'


def parse_inside(parser: argparse.ArgumentParser, *, mounts: bool = False) -> argparse.Namespace:
    """Parses the command line and starts the program again in namespaces of its own.

    That of the network, in which multicast goes to the loopback alone, and with `mounts` that of
    the file systems. Returns inside them; other users than root are root there.
    """
    parser.add_argument("--inside", action="store_true", help=argparse.SUPPRESS)
    args = parser.parse_args()
    if not args.inside:
        rights = ("-n" if os.geteuid() == 0 else "-rn") + ("m" if mounts else "")
        again = [sys.executable, sys.argv[0], *sys.argv[1:], "--inside"]
        os.execvp("unshare", ["unshare", rights, "sh", "-c", _LOOPBACK, "sh", *again])
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))  # so that what was started ends, too
    return args
