"""What this folder adds to the package (`gprodom.rooms`)."""

from pathlib import Path

from gprodom.odometry.method import Method
from gprodom.options import Parser

_TELLER = "gprodom.learned.answers:teller_of"
_NO_FRONT_END = ("gpr.enabled=true", "gpr.front_end=none")

METHODS = (
    Method(
        "learned_sequential",
        "IMU, wheel and motion by a network (--networks)",
        (*_NO_FRONT_END, "graph.enabled=false"),
        teller=_TELLER,
        source=Path("learned_sequential.onnx"),
    ),
    Method(
        "learned_pair",
        "IMU, wheel and revisits by a network: the pose in map (--networks)",
        (*_NO_FRONT_END, "graph.enabled=true"),
        teller=_TELLER,
        tracked=True,
        source=Path("learned_pair.onnx"),
    ),
)

COMMANDS = ("gprodom.learned.command", "gprodom.learned.live")


def add_method_options(parser: Parser) -> None:
    """``--networks``."""
    parser.option(
        "--networks DIR", Path, "folder that gprodom learn wrote, for the learned methods"
    )
