"""How kernels are compiled: without the interpreter lock, and kept on disk where possible."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any


def compiled(function: Callable[..., Any], **options: Any) -> Any:
    """Compile on first call; the disk cache is used where a place for it can be written.

    `options` are those of numba's njit.
    """
    from numba import njit
    from numba.core.errors import NumbaError

    options = {"nogil": True, "error_model": "numpy", **options}
    try:
        return njit(cache=True, **options)(function)
    except (RuntimeError, NumbaError):  # no writable folder for the cache
        return njit(**options)(function)
