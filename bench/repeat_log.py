#!/usr/bin/env python3
"""One long drive of a short log: its rounds follow each other, for soaks of the live daemon.

The log begins and ends at a standstill. Stamps and the wheel's count go on from round to round.

    bench/repeat_log.py SEQ.lcmlog long.lcmlog --seconds 900
    bench/live_load.py long.lcmlog --seconds 900 --series soak.csv
"""

from __future__ import annotations

from pathlib import Path

from gprodom.console import Progress
from gprodom.errors import Error
from gprodom.files import replacing
from gprodom.lcm import EventLog
from gprodom.lcm.messages import message
from program import exit_with, parser_of, print_figures

TYPES = {"IMU": "imu_t", "WHEEL": "wheel_t", "GPR_TRACE": "gpr_trace_t"}
IMU_PERIOD_US = 5000  # between the last message of a round and the first of the next


def repeat(source: Path, output: Path, seconds: float) -> int:
    """Writes `output`; the number of its messages."""
    if not source.is_file():
        raise Error(f"{source}: no such log")
    events = [event for event in EventLog(str(source), "r") if event.channel in TYPES]
    if not events:
        raise Error(f"{source}: no IMU, WHEEL or GPR_TRACE messages")
    messages = [message(TYPES[event.channel]).decode(event.data) for event in events]
    first = messages[0].utime
    period = max(m.utime for m in messages) - first + IMU_PERIOD_US
    ticks = next((m.ticks for m in reversed(messages) if hasattr(m, "ticks")), 0)
    written = 0
    with replacing(output) as part, Progress("writing", seconds) as progress:
        log = EventLog(str(part), "w", overwrite=True)
        while True:
            for event, m in zip(events, messages, strict=True):
                if m.utime - first > 1e6 * seconds:
                    log.close()
                    return written
                log.write_event(m.utime, event.channel, m.encode())
                written += 1
                m.utime += period
                if hasattr(m, "ticks"):
                    m.ticks += ticks
                if written % 10000 == 0:
                    progress.update(min(seconds, (m.utime - period - first) * 1e-6))


def main() -> int:
    """Runs the command line."""
    parser = parser_of(__doc__)
    parser.add_argument("log", type=Path, metavar="SEQ.lcmlog")
    parser.add_argument("output", type=Path, metavar="OUT.lcmlog")
    parser.add_argument("--seconds", type=float, default=900.0, help="default: %(default)s")
    args = parser.parse_args()
    messages = repeat(args.log, args.output, args.seconds)
    print_figures(args, {"messages": messages}, f"{args.output}: {messages} messages")
    return 0


if __name__ == "__main__":
    exit_with(main)
