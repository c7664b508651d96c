"""How kernels are compiled: without the interpreter lock, and kept on disk where possible.

1. The disk cache only saves time. Whatever is wrong with it (no folder, no room, a file that
   was cut off or damaged) is a reason to compile, never to fail.
2. numba reads and writes it at the first call with a signature, so that is guarded in the cache
   itself; calls from compiled code and all later ones are numba's own and cost nothing more.
3. Damaged machine code would crash the process: each file ends with a digest of the rest.
4. A function counts as changed when any module of its folder has: numba watches its own file
   alone, and would go on using what it has compiled in from another one.
"""

from __future__ import annotations

import functools
import hashlib
import pickle
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

DIGEST = 32  # bytes of SHA-256


def compiled(function: Callable[..., Any], **options: Any) -> Any:
    """Compile on first call; the disk cache is used where a place for it can be written.

    `options` are those of numba's njit.
    """
    from numba import njit

    dispatcher = njit(**{"nogil": True, "error_model": "numpy", **options})(function)
    if dispatcher is not function:  # as it is when NUMBA_DISABLE_JIT is set
        with suppress(Exception):  # no writable folder, or a numba that keeps its cache otherwise
            dispatcher._cache = _cache_class()(function)
    return dispatcher


@functools.cache
def whole() -> Any:
    """Intrinsic by which a compiled function says that it is not to be copied into its callers.

    LLVM would copy a large function into each caller and optimise every copy anew.
    """
    from numba import types
    from numba.extending import intrinsic

    def generate_whole(context: Any) -> Any:
        def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            builder.function.attributes.add("noinline")
            return context.get_dummy_value()

        return types.none(), generate

    return intrinsic(generate_whole)


def _stamp(function: Callable[..., Any]) -> tuple[object, ...]:
    """What tells one version of the function's folder from another."""
    return _stamp_of(Path(function.__code__.co_filename).parent)


@functools.cache
def _stamp_of(folder: Path) -> tuple[object, ...]:
    states = [(path.name, path.stat()) for path in sorted(folder.glob("*.py"))]
    return tuple((name, state.st_mtime, state.st_size) for name, state in states)


@functools.cache
def _cache_class() -> Any:
    """Cache of numba that never fails; made on first use, since numba takes its time."""
    from numba.core.caching import FunctionCache, IndexDataCacheFile

    class CheckedFile(IndexDataCacheFile):
        def _dump(self, value: object) -> bytes:
            return sealed(super()._dump(value))

        def _load_data(self, name: str) -> Any:
            with open(self._data_path(name), "rb") as stream:  # noqa: PTH123 - as numba does
                return pickle.loads(unsealed(stream.read()))

    class ForgivingCache(FunctionCache):
        def __init__(self, function: Callable[..., Any]) -> None:
            super().__init__(function)
            plain = self._cache_file
            self._cache_file = CheckedFile(
                plain._cache_path, self._impl.filename_base, _stamp(function)
            )

        def load_overload(self, signature: Any, context: Any) -> Any:
            try:
                return super().load_overload(signature, context)
            except Exception:
                with suppress(Exception):
                    self.flush()  # or no process would find anything in it any more
                return None

        def save_overload(self, signature: Any, data: Any) -> None:
            with suppress(Exception):
                super().save_overload(signature, data)

    return ForgivingCache


def sealed(data: bytes) -> bytes:
    """Data with its digest behind it, which pickle does not look at."""
    return data + hashlib.sha256(data).digest()


def unsealed(data: bytes) -> bytes:
    """Data without its digest; raises `ValueError` if they do not belong together.

    Examples
    --------
    >>> unsealed(sealed(b"abc"))
    b'abc'
    """
    content = data[:-DIGEST]
    if hashlib.sha256(content).digest() != data[-DIGEST:]:
        raise ValueError("a file of the cache is damaged")
    return content
