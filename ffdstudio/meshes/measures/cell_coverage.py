"""Which cells of a mesh the checks for inversion look at, and which they do not.

What is not looked at may turn inside out unseen. So whoever says "safe" or "no inverted cells"
says beside it, or instead, how many cells were not checked and of which types.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, field
from weakref import WeakKeyDictionary

from ffdstudio.meshes.measures.bezier import folded
from ffdstudio.meshes.measures.blocks import blocks_of, is_checkable, is_seen, top_dimension
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


_known: WeakKeyDictionary[Mesh, Coverage] = WeakKeyDictionary()


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
    if mesh not in _known:
        _known[mesh] = _covered(mesh)
    return _known[mesh]


def _covered(mesh: Mesh) -> Coverage:
    if mesh.faces is not None:
        return Coverage(mesh.faces.counts, dict(mesh.unread))
    checked: Counter[str] = Counter()
    unchecked: Counter[str] = Counter()
    top = top_dimension(mesh.cells)
    for kind, nodes in mesh.cells.items():
        if not is_checkable(kind) and dimension(kind) > 1 and len(nodes):
            unchecked[kind] += len(nodes)
        elif dimension(kind) == top > 1 and len(nodes):
            _count(mesh, kind, checked, unchecked)
    return Coverage(dict(+checked), dict(unchecked + Counter(mesh.unread)))


def _count(mesh: Mesh, kind: str, checked: Counter[str], unchecked: Counter[str]) -> None:
    """Count cells of a type; those of higher order only as far as they are good to begin with.

    What is folded at rest, or lists its nodes in another order than is thought here, cannot be
    told from what a deformation has folded.
    """
    count = len(mesh.cells[kind])
    if not is_seen(kind):
        unchecked[kind] += count
        return
    curved = [block for block in blocks_of(mesh).curved if block.type == kind]
    bad = sum(int(folded(block, mesh.points).sum()) for block in curved)
    checked[kind] += count - bad
    unchecked[f"{kind} folded at rest"] += bad


def together(parts: Iterable[Coverage]) -> Coverage:
    """Coverage of several bodies as one."""
    checked: Counter[str] = Counter()
    unchecked: Counter[str] = Counter()
    for part in parts:
        checked.update(part.checked)
        unchecked.update(part.unchecked)
    return Coverage(dict(checked), dict(unchecked))
