"""A disk that loses what was not flushed: the states in which a power loss may leave a folder.

Everything that is written goes to the real disk; beside it a list is kept of what a flush has
made durable. The content of a file is sure when it was flushed (fsync), a name when its folder
was. What was not may be there in part, in full or not at all, names in any combination.
"""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterator
from pathlib import Path

import numpy as np

Names = dict[str, int]  # name -> number of the file behind it


class Disk:
    """Watches one folder while something writes in it."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.names = self._listed()  # durable names
        self.sure = {number: self._content(name) for name, number in self.names.items()}
        self.pending: list[tuple[str, str, int]] = []  # name operations since the folder's flush
        self.moments: list[tuple[Names, dict[int, bytes], list[tuple[str, str, int]]]] = []
        self.flushes = True

    def _listed(self) -> Names:
        return {p.name: p.stat().st_ino for p in self.folder.iterdir() if p.is_file()}

    def _content(self, name: str) -> bytes:
        return (self.folder / name).read_bytes()

    def _moment(self) -> None:
        """A power loss may come here."""
        self.moments.append((dict(self.names), dict(self.sure), list(self.pending)))

    @contextlib.contextmanager
    def in_place(self) -> Iterator[None]:
        """Watch flushes, renames, links and removals."""
        fsync, replace, unlink, link = os.fsync, Path.replace, Path.unlink, os.link

        def flushed(descriptor: int) -> None:
            fsync(descriptor)
            self._moment()
            path = Path(f"/proc/self/fd/{descriptor}").readlink()
            if not self.flushes:
                return
            if path == self.folder:
                self.names, self.pending = self._listed(), []
            elif path.parent == self.folder:
                self.sure[path.stat().st_ino] = path.read_bytes()

        def replaced(path: Path, target: Path) -> Path:
            number = path.stat().st_ino
            self._moment()
            done = replace(path, target)
            if Path(target).parent == self.folder:
                self.pending += [("put", Path(target).name, number), ("gone", path.name, number)]
            return done

        def unlinked(path: Path, *args: bool, **kwargs: bool) -> None:
            self._moment()
            if path.parent == self.folder and path.exists():
                self.pending.append(("gone", path.name, path.stat().st_ino))
            unlink(path, *args, **kwargs)

        def linked(path: Path, name: Path) -> None:
            self._moment()
            link(path, name)
            self.pending.append(("put", Path(name).name, Path(name).stat().st_ino))

        os.fsync, Path.replace, Path.unlink, os.link = flushed, replaced, unlinked, linked
        try:
            yield
        finally:
            os.fsync, Path.replace, Path.unlink, os.link = fsync, replace, unlink, link
        self._moment()

    def losses(self, rng: np.random.Generator, each: int) -> Iterator[dict[str, bytes]]:
        """Folders as they may be found after a power loss: for every moment some of them."""
        for names, sure, pending in self.moments:
            for k in range(each):
                found = dict(names)
                kept = [op for op in pending if (k == 0 or rng.integers(2)) and k != 1]
                for what, name, number in kept:  # k = 0: all of them, 1: none, else some
                    if what == "put":
                        found[name] = number
                    elif found.get(name) == number:
                        del found[name]
                yield {name: sure.get(number, b"torn") for name, number in found.items()}
