"""Folders of running studies: made when they are needed, removed with their owner."""

from __future__ import annotations

import tempfile
from pathlib import Path


class StudyFolders:
    """Temporary folders, one for each study; gone after `close`, or when the process ends.

    Examples
    --------
    >>> folders = StudyFolders()
    >>> place = folders.of("study1")
    >>> place.is_dir(), folders.close(), place.exists()
    (True, None, False)
    """

    def __init__(self) -> None:
        self._root: tempfile.TemporaryDirectory[str] | None = None
        self._used = 0

    def of(self, key: str) -> Path:
        """A new, empty folder for a run of a study."""
        if self._root is None:
            self._root = tempfile.TemporaryDirectory(
                prefix="ffdstudio-studies-", ignore_cleanup_errors=True
            )
        self._used += 1
        place = Path(self._root.name) / f"{key}-{self._used}"
        place.mkdir()
        return place

    def close(self) -> None:
        """Remove all of them."""
        if self._root is not None:
            self._root.cleanup()
            self._root = None
