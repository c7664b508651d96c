"""Work-arounds for what the toolkits get wrong, each with its reason and its end.

1. PySide6 6.12 on Python 3.11: `Signal.emit` returns True and `processEvents` None without
   counting a reference, as if they were immortal, which they are from Python 3.12 on. After
   some thousand signals the count is used up and the interpreter aborts ("bool_dealloc:
   deallocating True or False"). Measured: one reference lost a call. Until Python 3.11 is no
   longer supported the counts are raised so far that nothing uses them up: the same as what
   later Pythons do.
2. pyvistaqt 0.13 keeps Python wrappers of the OpenGL context and of its surface. PySide knows
   the surface as a `QSurface`, which is no `QObject`, and hears nothing of its end: a wrapper
   that outlives it stands for whatever is allocated at the same address next. Seen: a label of
   the next window that was a `QOffscreenSurface`, and aborts in Qt's event loop. They are let
   go when the viewport is closed, while both are alive.
"""

from __future__ import annotations

import contextlib
import ctypes
import sys
from typing import Any

PLENTY = 1 << 40
SINGLETONS = (None, True, False, NotImplemented, Ellipsis)


def keep_singletons() -> None:
    """Give None, True and the like references that cannot be used up (reason 1)."""
    if sys.version_info >= (3, 12) or sys.implementation.name != "cpython":
        return
    for thing in SINGLETONS:
        count = ctypes.c_ssize_t.from_address(id(thing))  # the first field of every object
        known = abs(sys.getrefcount(thing) - count.value) < 100
        if known and count.value < PLENTY:
            count.value += PLENTY


def let_go_of_surface(interactor: Any) -> None:
    """Drop what a closed pyvistaqt widget holds of its OpenGL context (reason 2)."""
    context = interactor._ctx
    if context is not None:
        with contextlib.suppress(RuntimeError):  # not connected, or gone already
            context.aboutToBeDestroyed.disconnect(interactor._cleanup_context)
    interactor._forget_context()
