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


def is_file(path: str | os.PathLike[str]) -> bool:
    """Whether there is a file; what cannot be looked at is none."""
    try:
        return Path(path).is_file()
    except (OSError, ValueError):
        return False


def is_same(path: str | os.PathLike[str], other: str | os.PathLike[str]) -> bool:
    """Whether both names are of one file or folder that is there."""
    try:
        return Path(path).samefile(other)
    except (OSError, ValueError):
        return False


def inside(folder: str | os.PathLike[str], name: str) -> Path:
    """Return the path of a file below a folder, wherever symbolic links lead.

    For names that come out of a file, and for folders that someone else may have filled: a
    link in there must not make us read or write elsewhere.

    Raises
    ------
    InputError
        If the path leaves the folder.

    Examples
    --------
    >>> inside("/tmp", "a/../../etc/passwd")
    Traceback (most recent call last):
        ...
    ffdstudio.errors.InputError: 'a/../../etc/passwd' leaves the folder /tmp
    """
    path = Path(folder, name)
    real, home = os.path.realpath(path), os.path.realpath(folder)
    if real != home and not real.startswith(os.path.join(home, "")):  # noqa: PTH118
        raise InputError(f"{name!r} leaves the folder {os.fspath(folder)}")
    return path


def refuse_links_out(folder: str | os.PathLike[str]) -> None:
    """Refuse a folder to be written on with a symbolic link in it that leads out of it.

    The names of a study's files are known, so that a link in a folder from elsewhere would
    choose which file of ours is overwritten.

    Raises
    ------
    InputError
        The message names the first such link.
    """
    for place, folders, files in os.walk(folder):
        for name in (*folders, *files):
            path = Path(place, name)
            if path.is_symlink():
                inside(folder, os.path.relpath(path, folder))
