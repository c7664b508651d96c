"""The program: the window for a project or a mesh, the command line for everything else.

The only place that knows both faces. No Qt is imported unless the window is wanted.
"""

from __future__ import annotations

import importlib
import os
import sys
from pathlib import Path, PurePath

from ffdstudio.cli.main import COMMANDS, complain
from ffdstudio.cli.main import main as command_line

READER = "--read-in-a-process-of-its-own"


def main() -> int:
    """Run `ffdstudio` and return the exit code."""
    arguments = sys.argv[1:]
    if arguments[:1] == [READER]:  # a frozen program, started by itself
        from ffdstudio.meshes.confined.child import main as read

        read()
    return command_line(arguments, _window if wants_window(arguments) else None)


def wants_window(arguments: list[str]) -> bool:
    """Whether this is no command line: nothing, or one or more existing files or folders.

    Examples
    --------
    >>> wants_window([]), wants_window(["--version"]), wants_window(["morph", "-h"])
    (True, False, False)
    """
    if not arguments:
        return True
    first = arguments[0]
    if first.startswith("-") or first in COMMANDS:
        return False
    there = os.path.exists(first)  # noqa: PTH110 - never raises, as Path.exists does
    return there or PurePath(first).suffix != "" or os.sep in first


def _window(paths: list[str]) -> int:
    for path in paths:
        try:
            Path(path).stat()
        except OSError as error:
            return complain(f"cannot open {path}: {(error.strerror or '').lower()}")
    if not _has_display():
        return complain(
            "there is no display for the window "
            "(ffdstudio demo and the other commands work without, see ffdstudio --help)"
        )
    try:
        for package in ("PySide6.QtWidgets", "pyvistaqt", "pyqtgraph"):
            importlib.import_module(package)
    except ImportError as error:  # a package, or a system library that Qt needs
        return complain(
            f"the window needs the gui extra: pip install 'ffdstudio[gui]' ({error}); "
            "the commands work without, see ffdstudio --help"
        )
    from ffdstudio.gui.app import run

    return run(paths)


def _has_display() -> bool:
    """Whether a window can be shown; Qt would abort the process instead of saying so."""
    if not sys.platform.startswith("linux"):
        return True
    names = ("DISPLAY", "WAYLAND_DISPLAY", "QT_QPA_PLATFORM")
    return any(os.environ.get(name) for name in names)


if __name__ == "__main__":
    sys.exit(main())
