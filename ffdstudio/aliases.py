"""Types that every room speaks of, each named once."""

from __future__ import annotations

import os
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]  # coordinates, values; shapes are told where they are used
Indices = NDArray[np.int64]  # numbers of nodes, cells, rows
Mask = NDArray[np.bool_]  # which of them
AnyArray = NDArray[Any]  # what a file or a kernel brings in a type of its own
PathLike = str | os.PathLike[str]
