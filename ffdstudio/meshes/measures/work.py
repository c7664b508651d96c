"""Compiled kernels, shared among the cores in pieces of a list of faces or cells."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from ffdstudio import compiling, threads

SMALL = 20_000  # below this a second thread costs more than it brings

compiled = partial(compiling.compiled, fastmath={"contract"})


def shared(kernel: Callable[..., None], chosen: np.ndarray, *arguments: Any) -> None:
    """Call ``kernel(part, *arguments)`` for parts of `chosen` on all cores."""
    pieces = 4 * threads.count() if len(chosen) >= SMALL else 1
    threads.for_each(lambda part: kernel(part, *arguments), np.array_split(chosen, pieces))
