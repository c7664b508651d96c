"""What a study would run on this computer, where the order came from, and whether it may.

1. What the user says here and now is trusted: a case named on the command line, a form filled
   in, a call from Python.
2. What came inside a file, a project or the folder of a record, is a stranger's word: it runs
   after the user has agreed to just that, with ``--trust`` or by a question in the window.
3. A program is looked up on the PATH, or beside the case by a path that says so (``./solve``):
   a file that happens to lie there under the name of a program is never taken for it.

Both faces decide through `require`; the window passes a `Consent` that knows how to ask.
"""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

from ffdstudio.errors import InputError
from ffdstudio.paths import exists, is_file, is_folder

Kind = Literal["program", "function"]


class NotTrusted(InputError):
    """A program or function that came inside a file was not agreed to."""


@dataclass(frozen=True)
class Order:
    """What a study asks to be run.

    Attributes
    ----------
    kind : {"program", "function"}
    words : tuple of str
        The command, or ``("module:function",)``.
    source : pathlib.Path or None
        The project file or folder of a record that it came inside; None if the user says it.
    """

    kind: Kind
    words: tuple[str, ...]
    source: Path | None = None

    @property
    def sentence(self) -> str:
        """What to ask the user.

        Examples
        --------
        >>> Order("program", ("sh", "-c", "echo"), Path("wing.ffdproj")).sentence
        "wing.ffdproj asks to run the program 'sh -c echo' on this computer"
        """
        verb = "run" if self.kind == "program" else "import and call"
        what = " ".join(self.words)
        name = "The study" if self.source is None else self.source.name
        return f"{name} asks to {verb} the {self.kind} {what!r} on this computer"


@dataclass
class Consent:
    """What the user has agreed to, and how to ask for more.

    Attributes
    ----------
    everything : bool
        Whether to run whatever is ordered: ``--trust``.
    ask : callable, optional
        Called with an `Order`, returns whether the user agrees; without it nobody is asked
        and the answer is no. The window's seam: it is called in the thread that begins a study.
    agreed : set of Order
        What has been agreed to; it is not asked for again while this object lives.
    """

    everything: bool = False
    ask: Callable[[Order], bool] | None = None
    agreed: set[Order] = field(default_factory=set)

    def allows(self, order: Order) -> bool:
        """Whether an order may be carried out; asks the user where that is the way."""
        if order.source is None or self.everything or order in self.agreed:
            return True
        if self.ask is None or not self.ask(order):
            return False
        self.agreed.add(order)
        return True


def require(order: Order, consent: Consent) -> None:
    """Refuse an order that came inside a file and is not agreed to.

    Raises
    ------
    NotTrusted
        The message says what would run and how to agree.

    Examples
    --------
    >>> require(Order("program", ("solve",)), Consent())
    >>> require(Order("program", ("solve",), Path("a.ffdproj")), Consent())
    Traceback (most recent call last):
        ...
    ffdstudio.optimize.consent.NotTrusted: a.ffdproj asks to run the program 'solve' on this \
computer: give --trust if you trust where it came from
    """
    if not consent.allows(order):
        raise NotTrusted(f"{order.sentence}: give --trust if you trust where it came from")


def source_of(path: str | os.PathLike[str]) -> Path | None:
    """Where an order comes from that is read out of `path`.

    A case file that the user names is the user's own word. A project and the folder of a record
    hold what somebody has put there, along with much else that nobody reads first.

    Examples
    --------
    >>> source_of("wing.toml"), source_of("wing.ffdproj")
    (None, PosixPath('wing.ffdproj'))
    """
    place = Path(path)
    inside = is_folder(place) or place.suffix.lower() == ".ffdproj"
    return place if inside else None


def located(command: Sequence[str], beside: Path) -> list[str]:
    """Return a command whose program is an absolute path.

    Parameters
    ----------
    command : sequence of str
        Program and arguments.
    beside : pathlib.Path
        Folder that paths in the command are relative to.

    Returns
    -------
    list of str
        Arguments that are paths of files beside it (with a slash in them) become absolute too;
        others stay as they are.

    Raises
    ------
    InputError
        If there is no such program.

    Examples
    --------
    >>> located(["sh", "-c", "true"], Path("/tmp"))[1:]
    ['-c', 'true']
    """
    if not command:
        raise InputError("the external program has no command")
    return [_program(command[0], beside), *(_argument(word, beside) for word in command[1:])]


def _program(word: str, beside: Path) -> str:
    if _is_path(word):
        path = beside / word
        if not is_file(path):
            raise InputError(f"there is no program {path}")
        return os.path.abspath(path)  # noqa: PTH100 - keeps symbolic links as they are
    found = shutil.which(word, path=_search_path())
    if found is None:
        hint = f"; that in {beside} is ./{word}" if is_file(beside / word) else ""
        raise InputError(f"there is no program {word!r} on the PATH{hint}")
    return found


def _search_path() -> str:
    """The PATH without its relative entries, which mean whatever folder one stands in."""
    entries = os.environ.get("PATH", os.defpath).split(os.pathsep)
    return os.pathsep.join(entry for entry in entries if os.path.isabs(entry))  # noqa: PTH117


def _argument(word: str, beside: Path) -> str:
    path = beside / word
    return str(path.resolve()) if _is_path(word) and exists(path) else word


def _is_path(word: str) -> bool:
    return "/" in word or os.sep in word
