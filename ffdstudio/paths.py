"""Looking at paths without a surprise: what cannot be looked at is not there."""

from __future__ import annotations

import os
from pathlib import Path

from ffdstudio.errors import InputError


def as_path(path: str | os.PathLike[str]) -> Path:
    """Return a path; raises `InputError` for what is none.

    Examples
    --------
    >>> as_path(None)
    Traceback (most recent call last):
        ...
    ffdstudio.errors.InputError: a path must be a text or a pathlib.Path, got None
    """
    try:
        return Path(path)
    except TypeError:
        raise InputError(f"a path must be a text or a pathlib.Path, got {path!r}") from None


def exists(path: str | os.PathLike[str]) -> bool:
    """Whether there is something; what cannot be looked at (too long a name) is not there.

    Examples
    --------
    >>> exists("."), exists("n" * 300)
    (True, False)
    """
    try:
        return Path(path).exists()
    except (OSError, ValueError):
        return False


def is_folder(path: str | os.PathLike[str]) -> bool:
    """Whether there is a folder; what cannot be looked at is none."""
    try:
        return Path(path).is_dir()
    except (OSError, ValueError):
        return False


def is_same(path: str | os.PathLike[str], other: str | os.PathLike[str]) -> bool:
    """Whether both names are of one file or folder that is there."""
    try:
        return Path(path).samefile(other)
    except (OSError, ValueError):
        return False
