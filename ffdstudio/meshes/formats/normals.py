"""Normals that a file stores beside its points, which do not follow a morph."""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

import numpy as np

from ffdstudio.aliases import Array
from ffdstudio.meshes.mesh import MeshWarning, Template


class _Patching(Template, Protocol):
    def patched(self, points: Array) -> bytes: ...


@dataclass(frozen=True, eq=False)
class WithNormals:
    """The template of a file with normals: writing it with moved points says that they are old."""

    template: _Patching
    what: str

    @property
    def original(self) -> Array:
        """(n, 3) coordinates as in the file."""
        return self.template.original

    def patched(self, points: Array) -> bytes:
        """File content with these (n, 3) coordinates."""
        return self.template.patched(points)

    def write(self, path: Path, points: Array) -> None:
        """Write the patched file; warn of normals that no longer fit."""
        self.template.write(path, points)
        if not np.array_equal(points, self.original):
            warnings.warn(
                f"{path.name}: the {self.what} of the file are kept as they were",
                MeshWarning,
                stacklevel=3,
            )
