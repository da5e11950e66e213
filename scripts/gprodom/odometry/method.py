"""What a method is."""

from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Method:
    """One row of a results table.

    overrides: KEY=VALUE over the configuration given, before the user's own --set.
    reckoned: computed here by dead reckoning: from the wheel, or from the radar displacements of a
      replay; the estimator's poses are not used.
    front_end: the radar front end whose sequential displacements are measured, where there is one.
    k_key: configuration key of the displacement per unit of shift (K), where the method has one.
    teller: MODULE:FUNCTION that makes of the file `source` what answers the traces in place of the
      estimator's front ends (`gprodom.lcm.answers.Teller`); tracked: it needs a track, too.
    """

    name: str
    summary: str
    overrides: tuple[str, ...] = ()
    reckoned: str = ""  # "", "wheel" or "displacements"
    front_end: str = ""
    k_key: str = ""
    teller: str = ""
    tracked: bool = False
    source: Path | None = None
