"""``gprodom infer``: a network beside a running gprodomd."""

import argparse
import math
import signal
import time
from typing import Any

import numpy as np

from gprodom import rotation
from gprodom.config import read_channels
from gprodom.console import add_json_flag, tell
from gprodom.lcm import DEFAULT_URL, connect
from gprodom.lcm.answers import Answer, Teller, encoded
from gprodom.lcm.messages import message
from gprodom.options import Subparsers, add_command, add_config_options

DESCRIPTION = """\
Hears the traces of a radar and the odometry of a running gprodomd, and sends what a network says of
them to the same daemon as displacement_t, until interrupted; with --seconds, for so long. At the
end it tells how many answers it gave, and how long one took from its message on. The daemon uses an
answer of learned_sequential that comes within time.reorder_window, and counts later ones.

To have nothing else of the radar in the estimate, run gprodomd with gpr.front_end=none.

examples:
  gprodom infer networks --method learned_sequential
  gprodom infer networks --method learned_pair --seconds 60 --json
"""


def add_parser(subparsers: Subparsers) -> None:
    """Adds ``infer``."""
    parser = add_command(subparsers, "infer", "run a network beside gprodomd", DESCRIPTION, run)
    parser.operand("networks", "DIR", "that gprodom learn wrote")
    parser.add_argument(
        "--method", choices=("learned_sequential", "learned_pair"), default="learned_sequential"
    )
    add_config_options(parser)
    parser.add_argument("--lcm-url", default=DEFAULT_URL, metavar="URL")
    parser.add_argument("--seconds", type=float, default=math.inf, metavar="S")
    add_json_flag(parser)


class Inference:
    """Hears messages and sends answers; keeps the time that each took."""

    def __init__(self, teller: Teller, lcm: Any, channel: str) -> None:
        self._teller, self._lcm, self._channel = teller, lcm, channel
        self._antenna: int | None = None  # that is heard first: others would mix with it
        self.took_s: list[float] = []
        self.answers = 0

    def take_trace(self, _channel: str, data: bytes) -> None:
        """Hears a gpr_trace_t."""
        begun = time.monotonic()
        trace = message("gpr_trace_t").decode(data)
        if self._antenna is None:
            self._antenna = trace.antenna_id
        if trace.antenna_id != self._antenna:
            return
        samples = np.array(trace.samples, np.float64)
        self._send(self._teller.trace(trace.utime, samples, trace.sample_interval), begun)

    def take_odometry(self, _channel: str, data: bytes) -> None:
        """Hears an odometry_t."""
        begun = time.monotonic()
        pose = message("odometry_t").decode(data)
        yaw = float(rotation.yaw_of(pose.orientation))
        x, y, _ = pose.position
        self._send(self._teller.pose(pose.utime, x, y, yaw), begun)

    def _send(self, answers: list[Answer], begun: float) -> None:
        for answer in answers:
            self._lcm.publish(self._channel, encoded(answer))
            self.took_s.append(time.monotonic() - begun)
            self.answers += 1

    def figures(self) -> dict[str, Any]:
        """Number of answers, and milliseconds from a message to its answer."""
        took = 1e3 * np.array(self.took_s or [math.nan])
        p50, p99 = np.percentile(took, [50, 99])
        return {"answers": self.answers, "p50_ms": p50, "p99_ms": p99, "max_ms": took.max()}


def run(args: argparse.Namespace) -> int:
    """Runs the subcommand."""
    from gprodom.learned.answers import TELLERS

    channels = read_channels(args.configs, args.overrides)
    lcm = connect(args.lcm_url)
    inference = Inference(TELLERS[args.method](args.networks), lcm, channels.displacement_in)
    lcm.subscribe(channels.gpr_trace, inference.take_trace).set_queue_capacity(1000)
    lcm.subscribe(channels.odometry, inference.take_odometry).set_queue_capacity(10000)
    end = time.monotonic() + args.seconds
    ended: list[int] = []
    before = signal.signal(signal.SIGINT, lambda number, _: ended.append(number))
    while not ended and time.monotonic() < end:
        try:
            lcm.handle_timeout(100)
        except OSError:  # a signal has interrupted it, whose handler is called after that
            time.sleep(0.01)
            if not ended:
                raise
    signal.signal(signal.SIGINT, before)
    figures = inference.figures()
    text = (
        f"{figures['answers']} answers; from message to answer p50 {figures['p50_ms']:.1f} ms, "
        f"p99 {figures['p99_ms']:.1f} ms, at most {figures['max_ms']:.1f} ms"
    )
    tell(args.json, figures, text)
    return 0
