"""Simulated sequences for a benchmark: each depends on its number only. Kept as LCM logs."""

from dataclasses import dataclass
from pathlib import Path

from gprodom.config import STANDARD, Channels
from gprodom.convert.streams import streams
from gprodom.errors import UsageError
from gprodom.files import write_bytes
from gprodom.ground.survey import find_survey, shipped
from gprodom.lcm.log_writer import write_log
from gprodom.own_code import digest_of_code
from gprodom.random_streams import stream
from gprodom.simulate.ground import GroundSpec
from gprodom.simulate.lasting import KINDS
from gprodom.simulate.recording import as_recording
from gprodom.simulate.robot import robot
from gprodom.simulate.routes import make_route
from gprodom.simulate.sequence import SurveySpec, simulate

RAYS = "rays"
ROUTES = ("line", "loop", "eight", "stops")


@dataclass(frozen=True)
class Drive:
    """A simulated sequence to be made. Ground and route alternate with the seed."""

    seed: int
    grounds: tuple[str, ...]
    distance: float  # m
    channels: Channels = STANDARD  # of its log
    lasting: str = ""  # slip that lasts: of `lasting.KINDS`

    @property
    def ground(self) -> str:
        """Its ground, which is its scene."""
        return self.grounds[self.seed % len(self.grounds)]

    @property
    def name(self) -> str:
        """Its name, in the form of the dataset."""
        return f"{1_700_000_000 + self.seed}-0-{self.ground}-cmu-gpr"

    def make(self, folder: Path) -> Path:
        """Its log in `folder`, unless it is there: of this drive, made by this code."""
        path, kept = folder / f"{self.name}.lcmlog", folder / f".{self.name}.key"
        key = f"{self} {digest_of_code()}"
        if path.exists() and kept.exists() and kept.read_text(encoding="utf-8") == key:
            return path
        kept.unlink(missing_ok=True)
        route = ROUTES[self.seed // len(self.grounds) % len(ROUTES)]
        choose = stream(self.seed, "benchmark")
        distance = self.distance * choose.uniform(0.7, 1.3)
        speed, slips = choose.uniform(0.35, 0.8), int(choose.randint(0, 5))
        length = None if self.ground == RAYS else find_survey(self.ground).length
        drive = make_route(route, distance, speed, 6.0, stream(self.seed, "route"), length)
        ground = GroundSpec() if self.ground == RAYS else SurveySpec(self.ground)
        simulated = simulate(robot(drive, ground, route, slips, self.lasting), self.seed)
        assert simulated.sample_interval is not None
        recording = as_recording(simulated)
        write_log(path, streams(recording, simulated.sample_interval, self.channels))
        write_bytes(kept, key.encode())
        return path


def drives(
    count: int,
    first_seed: int,
    grounds: tuple[str, ...],
    distance: float,
    channels: Channels = STANDARD,
    kinds: tuple[str, ...] = ("",),
) -> list[Drive]:
    """`count` drives from `first_seed` on. `kinds` of lasting slip take turns; empty: none."""
    known = (*shipped(), RAYS)
    for kind in kinds:
        if kind and kind not in KINDS:
            raise UsageError(f"--lasting {kind}: expected some of {', '.join(KINDS)}")
    for ground in grounds:
        if ground not in known:
            raise UsageError(f"--grounds {ground}: expected some of {', '.join(known)}")
    return [
        Drive(seed, grounds, distance, channels, kinds[seed % len(kinds)])
        for seed in range(first_seed, first_seed + count)
    ]
