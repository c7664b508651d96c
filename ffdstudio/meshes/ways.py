"""How a mesh can follow a lattice."""

from __future__ import annotations

from enum import StrEnum


class Way(StrEnum):
    """The lattice moves the walls and the volume follows them, or it carries all nodes."""

    WALLS = "walls"
    LATTICE = "lattice"
