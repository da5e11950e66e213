"""The methods of a benchmark: their changes to the configuration, or their computation."""

from dataclasses import replace
from pathlib import Path

from gprodom.errors import UsageError
from gprodom.odometry.method import Method
from gprodom.rooms import rooms

K_KEY = "paper.k"


def _gpr_sfm() -> Method:
    overrides = ("gpr.enabled=true", "gpr.front_end=sfm", "graph.enabled=false")
    summary = "SFM distance alone, sign from the wheel, gyro yaw"
    return Method("gpr_sfm", summary, overrides, "displacements", "sfm", K_KEY)


def _sequential(name: str, summary: str) -> tuple[Method, Method]:
    """The method with the paper's distance norm, and with the displacement's sign."""
    overrides = ("gpr.enabled=true", f"gpr.front_end={name}", "graph.enabled=false")
    return (
        Method(name, summary, (*overrides, "paper.fusion=norm"), "", name, K_KEY),
        Method(
            f"{name}_signed",
            f"the same as {name}, displacements with their sign",
            (*overrides, "paper.fusion=signed"),
            "",
            name,
            K_KEY,
        ),
    )


METHODS = {
    method.name: method
    for method in (
        Method("wheel", "wheel distance with gyro yaw, dead reckoning", reckoned="wheel"),
        _gpr_sfm(),
        Method("imu_wheel", "IMU and wheel, no radar", ("gpr.enabled=false",)),
        *_sequential("bscan", "IMU, wheel and radar: B-scans matched by cosine similarity"),
        *_sequential("dec", "IMU, wheel and radar: dominant energy curves"),
        *_sequential("sfm", "IMU, wheel and radar: subsurface feature matrices (the paper)"),
        *_sequential("salient", "IMU, wheel and radar: salient regions (apexes of hyperbolas)"),
        *_sequential("trace_count", "IMU, wheel and the number of radar traces"),
        Method(
            "gprodom",
            "IMU, wheel and radar motion (standstill, coherence), no revisits",
            ("gpr.enabled=true", "gpr.front_end=motion", "graph.enabled=false"),
        ),
        Method(
            "gprodom_full",
            "the same with revisits: the pose in map",
            ("gpr.enabled=true", "gpr.front_end=motion", "graph.enabled=true"),
        ),
        Method(
            "radar_imu",
            "radar and IMU, no wheel: two antennas in a row (gpr.antennas), with revisits",
            (
                "wheel.enabled=false",
                "gpr.enabled=true",
                "gpr.front_end=motion",
                "graph.enabled=true",
            ),
        ),
        *(method for room in rooms() for method in room.METHODS),
    )
}


# `salient` where there is a map of pipes: two pipes that are further apart than the usual window
# are still one displacement.
ON_PIPES = Method(
    "salient",
    "IMU, wheel and the places of pipes",
    ("gpr.enabled=true", "gpr.front_end=none", "graph.enabled=true", "smoother.lag=20"),
    teller="gprodom.odometry.pipes:teller_of",
    tracked=True,
)


# The rows of a benchmark where none are named: all but those that differ in a sign, or need a
# file or a second antenna.
DEFAULT_METHODS = tuple(
    name
    for name, method in METHODS.items()
    if not name.endswith("_signed") and not method.teller and name != "radar_imu"
)


def find_method(name: str, networks: Path | None = None, pipes: Path | None = None) -> Method:
    """The method of that name. networks: folder in which a method's `source` lies, where it has
    one; pipes: map of pipes, for `salient`."""
    if name not in METHODS:
        raise UsageError(f"unknown method {name!r}; expected one of {', '.join(METHODS)}")
    method: Method = METHODS[name]
    if name == "salient" and pipes is not None:
        return replace(ON_PIPES, source=pipes.resolve())
    if method.source is None:
        return method
    if networks is None:
        raise UsageError(f"the method {name} needs --networks DIR (gprodom run --help)")
    return replace(method, source=networks.resolve() / method.source)


def describe_methods() -> str:
    """One line a method, for help texts."""
    return "\n".join(f"  {method.name:<18} {method.summary}" for method in METHODS.values())
