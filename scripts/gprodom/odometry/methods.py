"""The methods of a benchmark: their changes to the configuration, or their computation."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

from gprodom.errors import UsageError


@dataclass(frozen=True)
class Method:
    """One row of a results table.

    overrides: KEY=VALUE over the configuration given, before the user's own --set.
    reckoned: computed here by dead reckoning: from the wheel, or from the radar displacements of a
      replay; the estimator's poses are not used.
    front_end: the radar front end whose sequential displacements are measured, where there is one.
    k_key: configuration key of the displacement per unit of shift (K), where the method has one.
    network: whose answers to traces and track the estimator gets, where the method has one
      (`gprodom.learned`); tracked: it needs a track. networks: folder that holds it.
    pipes: map of pipes (`gprodom.odometry.pipes`) that answers in place of a network.
    """

    name: str
    summary: str
    overrides: tuple[str, ...] = ()
    reckoned: str = ""  # "", "wheel" or "displacements"
    front_end: str = ""
    k_key: str = ""
    network: str = ""
    tracked: bool = False
    networks: Path | None = None
    pipes: Path | None = None

    @property
    def answers(self) -> bool:
        """Whether displacements come from outside of the estimator."""
        return bool(self.network) or self.pipes is not None


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
        Method(
            "learned_sequential",
            "IMU, wheel and motion by a network (--networks)",
            ("gpr.enabled=true", "gpr.front_end=none", "graph.enabled=false"),
            network="learned_sequential",
        ),
        Method(
            "learned_pair",
            "IMU, wheel and revisits by a network: the pose in map (--networks)",
            ("gpr.enabled=true", "gpr.front_end=none", "graph.enabled=true"),
            network="learned_pair",
            tracked=True,
        ),
    )
}


# `salient` where there is a map of pipes: two pipes that are further apart than the usual window
# are still one displacement.
ON_PIPES = Method(
    "salient",
    "IMU, wheel and the places of pipes",
    ("gpr.enabled=true", "gpr.front_end=none", "graph.enabled=true", "smoother.lag=20"),
    tracked=True,
)


# The rows of a benchmark where none are named: all but those that differ in a sign, or need a
# network or a second antenna.
DEFAULT_METHODS = tuple(
    name
    for name, method in METHODS.items()
    if not name.endswith("_signed") and not method.network and name != "radar_imu"
)


def find_method(name: str, networks: Path | None = None, pipes: Path | None = None) -> Method:
    """The method of that name. networks: folder of `gprodom learn`, for a method that has one;
    pipes: map of pipes, for `salient`."""
    if name not in METHODS:
        raise UsageError(f"unknown method {name!r}; expected one of {', '.join(METHODS)}")
    method = METHODS[name]
    if name == "salient" and pipes is not None:
        return replace(ON_PIPES, pipes=pipes.resolve())
    if not method.network:
        return method
    if networks is None:
        raise UsageError(f"the method {name} needs --networks DIR, which gprodom learn writes")
    return replace(method, networks=networks.resolve())


def describe_methods() -> str:
    """One line a method, for help texts."""
    return "\n".join(f"  {method.name:<18} {method.summary}" for method in METHODS.values())
