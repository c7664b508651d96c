"""What is left when the program dies: autosaves, and finding those of dead sessions.

1. Each session has a folder of its own below the user's state folder, with an autosave of
   the project, its journal, and a note of what it was about.
2. It holds a lock on a file there for as long as it lives. The system drops the lock when
   the process ends in whatever way, so a folder whose lock is free belongs to a dead one;
   process numbers, which are given anew, play no part.
3. A session that ends properly removes its folder.
4. An autosave is written atomically from a snapshot: a crash in the middle of it leaves the
   one before.
"""

from __future__ import annotations

import json
import os
import shutil
import sys
import threading
import time
import uuid
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any

from ffdstudio.containers.strictjson import loads
from ffdstudio.errors import InputError
from ffdstudio.files import Stamp, read_bytes, stamp, write_bytes
from ffdstudio.paths import is_file
from ffdstudio.project.files.journal import Journal
from ffdstudio.project.files.records import ProjectFile
from ffdstudio.project.files.storage import write_project

LOCK, NOTE, PROJECT, JOURNAL = "lock", "session.json", "autosave.ffdproj", "journal.jsonl"
NEWBORN = 60.0  # seconds in which a session may still be setting up its folder


def recovery_folder() -> Path:
    """Folder of all sessions' autosaves."""
    from platformdirs import user_state_path

    return user_state_path("ffdstudio", appauthor=False) / "recovery"


@dataclass(frozen=True)
class Left:
    """What a session that died has left.

    Attributes
    ----------
    folder, autosave, journal : pathlib.Path
    project : pathlib.Path or None
        The project file that it was about.
    saved : float
        When it was saved, seconds since 1970.
    """

    folder: Path
    project: Path | None
    saved: float

    @property
    def autosave(self) -> Path:
        """The project as it was last saved automatically."""
        return self.folder / PROJECT

    @property
    def project_stamp(self) -> Stamp | None:
        """Stamp of the project file; one that fits none if it was written after the autosave."""
        if self.project is None or not is_file(self.project):
            return None
        found = stamp(self.project)
        return found if found is not None and found[2] <= self.saved * 1e9 else (0, 0, 0)

    @property
    def journal(self) -> Path:
        """The journal up to then."""
        return self.folder / JOURNAL

    def discard(self) -> None:
        """Remove it."""
        shutil.rmtree(self.folder, ignore_errors=True)


class Session:
    """The autosaves of this process.

    Parameters
    ----------
    folder : pathlib.Path, optional
        Where all sessions keep theirs; by default the user's state folder.

    Raises
    ------
    InputError
        If the folder cannot be made.
    """

    def __init__(self, folder: Path | None = None) -> None:
        parent = recovery_folder() if folder is None else folder
        self.folder = parent / uuid.uuid4().hex
        try:
            self.folder.mkdir(parents=True)
            self._lock: IO[bytes] | None = (self.folder / LOCK).open("wb")
        except OSError as error:
            cause = (error.strerror or str(error)).lower()
            raise InputError(f"cannot make the folder {self.folder}: {cause}") from error
        _take_lock(self._lock, wait=True)
        self._one_at_a_time = threading.Lock()

    def write(self, content: ProjectFile, journal: Journal, project: Path | None) -> None:
        """Write an autosave; for a worker. `InputError` if it cannot be written."""
        note = {"project": None if project is None else os.fspath(project), "saved": time.time()}
        with self._one_at_a_time:
            if self._lock is None:  # closed in the meantime
                return
            write_project(self.folder / PROJECT, content)
            journal.save(self.folder / JOURNAL)
            write_bytes(self.folder / NOTE, json.dumps(note).encode())

    def forget(self) -> None:
        """Remove the autosave: everything is in the project file."""
        with self._one_at_a_time:
            for name in (NOTE, PROJECT, JOURNAL):
                (self.folder / name).unlink(missing_ok=True)

    def close(self) -> None:
        """End the session properly."""
        with self._one_at_a_time:
            if self._lock is not None:
                lock, self._lock = self._lock, None
                lock.close()
                shutil.rmtree(self.folder, ignore_errors=True)


def left_behind(folder: Path | None = None) -> list[Left]:
    """Return what dead sessions have left, newest first; empty folders are cleared away."""
    parent, found = recovery_folder() if folder is None else folder, []
    for place in parent.iterdir() if parent.is_dir() else ():
        if place.is_dir() and not _alive(place):
            left = _left(place)
            if left is not None:
                found.append(left)
            elif time.time() - place.stat().st_mtime > NEWBORN:
                shutil.rmtree(place, ignore_errors=True)
    return sorted(found, key=lambda left: -left.saved)


def _left(place: Path) -> Left | None:
    try:
        note: dict[str, Any] = loads(read_bytes(place / NOTE), os.fspath(place / NOTE))
    except InputError:
        note = {}
    project, saved = note.get("project"), note.get("saved")
    if not (place / PROJECT).exists():
        return None
    when = saved if isinstance(saved, float) else (place / PROJECT).stat().st_mtime
    return Left(place, Path(project) if isinstance(project, str) else None, when)


def _alive(place: Path) -> bool:
    """Whether the session of a folder still holds its lock."""
    try:
        with (place / LOCK).open("ab") as lock:
            _take_lock(lock)
    except FileNotFoundError:
        return False
    except OSError:
        return True
    return False


def _take_lock(lock: IO[bytes], wait: bool = False) -> None:
    """Lock a file until it is closed; `OSError` if somebody else has."""
    if sys.platform == "win32":
        import msvcrt

        msvcrt.locking(lock.fileno(), msvcrt.LK_LOCK if wait else msvcrt.LK_NBLCK, 1)
        return
    import fcntl

    fcntl.flock(lock.fileno(), fcntl.LOCK_EX | (0 if wait else fcntl.LOCK_NB))
