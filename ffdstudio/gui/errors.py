"""What the user is told when something goes wrong, and the last net under everything.

An exception that leaves a slot goes to `sys.excepthook`, whose default prints and, in some
bindings, ends the program. Ours writes the traceback to the log and shows a dialog; the
window stays.
"""

from __future__ import annotations

import logging
import logging.handlers
import sys
import threading
import traceback
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType

from psygnal import EmitLoopError
from PySide6.QtCore import QObject, Qt, Signal, Slot

from ffdstudio.errors import InputError

LOG = logging.getLogger("ffdstudio")


@dataclass(frozen=True)
class ErrorReport:
    """Something to tell: what happened, why, and what the user can do now.

    `ways` are buttons: what each says, and what it does once the dialog is closed.
    """

    title: str
    cause: str
    way_out: str = ""
    details: str = ""
    warning: bool = True
    ways: tuple[tuple[str, Callable[[], object]], ...] = ()


def log_path() -> Path:
    """File that errors are written to."""
    import platformdirs

    return Path(platformdirs.user_log_dir("ffdstudio", appauthor=False)) / "ffdstudio.log"


def problem_of(error: BaseException, doing: str = "") -> ErrorReport:
    """Say in words what an exception means; `doing` is what was under way, such as "Open"."""
    report = "".join(traceback.format_exception(error))
    error = cause_of(error)
    if isinstance(error, InputError):
        title = f"{doing} did not work" if doing else "This does not work"
        return ErrorReport(title, sentence(str(error)), "Nothing was changed.")
    if isinstance(error, MemoryError):
        return ErrorReport(
            "Not enough memory",
            "The computer has too little free memory for this step.",
            "Close other programs or hide parts of the mesh, then try again.",
        )
    return ErrorReport(
        "Something unexpected happened",
        f"{type(error).__name__}: {error}" if str(error) else type(error).__name__,
        "The window stays open and your work is still there: save it under a new name. "
        f"The full report is in {log_path()}.",
        report,
    )


def cause_of(error: BaseException) -> BaseException:
    """Exception that a view raised, out of the wrapping of the signal that it listens to."""
    while isinstance(error, EmitLoopError) and error.__cause__ is not None:
        error = error.__cause__
    return error


def sentence(message: str) -> str:
    """Message as a sentence: capital first, full stop last."""
    return message[:1].upper() + message[1:] + ("" if message.endswith((".", "!", "?")) else ".")


def log_to_file() -> None:
    """Write the program's log into the user's log folder; without one, go on silently."""
    try:
        log_path().parent.mkdir(parents=True, exist_ok=True)
        handler = logging.handlers.RotatingFileHandler(
            log_path(), maxBytes=1_000_000, backupCount=1, encoding="utf-8", delay=True
        )
    except OSError:
        return
    handler.setFormatter(logging.Formatter("%(asctime)s %(levelname)s %(message)s"))
    LOG.addHandler(handler)


class ErrorNet(QObject):
    """Catches what nobody caught, in any thread, and shows it from the GUI thread."""

    _caught = Signal(object)

    def __init__(self, show: Callable[[ErrorReport], None], parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._show = show
        self._showing = False
        self._before = (sys.excepthook, threading.excepthook)
        self._caught.connect(self._deliver, Qt.ConnectionType.QueuedConnection)
        sys.excepthook = self._hook
        threading.excepthook = lambda args: self._hook(
            args.exc_type, args.exc_value, args.exc_traceback
        )

    def close(self) -> None:
        """Put the former hooks back."""
        sys.excepthook, threading.excepthook = self._before

    def _hook(
        self,
        kind: type[BaseException],
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if issubclass(kind, KeyboardInterrupt) or error is None:
            self._before[0](kind, error or kind(), trace)
            return
        LOG.error("unexpected error", exc_info=(kind, error, trace))
        self._caught.emit(error)

    @Slot(object)
    def _deliver(self, error: BaseException) -> None:
        if self._showing:  # one dialog at a time: the others are in the log
            return
        self._showing = True
        try:
            self._show(problem_of(error))
        finally:
            self._showing = False
