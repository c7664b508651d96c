"""The command line: which subcommand, and how it ends.

1. Only the module of the subcommand that is called gets imported: ``--version`` and
   ``--help`` stay as fast as Python itself.
2. Exit codes: 0 done; 1 done, but the result breaks a promise; 2 bad input or usage, with
   one line on stderr; 130 interrupted.
3. Results go to stdout, everything else to stderr. One that is closed takes what it gets, and
   what an encoding cannot say is written as an escape: a result is not lost to its last word.
"""

from __future__ import annotations

import argparse
import contextlib
import importlib
import os
import sys
import warnings
from collections.abc import Callable, Sequence
from typing import NoReturn, TextIO

from ffdstudio.errors import InputError
from ffdstudio.version import __version__

COMMANDS = {
    "demo": "the paper's cases, headless, with pictures, a morphed mesh and a project",
    "info": "what a mesh, lattice or project file holds",
    "quality": "quality measures of a mesh, also against the undeformed one",
    "lattice": "put a lattice around a mesh or one of its markers",
    "morph": "deform meshes by a lattice",
    "fit": "find the lattice that turns one shape into another",
    "optimize": "run an optimization study from a case file",
    "compare": "adaptive lattices against static ones on many airfoils",
    "convert": "convert a lattice between file formats",
    "replay": "repeat the journal of a window without it",
}
_WINDOW = "PROJECT or MESH instead of a command, or nothing, opens the window"


def main(argv: Sequence[str] | None = None, run: Callable[[list[str]], int] | None = None) -> int:
    """Run the command line, or something else on its arguments, and return the exit code."""
    arguments = sys.argv[1:] if argv is None else list(argv)
    _open_streams()
    try:
        return guarded(arguments, run or _run)
    except BrokenPipeError:  # whoever read our output has gone: nothing left to say
        _drop_output()
        return 141
    except KeyboardInterrupt:
        return 130


def guarded(arguments: list[str], run: Callable[[list[str]], int]) -> int:
    """Run a command; whatever goes wrong in it becomes one line."""
    try:
        code = run(arguments)
        sys.stdout.flush()
        return code
    except InputError as error:
        return complain(str(error))
    except MemoryError:
        return complain("not enough memory")
    except BrokenPipeError:
        raise
    except OSError as error:  # standard output on a full disk, for example
        _drop_output()
        return complain(_sentence_of(error))
    except Exception as error:
        if os.environ.get("FFDSTUDIO_DEBUG"):
            raise
        return complain(
            f"a fault of ffdstudio itself, {type(error).__name__}: {error} "
            "(set FFDSTUDIO_DEBUG=1 to see where)"
        )


def _sentence_of(error: OSError) -> str:
    cause = str(error.strerror or error).lower()
    return cause if error.filename is None else f"{os.fsdecode(error.filename)}: {cause}"


def _open_streams() -> None:
    for name in ("stdout", "stderr"):
        stream = getattr(sys, name)
        if stream is None:
            setattr(sys, name, open(os.devnull, "w"))  # noqa: PTH123, SIM115 - for good
        elif hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="backslashreplace")


def _drop_output() -> None:
    """Send what is left of the output nowhere, or Python would fail on it again at its exit."""
    with contextlib.suppress(OSError):  # a standard output without a descriptor has no such end
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def complain(message: str) -> int:
    """Print the one line of a failure and return its exit code."""
    print("ffdstudio: error:", " ".join(message.split()), file=sys.stderr)
    return 2


class Parser(argparse.ArgumentParser):
    """Parser whose errors are `InputError`, so that they end like all others."""

    def error(self, message: str) -> NoReturn:
        """Refuse the arguments."""
        raise InputError(f"{message} (see {self.prog} --help)")


def _run(arguments: list[str]) -> int:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        warnings.showwarning = _show_warning
        return _command(arguments)


def _command(arguments: list[str]) -> int:
    name = next((word for word in arguments if not word.startswith("-")), "")
    parser = _parser(name)
    args = parser.parse_args(arguments)
    from ffdstudio.files import sources_kept

    command = importlib.import_module(f"ffdstudio.cli.{args.command}")
    from ffdstudio.meshes import MeshWarning

    warnings.simplefilter("always", MeshWarning)
    with sources_kept():
        return int(command.run(args))


def _parser(name: str) -> Parser:
    """Parser that knows all commands, and of the one called its arguments too."""
    parser = Parser(
        prog="ffdstudio",
        description="Adaptive free-form deformation of geometry and CFD meshes.",
        epilog=_WINDOW,
    )
    parser.add_argument("--version", action="version", version=f"ffdstudio {__version__}")
    commands = parser.add_subparsers(dest="command", metavar="COMMAND", required=True)
    for command, summary in COMMANDS.items():
        child = commands.add_parser(command, help=summary, description=_sentence(summary))
        if command == name:
            importlib.import_module(f"ffdstudio.cli.{command}").add(child)
    return parser


def command_parser(name: str) -> Parser:
    """Parser of one command, as the documentation prints it."""
    parser = Parser(prog=f"ffdstudio {name}", description=_sentence(COMMANDS[name]))
    importlib.import_module(f"ffdstudio.cli.{name}").add(parser)
    return parser


def _sentence(summary: str) -> str:
    return f"{summary[0].upper()}{summary[1:]}."


def _show_warning(
    message: Warning | str,
    category: type[Warning],
    filename: str,
    lineno: int,
    file: TextIO | None = None,
    line: str | None = None,
) -> None:
    print("ffdstudio: warning:", " ".join(str(message).split()), file=sys.stderr)
