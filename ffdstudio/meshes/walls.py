"""Which boundaries are what the user came for: walls, as against what lies far around them.

The file tells of some (`Mesh.kinds`); else a marker that is much smaller than the mesh is a
wall. Planes that the mesh ends at never are.
"""

from __future__ import annotations

from weakref import WeakKeyDictionary

import numpy as np

from ffdstudio.meshes.mesh import Mesh
from ffdstudio.meshes.planes import planes_of, size_of
from ffdstudio.meshes.quasi2d import slab_of

SMALL = 0.25  # of the diagonal of the whole mesh: a marker that is smaller is a wall

_known: WeakKeyDictionary[Mesh, tuple[str, ...]] = WeakKeyDictionary()


def wall_markers(mesh: Mesh) -> tuple[str, ...]:
    """Boundaries that are walls in a far field; none if all are, or none is.

    Examples
    --------
    >>> lines = {"wall": {"line": [[0, 1]]}, "far": {"line": [[1, 2], [2, 3]]}}
    >>> points = [[0, 0, 0], [1, 0, 0], [50, 0, 0], [0, 50, 0]]
    >>> wall_markers(Mesh(points, {"triangle": [[0, 1, 3], [1, 2, 3]]}, lines, dimension=2))
    ('wall',)
    """
    if mesh not in _known:
        _known[mesh] = _found(mesh)
    return _known[mesh]


def _found(mesh: Mesh) -> tuple[str, ...]:
    names = [name for name in mesh.boundaries if _lies(mesh, name)]
    small = tuple(name for name in names if _size(mesh, name) <= SMALL * size_of(mesh))
    return small if len(small) < len(mesh.boundaries) else ()


def _lies(mesh: Mesh, name: str) -> bool:
    """Whether a boundary has elements and is no plane that the mesh ends at."""
    slab = slab_of(mesh)
    ends = {plane.name for plane in planes_of(mesh)} | set(slab.markers if slab else ())
    return name not in ends and len(mesh.marker_nodes(name)) > 0


def _size(mesh: Mesh, name: str) -> float:
    places = mesh.points[mesh.marker_nodes(name)]
    return float(np.linalg.norm(np.ptp(places, axis=0)))
