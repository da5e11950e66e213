"""Names for numpy arrays in signatures; shapes and units stand in docstrings.

numpy's stubs infer element types differently from version to version, so these say what is meant
and leave the checking of element types to the tests.
"""

from typing import Any

import numpy.typing as npt

Floats = npt.NDArray[Any]  # float64
Ints = npt.NDArray[Any]  # int64 unless said otherwise
Bools = npt.NDArray[Any]
