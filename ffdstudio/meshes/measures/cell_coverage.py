"""Which cells of a mesh the checks for inversion look at, and which they do not.

What is not looked at may turn inside out unseen. So whoever says "safe" or "no inverted cells"
says beside it, or instead, how many cells were not checked and of which types.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, field

from ffdstudio.meshes.measures.blocks import is_checkable, top_dimension
from ffdstudio.meshes.mesh import Mesh
from ffdstudio.meshes.topology import dimension


@dataclass(frozen=True)
class Coverage:
    """Cells that are checked, and those that are not, by type.

    Attributes
    ----------
    checked, unchecked : dict
        Type -> number of cells. Types are named as in `Mesh.cells`, or as their file names
        them where they are not known here.

    Examples
    --------
    >>> str(Coverage({"tetra": 4}, {"CSHEAR": 2, "CQUADX4": 1}))
    '3 cells not checked (2 CSHEAR, 1 CQUADX4)'
    """

    checked: dict[str, int] = field(default_factory=dict)
    unchecked: dict[str, int] = field(default_factory=dict)

    @property
    def missing(self) -> int:
        """Number of cells that are not checked."""
        return sum(self.unchecked.values())

    def __str__(self) -> str:
        if not self.missing:
            return "all cells checked"
        kinds = ", ".join(f"{count} {kind}" for kind, count in self.unchecked.items())
        return f"{self.missing} {'cell' if self.missing == 1 else 'cells'} not checked ({kinds})"


def coverage(mesh: Mesh) -> Coverage:
    """Tell which cells of a mesh are checked for inversion.

    Faces of volume cells, lines and single nodes cannot be turned inside out by themselves and
    count as neither.

    Examples
    --------
    >>> mesh = Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], {"triangle": [[0, 1, 2]]})
    >>> coverage(mesh).checked
    {'triangle': 1}
    """
    if mesh.faces is not None:
        return Coverage(mesh.faces.counts, dict(mesh.unread))
    checked: Counter[str] = Counter()
    unchecked: Counter[str] = Counter()
    top = top_dimension(mesh.cells)
    for kind, nodes in mesh.cells.items():
        if not is_checkable(kind) and dimension(kind) > 1 and len(nodes):
            unchecked[kind] += len(nodes)
        elif dimension(kind) == top > 1 and len(nodes):
            checked[kind] += len(nodes)
    return Coverage(dict(checked), dict(unchecked + Counter(mesh.unread)))


def together(parts: Iterable[Coverage]) -> Coverage:
    """Coverage of several bodies as one."""
    checked: Counter[str] = Counter()
    unchecked: Counter[str] = Counter()
    for part in parts:
        checked.update(part.checked)
        unchecked.update(part.unchecked)
    return Coverage(dict(checked), dict(unchecked))
