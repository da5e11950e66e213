"""A trained network, run by onnxruntime, and its record."""

import json
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from gprodom.arrays import Floats
from gprodom.errors import Error, need_module

NETWORKS = ("learned_sequential", "learned_pair")
RECORD = "record.json"
LEAST_SPACING = 1e-3  # m, as `networks` has it


def read_record(folder: Path) -> dict[str, Any]:
    """What `gprodom learn` wrote of its training in `folder`."""
    path = folder / RECORD
    try:
        record: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise Error(f"{path}: no such file; expected a folder that gprodom learn wrote") from None
    except ValueError as error:
        raise Error(f"{path}: {error}") from None
    return record


class Network:
    """The network `name` of a folder that `gprodom learn` wrote."""

    def __init__(self, folder: Path, name: str) -> None:
        onnxruntime = need_module("onnxruntime", "learned")
        path = folder / f"{name}.onnx"
        if not path.is_file():
            raise Error(f"{path}: no such file; expected a folder that gprodom learn wrote")
        options = onnxruntime.SessionOptions()
        options.intra_op_num_threads = options.inter_op_num_threads = 1
        options.log_severity_level = 3
        self._session = onnxruntime.InferenceSession(
            str(path), options, providers=["CPUExecutionProvider"]
        )
        self._inputs = [each.name for each in self._session.get_inputs()]

    def __call__(self, first: Floats, second: Floats) -> Floats:
        """What it says of inputs (n, ...), in the order of its own: (n, k)."""
        values = (np.asarray(first, np.float32), np.asarray(second, np.float32))
        feed = dict(zip(self._inputs, values, strict=True))
        return np.asarray(self._session.run(None, feed)[0], np.float64)


@dataclass(frozen=True)
class Spacing:
    """The way from trace to trace (n,), m: mean and standard deviation."""

    mean: Floats
    sigma: Floats


def to_spacing(told: Floats, widen: float = 1.0) -> Spacing:
    """From what learned_sequential says, (n, 2): a lognormal distribution. widen: of its sigma."""
    sigma = widen * np.exp(np.clip(told[:, 1], -4, 2))
    variance = np.minimum(sigma**2, 1.5)
    mean = np.exp(told[:, 0] + 0.5 * variance)
    spread = mean * np.sqrt(np.expm1(variance))
    return Spacing(np.maximum(mean - LEAST_SPACING, 0.0), spread)


@dataclass(frozen=True)
class Found:
    """Offset (m) of an image from another, its standard deviation, and the chance that both show
    the same ground; each (n,)."""

    offset: Floats
    sigma: Floats
    same: Floats


def to_offset(told: Floats, widen: float = 1.0) -> Found:
    """From what learned_pair says, (n, 3 or more)."""
    sigma = widen * np.exp(np.clip(told[:, 1], -6, 1))
    return Found(told[:, 0], sigma, 1 / (1 + np.exp(-told[:, 2])))


def widening(record: dict[str, Any], name: str) -> float:
    """By which a network's standard deviations are multiplied: from its NEES on validation."""
    nees = record["training"][name].get("nees")
    return math.sqrt(nees) if nees and math.isfinite(nees) else 1.0
