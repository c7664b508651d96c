"""A small pool of threads for kernels that release the GIL.

1. numba's own `parallel=True` is not used: its threading layers abort the process when two
   Python threads enter them at once, and its kernels miss the disk cache when they are
   made by a factory.
2. The caller works along, so one core needs no pool, and a pool that is busy with somebody
   else's work never makes a caller wait for more than itself.
3. Threads do not survive a fork: a child process starts with a fresh pool.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from threading import Lock
from typing import TypeVar

Item = TypeVar("Item")


def count() -> int:
    """Cores this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def for_each(work: Callable[[Item], object], items: Iterable[Item]) -> None:
    """Call `work` with every item, on all cores, in any order; raises what `work` raises."""
    waiting = list(items)
    helpers = min(count(), len(waiting)) - 1
    waiting.reverse()
    lock = Lock()

    def drain() -> None:
        while True:
            with lock:
                if not waiting:
                    return
                item = waiting.pop()
            work(item)

    futures = [_pool().submit(drain) for _ in range(helpers)]
    try:
        drain()
    finally:
        waiting.clear()
        started = [future for future in futures if not future.cancel()]
        errors = [future.exception() for future in started]
    for error in errors:
        if error is not None:
            raise error


@cache
def _pool() -> ThreadPoolExecutor:
    return ThreadPoolExecutor(max(count() - 1, 1), thread_name_prefix="ffdstudio")


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_pool.cache_clear)
