"""Figures that others published on CMU-GPR, and whether a sequence is of that dataset."""

import zipfile
from dataclasses import dataclass
from pathlib import Path

SCENES = ("gates_g", "nsh_b", "nsh_h")  # parking garage, basement, factory floor


@dataclass(frozen=True)
class Published:
    """RMSE in metres by scene and over all; alignment and definition are not stated by any."""

    who: str
    scenes: dict[str, float]
    overall: float | None
    note: str = ""


FUSED = (
    Published(
        "Li et al. 2025, fused (arXiv 2503.18301)",
        dict(zip(SCENES, (0.468, 0.734, 0.439), strict=True)),
        0.568,
        "weighted by length; 0.562 by the lengths of the dataset",
    ),
    Published("CMU learned model (Baikovitz et al. 2021)", {}, 0.59),
    Published("GPR-OdomNet (arXiv 2511.17457)", {}, 0.449),
)
GPR_ONLY = (
    Published("Li et al. 2025, GPR only", {"gates_g": 1.73}, 2.23, "mean over scenes"),
    Published("Li et al. 2025, wheel", {"gates_g": 2.52}, None),
)


def is_of_dataset(source: Path) -> bool:
    """Whether a sequence is from CMU-GPR: only that dataset has pictures of a camera."""
    if source.is_dir():
        return (source / "camera").is_dir()
    if not zipfile.is_zipfile(source):
        return False
    with zipfile.ZipFile(source) as archive:
        return any("/camera/" in f"/{name}" for name in archive.namelist())
