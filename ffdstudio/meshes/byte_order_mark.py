"""Texts that begin with a byte-order mark: read without it, written with it."""

from __future__ import annotations

import codecs
import tempfile
from dataclasses import dataclass
from pathlib import Path

from ffdstudio.aliases import Array
from ffdstudio.errors import InputError
from ffdstudio.files import at_once, read_bytes, write_bytes
from ffdstudio.meshes.mesh import Template

MARK = codecs.BOM_UTF8


@dataclass(frozen=True, eq=False)
class Marked:
    """The template of a text that begins with the mark."""

    template: Template

    @property
    def original(self) -> Array:
        """(n, 3) coordinates as in the file."""
        return self.template.original

    def write(self, path: Path, points: Array) -> None:
        """Write the file with the mark before it.

        Raises
        ------
        InputError
            If it writes more than one file.
        """
        with tempfile.TemporaryDirectory() as folder:
            with at_once():
                self.template.write(Path(folder) / path.name, points)
            if len(list(Path(folder).iterdir())) != 1:
                raise InputError(f"{path}: a deck of several files must not have a byte-order mark")
            data = read_bytes(Path(folder) / path.name, to_update=True)
        write_bytes(path, MARK + data)
